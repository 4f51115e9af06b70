"""What the check takes far places for: how loud they are, by a round lens's own light there, found otherwise than by
the engines. Where that is little, curves need not be followed as closely as within the frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64
from camsim.optics import RoundLens
from camsim.rendering.check.pattern import oscillation, smooth_powers
from camsim.rendering.job import Job
from camsim.scene.curves import Curves
from camsim.scene.stretches import stretches

NEAR = 8.0  # longest blurs: what is nearer is near
OCTAVES = 64
LISTENED = 6  # octaves in which rings are looked at; farther out they fall on
WAVES, PER_WAVE = 3, 8
LOUDER = 2.0  # times, than in any of these places
FALLS = 1.5  # at least this power of the distance is what rings fall with
NO_LIGHT = 1e-60  # of a Gaussian far out: anything will do there


class FromAfar(NamedTuple):
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

    def enough(self, begin: C128, finish: C128, allowed: float) -> F64:
        """Return how far off curves between places (n,) may be that are no longer than they are far away, 0 for others.

        allowed : over how much of curves there is: all that lies between, as much of each octave of distance
        """
        length = np.abs(finish - begin)
        distance = self.distance(0.5 * (begin + finish), 0.5 * length)
        loud = self.light_from(distance) * (np.maximum(distance, self.near) + self.radius)
        return np.where((distance > 0.0) & (length <= distance), allowed / loud, 0.0)

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


def from_afar(job: Job, wavelength_nm: F64) -> FromAfar | None:
    """Return what is known of a job's light from far away: that of a round lens alone.

    Light is E's slope over 2πr: its powers' and its rings', which have no shorter wave.
    """
    lens = job.system.lens
    if job.pattern is None or job.bending is not None or not isinstance(lens, RoundLens):
        return None
    grid = job.grid
    highest = job.system.highest_per_um(wavelength_nm) * grid.pitch_um
    blur = np.unique(job.blur_at(np.array([wavelength_nm.min(), wavelength_nm.max()])))
    longest, each = float(blur.max()), np.eye(blur.size)
    distance = NEAR * longest * 2.0 ** np.arange(OCTAVES)
    heard = distance[:LISTENED, None] + longest / PER_WAVE * np.arange(WAVES * PER_WAVE)
    rings = np.abs(oscillation(lens, blur, each, heard.ravel(), job.tolerance))
    swing = np.empty(OCTAVES)
    swing[:LISTENED] = LOUDER * rings.reshape(blur.size, LISTENED, -1).max(axis=(0, 2))
    swing[LISTENED:] = swing[LISTENED - 1] * (distance[LISTENED:] / distance[LISTENED - 1]) ** -FALLS
    powers = np.abs(smooth_powers(lens, blur, each)[:, 1:])
    slopes = np.stack([n * distance ** -(n + 1.0) for n in (1, 3, 5)])
    light = ((powers @ slopes).max(axis=0) + math.tau * highest * swing) / (math.tau * distance)
    size = np.array([grid.cols - 1.0, grid.rows - 1.0])
    x, y = np.array(grid.first_centre) + 0.5 * size
    return FromAfar(
        complex(x, y),
        0.5 * float(np.hypot(*size)) + job.extent,
        float(distance[0]),
        np.maximum.accumulate(light[::-1])[::-1],
    )
