"""Nodes of a pupil along chords: strips between its corners and its obstruction's ends, a rule along and one across.

Chords run along a side of a polygon.
"""

from __future__ import annotations

import functools
import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.optics.follow import Turns
from camsim.optics.panels import OverPupil, PanelRule, panels_of
from camsim.optics.pupil import Pupil

NARROW = 1e-13  # a strip that is none: two corners at one level, but for rounding


class _End(NamedTuple):
    """Where chords end: y = offset + slope·x ± √(radius² − x²), the sign the radius's; no root where that is 0."""

    offset: float
    slope: float
    radius: float

    def at(self, x: F64) -> F64:
        """Return y."""
        root = np.sqrt(np.maximum((self.radius - x) * (self.radius + x), 0.0))
        return self.offset + self.slope * x + np.copysign(root, self.radius)


class _Strip(NamedTuple):
    """A part of an opening between two levels: chords along y, from one smooth line to another.

    low, high    : the levels, x
    lower, upper : where chords begin and end
    turn_rad     : by which all is turned
    """

    low: float
    high: float
    lower: _End
    upper: _End
    turn_rad: float

    @property
    def bent(self) -> bool:
        """Whether chords end on a circle."""
        return bool(self.lower.radius or self.upper.radius)

    @property
    def first_half(self) -> float:
        """How much of it counts where of two opposite chords only one does: what lies before 0.

        Of two strips with a hole between them each is the other one's opposite, by a rule of its own.
        """
        if self.high <= NARROW:
            return 1.0
        if self.low >= -NARROW:
            return 0.0
        if self.upper.radius < 0.0:
            return 1.0
        return 0.0 if self.lower.radius > 0.0 else 0.5

    def at(self, u: F64, t: F64) -> tuple[F64, F64, F64]:
        """Return x, y and area: ``u`` goes from chord to chord, ``t`` along them.

        x goes as a cosine where an end is a circle's, which takes its square roots.
        """
        width = self.high - self.low
        if self.bent:
            x, slope = self.low + width * np.sin(0.5 * np.pi * u) ** 2, 0.5 * np.pi * width * np.sin(np.pi * u)
        else:
            x, slope = self.low + width * u, np.full_like(u, width)
        below = self.lower.at(x)
        length = self.upper.at(x) - below
        return *_turned(x, below + length * t, self.turn_rad), slope * length


def chords_of(lens: OverPupil, wavelength_nm: float, turns: Turns) -> PanelRule:
    """Return the rule for a lens, and for waves: across a circle chords run as these turn less."""
    across = turns.most[0] < turns.most[1] and not len(lens.pupil.corners)
    return PanelRule(panels_of(lens, wavelength_nm, strips_of(lens.pupil, across)), turns)


@functools.lru_cache(maxsize=64)
def strips_of(pupil: Pupil, across: bool = False) -> tuple[_Strip, ...]:
    """Return an opening as strips.

    Chords run along a polygon's first side, and of a circle along y or, ``across``, along x.
    """
    corners, hole = pupil.corners, pupil.obstruction
    turn_rad, levels = 0.5 * math.pi if across else 0.0, [-1.0, 1.0]
    if len(corners):
        along_x, along_y = corners[1] - corners[0]
        turn_rad = math.atan2(-along_x, along_y)
        corners = np.stack(_turned(corners[:, 0], corners[:, 1], -turn_rad), axis=1)
        levels = corners[:, 0].tolist()
    strips: list[_Strip] = []
    for low, high in pairwise(sorted([*levels, *((-hole, hole) if hole else ())])):
        middle = 0.5 * (low + high)
        if high - low <= NARROW:
            continue
        lower, upper = _sides(corners, middle) if len(corners) else (_End(0.0, 0.0, -1.0), _End(0.0, 0.0, 1.0))
        if abs(middle) < hole:
            strips.append(_Strip(low, high, lower, _End(0.0, 0.0, -hole), turn_rad))
            strips.append(_Strip(low, high, _End(0.0, 0.0, hole), upper, turn_rad))
        else:
            strips.append(_Strip(low, high, lower, upper, turn_rad))
    return tuple(strips)


def _turned(x: F64, y: F64, angle_rad: float) -> tuple[F64, F64]:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return x * cos - y * sin, x * sin + y * cos


def _sides(corners: F64, x: float) -> tuple[_End, _End]:
    """Return the two sides of a convex outline that are met at a level."""
    met: list[tuple[float, _End]] = []
    for (px, py), (qx, qy) in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True):
        if min(px, qx) < x < max(px, qx):
            slope = (qy - py) / (qx - px)
            met.append((py + slope * (x - px), _End(py - slope * px, slope, 0.0)))
    lower, upper = sorted(met)
    return lower[1], upper[1]
