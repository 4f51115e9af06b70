"""Records that the check passes to its kernels; a module apart, as a kernel's cache key covers its module's imports."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64

POWERS = 7  # of 1/r, in the tail's series


class Outlines(NamedTuple):
    """Straight and round parts of outlines, fill by fill and loop by loop.

    x, y, dx, dy : start and vector to the end of a straight part; centre and (radius, 0) of an arc
    from_rad, turn_rad : first angle of an arc and the signed angle that it spans; 0 for a straight part
    """

    x: F64
    y: F64
    dx: F64
    dy: F64
    from_rad: F64
    turn_rad: F64

    def at(self, t: F64 | float) -> F64:
        """Return a place (n, 2) on each part, at a fraction t of it."""
        straight, angle = self.turn_rad == 0.0, self.from_rad + t * self.turn_rad
        x = self.x + np.where(straight, t * self.dx, self.dx * np.cos(angle))
        y = self.y + np.where(straight, t * self.dy, self.dx * np.sin(angle))
        return np.stack([x, y], axis=1)

    @property
    def length(self) -> F64:
        """Length of each part (n,)."""
        length: F64 = np.where(self.turn_rad == 0.0, np.hypot(self.dx, self.dy), self.dx * np.abs(self.turn_rad))
        return length


class Owners(NamedTuple):
    """Parts of fills, fills of layers and layers of primitives, each given by the offsets where they begin.

    even_odd : (fills,) whether the even-odd rule applies
    ends     : (n, 4) x, y of each part's first and last point; the latter equals the next one's first to the last bit
    """

    part: I64
    fill: I64
    layer: I64
    even_odd: np.ndarray
    ends: F64

    @property
    def primitive(self) -> I64:
        """Primitive of each part (n,)."""
        first = self.part[self.fill[self.layer]]
        return np.repeat(np.arange(len(first) - 1), np.diff(first))


class Table(NamedTuple):
    """A PSF by radius, angular harmonic and kind of light, for kernels; pitches.

    within, light : (rows, 3, harmonics × kinds) G and the PSF, with two derivatives times powers of the row spacing
    starts, per_pitch, first : start, rows per pitch and first row of each zone;  until: end of the last zone
    step     : orders of the harmonics are 0, step, 2 step … for cosines, followed by step, 2 step … for sines
    cosines, sines : numbers of harmonics of order above 0
    ends     : (harmonics, kinds) limit of G at infinite r;  ending: how many cosines, from 0 on, it needs
    powers   : (harmonics, kinds, POWERS) coefficients of the PSF at r^{−3}, r^{−4} …;  far: as ``ending``
    reach    : (POWERS,) falling, distance from which each of them is negligible, in all the light of places farther off
    kinds    : number of kinds of light
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
    reach: F64
    far: int
    kinds: int


class Nodes(NamedTuple):
    """Places (n, 2) with light (planes, n); begins: (cells, 2, 2) where a cell's fine and coarse ones begin and end."""

    begins: I64
    at: F64
    light: F64
