"""What places far away may give a photosite: where curves need not be followed as closely as within the frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64
from camsim.scene.curves import Curves
from camsim.scene.stretches import stretches

NO_LIGHT = 1e-60  # of a Gaussian far out: anything will do there


class Away(NamedTuple):
    """Light that comes from outside a circle; lengths in pitches, places complex.

    centre, radius : about all photosites and all that they reach
    near  : distance from the circle up to which everything is near
    light : (octaves,) the most light that a square pitch gives a photosite from near·2ᵏ on, falling
    """

    centre: complex
    radius: float
    near: float
    light: F64

    def distance(self, place: C128, half: F64) -> F64:
        """Return how far from the circle all within ``half`` of places (n,) is at least; below 0 in it."""
        distance: F64 = np.abs(place - self.centre) - self.radius - half
        return distance

    def light_from(self, distance: F64) -> F64:
        """Return the most light per square pitch from so far away (n,) and farther; infinite where that is near."""
        octave = np.floor(np.log2(np.maximum(distance, 0.5 * self.near) / self.near)).astype(np.int64)
        light = self.light[np.clip(octave, 0, len(self.light) - 1)]
        return np.where(octave < 0, np.inf, np.maximum(light, NO_LIGHT))

    def loudness(self, distance: F64) -> F64:
        """Return that light times how far it is from the circle's middle: a measure of an octave's."""
        loudness: F64 = self.light_from(distance) * (np.maximum(distance, self.near) + self.radius)
        return loudness

    def reached_by(self, curves: Curves) -> bool:
        """Return whether any of curves comes out of what is near."""
        low_x, low_y, high_x, high_y = (curves.boxes - np.tile([self.centre.real, self.centre.imag], 2)).T
        out = np.hypot(np.maximum(-low_x, high_x), np.maximum(-low_y, high_y))
        return bool((out > self.radius + self.near).any())

    def much_of(self, curves: Curves) -> float:
        """Return how much of curves is far away: lengths over distances from the middle, at least 1."""

        def from_middle(place: F64) -> F64:
            away: F64 = np.abs(place[:, 0] + 1j * place[:, 1] - self.centre)
            return away

        found = stretches(curves, lambda place, length: np.maximum(0.5 * from_middle(place), self.near))
        return max(1.0, float(np.sum(found.length_um / np.maximum(from_middle(found.place_um), self.near))))
