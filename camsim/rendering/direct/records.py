"""Records of outlines that the check takes into its kernels, whose keys have all that their modules import."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64

POWERS = 7  # of 1/r, of what is far


class Outlines(NamedTuple):
    """Straight and round parts of outlines, fill by fill and loop by loop.

    x, y, dx, dy : start and vector to the end of a straight part; of a round one its centre, and (radius, 0)
    from_rad, turn_rad : of a round part, the angle at which it begins and how far it goes, below 0 the other way round;
                   a turn of 0 is straight
    """

    x: F64
    y: F64
    dx: F64
    dy: F64
    from_rad: F64
    turn_rad: F64

    def some(self, which: I64 | np.ndarray) -> Outlines:
        """Return picked ones."""
        return Outlines(*(column[which] for column in self))

    @property
    def length(self) -> F64:
        """Of each (n,)."""
        length: F64 = np.where(self.turn_rad == 0.0, np.hypot(self.dx, self.dy), self.dx * np.abs(self.turn_rad))
        return length


class Owners(NamedTuple):
    """Whose each part is: parts of fills, fills of layers, layers of primitives, each where the next begins.

    even_odd : (fills,) whether it is filled where a place is wound about an odd number of times
    ends     : (n, 4) x, y where each part begins and where it ends: the very numbers with which the next one begins
    """

    part: I64
    fill: I64
    layer: I64
    even_odd: np.ndarray
    ends: F64

    @property
    def primitive(self) -> I64:
        """Of each part (n,)."""
        first = self.part[self.fill[self.layer]]
        return np.repeat(np.arange(len(first) - 1), np.diff(first))


class Table(NamedTuple):
    """A point spread by radius, harmonic and kind of light, as kernels take it; pitches.

    within, light : (rows, 3, harmonics × kinds) G and the point spread, with two derivatives times steps
    starts, per_pitch, first : of zones: where each begins, rows a pitch, and the first row;  until: the last one's end
    step     : of the harmonics' orders: 0, step, 2 step … are cosines' and, after these, step, 2 step … sines'
    cosines, sines : how many of order above 0
    ends     : (harmonics, kinds) G where r is infinite;  ending: cosines, from 0 on, that have any
    powers   : (harmonics, kinds, POWERS) of the point spread at r^{−3}, r^{−4} …;  far: as ``ending``
    kinds    : of light
    """

    within: F64
    light: F64
    starts: F64
    per_pitch: F64
    first: I64
    until: float
    step: int
    cosines: int
    sines: int
    ends: F64
    ending: int
    powers: F64
    far: int
    kinds: int
