"""Cutoff radii of a PSF's ringing, with the wavelengths of a spectrum added as phasors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from camsim.core.arrays import C128, F64
from camsim.core.cached import cached_property
from camsim.numerics.matrix_products import product
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.falling import falls_to
from camsim.rendering.footprint import Footprint
from camsim.rendering.spectral import different

Front: TypeAlias = Literal["end", "line", "focus"]
NEAREST = 5.0  # λN: where the search begins
STEP, AT_ONCE = 0.25, 32  # largest step of the search in λN, and places evaluated together
DULL = 3.0  # bound of a spectrum's ringing over its leading term: up to twice it was measured at 6 λN


@dataclass(frozen=True, kw_only=True, eq=False)
class Waves:
    """The ringing of a spectrum behind a footprint.

    blur   : (j,) λN at every wavelength, pitches
    shares : (k, j) weights of every pair of spectra and channel, relative to that channel's full scale
    """

    pattern: Pattern
    blur: F64
    shares: F64
    footprint: Footprint

    def negligible_distance(
        self, allowed: float, *, front: Front, least: float = 0.0, within: float = math.inf
    ) -> float:
        """Return the distance beyond which ringing stays below ``allowed``, pitches.

        front  : ringing at an edge's "end"; across a whole "line", twice that; or in the "focus" of a whole circle,
                 where it lacks the loss 4π√(u·ρ) of an end by its varying phase
        least  : distances up to this one are not distinguished
        within : upper bound of the result
        """
        if not self.pattern.rings or not len(self.shares):  # a scene without edges has no weights
            return 0.0
        shortest, longest = float(self.blur.min()), float(self.blur.max())
        rings = [_at(front, ring) for ring in self.pattern.rings]
        powers = np.array([power for _, _, power in rings])
        strongest_in_step = np.array([a * np.abs(self._phasors(u, power)).sum(axis=1).max() for u, a, power in rings])
        farthest = min(falls_to(allowed, strongest_in_step, powers), within)
        if shortest == longest or farthest <= NEAREST * longest:
            return farthest
        step = self._step
        count = math.ceil((farthest + longest - NEAREST * longest) / (step * longest))
        # Search backwards for the last place above: a spectrum's cutoff is not far below that of waves in phase.
        nearest = max(0, math.floor((least / longest - NEAREST) / (step * AT_ONCE)))
        for block in range((count - 1) // AT_ONCE, nearest - 1, -1):
            strongest = np.sum([amplitude * self._left(u, power, block) for u, amplitude, power in rings], axis=0)
            strength = np.flatnonzero(strongest[: count - block * AT_ONCE] > allowed)
            if strength.size:
                return longest * (NEAREST + step * min(block * AT_ONCE + int(strength[-1]) + 1, count - 1))
        return NEAREST * longest

    def _phasors(self, u: float, power: float) -> F64:
        """Return the amplitudes (n, j) of unit ringing at every wavelength, for each direction and set of weights."""
        if (u, power) not in self._loudness:
            strength_of = self.blur**power * self._transfer(u)
            self._loudness[u, power] = (self.different[None] * strength_of[:, None]).reshape(-1, self.blur.size)
        return self._loudness[u, power]

    def _transfer(self, u: float) -> F64:
        """Return the footprint's transfer (directions, j) for ringing at every wavelength."""
        if u not in self._transfers:
            self._transfers[u] = self.footprint.transfer(u / self.blur)
        return self._transfers[u]

    def _left(self, u: float, power: float, block: int) -> F64:
        """Return the spectrum's sum of unit ringing at a block of distances, for the strongest set of weights."""
        if (u, power, block) not in self._counted:
            distance = float(self.blur.max()) * (
                NEAREST + self._step * np.arange(block * AT_ONCE, (block + 1.0) * AT_ONCE)
            )
            wave, phasors = _rotations(distance, u / self.blur), self._phasors(u, power).T
            # The amplitudes are real: a complex product would cost twice as much.
            real, imaginary = (product(part, phasors) for part in (wave.real, wave.imag))
            counted = np.sqrt((real**2 + imaginary**2).max(axis=1))
            self._counted[u, power, block] = DULL * counted * distance**-power
        return self._counted[u, power, block]

    @cached_property
    def _step(self) -> float:
        """Step of the search in the longest λN: small enough to resolve the fastest beat between wavelengths.

        Wavelengths of ratio 1 : 5 go in or out of phase at every quarter of the longest.
        """
        beats = float(self.blur.max() / self.blur.min()) - 1.0
        return STEP / max(1.0, beats)

    @cached_property
    def different(self) -> F64:
        """Sets of weights (k, j) of which no two are proportional: of proportional sets only the largest is kept."""
        return different(self.shares)

    @cached_property
    def _transfers(self) -> dict[float, F64]:
        return {}

    @cached_property
    def _loudness(self) -> dict[tuple[float, float], F64]:
        return {}

    @cached_property
    def _counted(self) -> dict[tuple[float, float, int], F64]:
        return {}


def _rotations(distance: F64, freq: F64) -> C128:
    """Return exp(2πi·distance·frequency) (n, j) at evenly spaced distances (n,), as products of two factors.

    This takes 2√n exponentials per frequency instead of n.
    """
    some = math.isqrt(distance.size) + 1
    first, steps = distance[::some], distance[:some] - distance[0]
    phasors: C128 = np.exp(2j * np.pi * first[:, None] * freq)[:, None] * np.exp(2j * np.pi * steps[:, None] * freq)
    return phasors.reshape(-1, freq.size)[: distance.size]


def _at(front: Front, ring: tuple[float, float, float]) -> tuple[float, float, float]:
    u, amplitude, power = ring
    if front == "focus":
        return u, 4.0 * math.pi * math.sqrt(u) * amplitude, power - 0.5
    return u, (2.0 if front == "line" else 1.0) * amplitude, power
