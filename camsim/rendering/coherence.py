"""How far a pattern's rings are heard: where the wavelengths of a spectrum, added as phasors, fall silent."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from camsim.core.arrays import C128, F64
from camsim.core.cached import cached_property
from camsim.numerics.matrix_products import product
from camsim.optics.pattern import Pattern
from camsim.rendering.falling import falls_to
from camsim.rendering.footprint import Footprint
from camsim.rendering.spectral import different

Front: TypeAlias = Literal["end", "line", "focus"]
NEAREST = 5.0  # blurs: where the search for quiet begins
STEP, AT_ONCE = 0.25, 32  # blurs from one place of the search to the next at most, and places looked at together
DULL = 3.0  # what many wavelengths leave is not the leading term alone: measured up to twice it at 6 λN


@dataclass(frozen=True, kw_only=True, eq=False)
class Waves:
    """A spectrum's rings as a footprint takes them.

    blur   : (j,) the pattern's own length at every wavelength, pitches
    shares : (k, j) weights of every weight set, relative to that channel's full scale
    """

    pattern: Pattern
    blur: F64
    shares: F64
    footprint: Footprint

    def negligible_distance(
        self, allowed: float, *, front: Front, least: float = 0.0, within: float = math.inf
    ) -> float:
        """Distance beyond which what oscillates stays below ``allowed``; any up to ``least`` where that is enough.

        front : at an edge's "end"; across a whole "line", twice that; or in the "focus" of a whole circle
                (focus.py), where what an end has lost by its running phase, 4π√(u·ρ), is not lost

        It is looked for ``within`` a distance; there may be none, and then it is that one.
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
        # The last loud place is asked for: wavelengths that fall silent do so not long before those in step would.
        nearest = max(0, math.floor((least / longest - NEAREST) / (step * AT_ONCE)))
        for block in range((count - 1) // AT_ONCE, nearest - 1, -1):
            strongest = np.sum([amplitude * self._left(u, power, block) for u, amplitude, power in rings], axis=0)
            strength = np.flatnonzero(strongest[: count - block * AT_ONCE] > allowed)
            if strength.size:
                return longest * (NEAREST + step * min(block * AT_ONCE + int(strength[-1]) + 1, count - 1))
        return NEAREST * longest

    def passed(self, normals: F64) -> F64:
        """Return shares (n,) of the loudest direction's rings: what no wavelength's are louder than, square on edges
        with such normals (n, 2)."""
        angle = self.footprint.angles(self.blur.size)
        strongest = np.zeros(angle.size)
        for u, _, _ in self.pattern.rings:
            size = np.abs(self._transfer(u))
            strongest = np.maximum(strongest, (size / size.max(axis=0)).max(axis=1))
        x, y = self.footprint.folded(normals).T
        place = (angle[0] - np.arctan2(y, x)) / (angle[0] - angle[1])
        step = np.clip(place.astype(np.int64), 0, angle.size - 2)
        between: F64 = np.maximum(strongest[:-1], strongest[1:])[step]
        return between

    def _phasors(self, u: float, power: float) -> F64:
        """Return (n, j) how loud a ring of amplitude 1 is at every wavelength, of each weight set and of the OLPF's."""
        if (u, power) not in self._loudness:
            strength_of = self.blur**power * self._transfer(u)
            self._loudness[u, power] = (self.different[None] * strength_of[:, None]).reshape(-1, self.blur.size)
        return self._loudness[u, power]

    def _transfer(self, u: float) -> F64:
        """Return (directions, j) what the footprint lets pass of a ring at every wavelength."""
        if u not in self._transfers:
            self._transfers[u] = self.footprint.transfer(u / self.blur)
        return self._transfers[u]

    def _left(self, u: float, power: float, block: int) -> F64:
        """Return what the wavelengths' sum leaves of a ring of amplitude 1 at distances, of the loudest weight set."""
        if (u, power, block) not in self._counted:
            distance = float(self.blur.max()) * (
                NEAREST + self._step * np.arange(block * AT_ONCE, (block + 1.0) * AT_ONCE)
            )
            wave, phasors = _turns(distance, u / self.blur), self._phasors(u, power).T
            # Phasors are real: as complex ones they would be multiplied twice.
            real, imaginary = (product(part, phasors) for part in (wave.real, wave.imag))
            counted = np.sqrt((real**2 + imaginary**2).max(axis=1))
            self._counted[u, power, block] = DULL * counted * distance**-power
        return self._counted[u, power, block]

    @cached_property
    def _step(self) -> float:
        """Longest blurs from one place of the search to the next: a quarter of the fastest beat, too.

        Wavelengths of 1 : 5 are in step, or out of it, at every quarter of the longest.
        """
        beats = float(self.blur.max() / self.blur.min()) - 1.0
        return STEP / max(1.0, beats)

    @cached_property
    def different(self) -> F64:
        """Weight sets (k, j) of which none is another one times a number: the others are never the loudest."""
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


def _turns(distance: F64, freq: F64) -> C128:
    """Return (n, j) exp(2πi·distance·frequency) at even distances (n,), each a multiple of some and some steps.

    Of n exponentials 2√n are left.
    """
    some = math.isqrt(distance.size) + 1
    first, steps = distance[::some], distance[:some] - distance[0]
    turns: C128 = np.exp(2j * np.pi * first[:, None] * freq)[:, None] * np.exp(2j * np.pi * steps[:, None] * freq)
    return turns.reshape(-1, freq.size)[: distance.size]


def _at(front: Front, ring: tuple[float, float, float]) -> tuple[float, float, float]:
    u, amplitude, power = ring
    if front == "focus":
        return u, 4.0 * math.pi * math.sqrt(u) * amplitude, power - 0.5
    return u, (2.0 if front == "line" else 1.0) * amplitude, power
