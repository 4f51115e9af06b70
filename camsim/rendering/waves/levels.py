"""Lattices of frequencies on which an image is summed: a fine one for near light, coarser ones for distant light.

A sum over a lattice of frequencies is periodic, and a lens's tail reaches into the next period. The tail comes from the
transfer's peak at zero frequency and is smooth far out. So smooth windows divide the frequencies among levels, each
level below the one before it. Without the frequencies of the next level, a level's kernel is short: its period need
only cover the part of the frame and that kernel. The lower frequencies go to a lattice with a longer period and coarser
sampling in space, whose number of frequencies stays small.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from camsim.core.arrays import F64
from camsim.rendering.fast_length import fast_length
from camsim.rendering.waves.taper import taper, taper_margin, tapered

LOW_SHARE = 0.25  # where a window begins to fall, over its end
PASSES = 0.3, 0.6  # where that window falls beyond which photosites pass little, cycles/pitch
NARROWER = 4.0  # ratio of reach between one level and the next
BESIDE = 3.0  # margin around the light, in periods of the highest frequency: equivalent sources may lie outside it
# Of a table of shares: per inverse root of the precision, since it is interpolated linearly; least; most.
POINTS, FEWEST_POINTS, MOST_POINTS = 6.0, 512, 1 << 20
# A PSF of πc/(2πr³), for a half-plane's light of c/r, times half the square of a diameter and Σ 1/r³ over a lattice.
OF_PERIODS = 9.03 * 0.25
OVERSAMPLED = 2.0  # smallest sampling of a level over its Nyquist rate, for which the taps are made


@dataclass(frozen=True, slots=True)
class Window:
    """A smooth low-pass window: 1 from 0 to ``begin``, 0 from ``end`` on, cycles/pitch."""

    begin: float
    end: float
    sharpness: float

    def at(self, frequency: F64) -> F64:
        """Return the window at frequencies (n,)."""
        return tapered(frequency, self.begin, self.end, taper(self.sharpness))

    @classmethod
    def reaching(cls, reach: float, leak: float) -> Window:
        """Return the widest window whose kernel is below ``leak`` from ``reach`` pitches on."""
        margin, sharpness = taper_margin(leak)
        end = margin / (reach * (1.0 - LOW_SHARE))
        return cls(LOW_SHARE * end, end, sharpness)

    @classmethod
    def passed(cls, leak: float) -> Window:
        """Return a window beyond which photosites pass little; the kernel of what is left is a few pitches long."""
        return cls(*PASSES, taper_margin(leak)[1])


@dataclass(frozen=True, slots=True)
class Level:
    """The frequencies of one lattice.

    cut   : highest frequency, cycles/pitch
    reach : reach of its kernel, pitches
    takes : window that bounds it above; None: the first level
    leaves : window of the next level, which it leaves out; None: the last level
    every : spacing of the points at which it is summed, photosites
    """

    cut: float
    reach: float
    takes: Window | None
    leaves: Window | None
    every: int = 1

    @property
    def near(self) -> bool:
        """Whether it is summed at every photosite, tile by tile."""
        return self.takes is None or self.cut >= PASSES[1]

    def shares(self, precision: float) -> tuple[F64, float]:
        """Return this level's share at evenly spaced frequencies, to interpolate linearly, and points per cycle/pitch.

        The last value holds for all higher frequencies up to ``cut``.
        """
        end = self.cut if self.takes is not None else 0.0 if self.leaves is None else self.leaves.end
        if end == 0.0:
            return np.ones(2), 1.0
        narrower = 1.0 if self.leaves is None else max(1.0, end / (NARROWER * self.leaves.end))
        points = int(min(MOST_POINTS, max(FEWEST_POINTS, POINTS * narrower * math.sqrt(1.0 / precision))))
        frequency = np.linspace(0.0, end, points + 1)
        share = np.ones_like(frequency) if self.takes is None else self.takes.at(frequency)
        if self.leaves is not None:
            share -= self.leaves.at(frequency)
        return share, points / end


@dataclass(frozen=True, slots=True)
class Lattice:
    """Frequencies (i/px, j/py), |f| up to ``cut``, for a part of the frame and the light in its support.

    low, high : corners of the support, pitches from the part's first photosite
    some : the first j and the one past the last, if the lattice is taken in parts; None: all
    """

    periods: tuple[int, int]
    cut: float
    low: tuple[float, float]
    high: tuple[float, float]
    some: tuple[int, int] | None = None

    @property
    def rows(self) -> range:
        """Range of j."""
        down = self.counts[1]
        return range(*self.some) if self.some else range(1 - down, down)

    def parts(self, most: float) -> Iterator[Lattice]:
        """Yield parts of at most about ``most`` frequencies."""
        rows, columns = self.rows, self.counts[0]
        count = math.ceil(columns * len(rows) / most)
        ends = [rows.start + len(rows) * k // count for k in range(count + 1)]
        for some in pairwise(ends):
            yield replace(self, some=some)

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of frequencies from 0 on, along x and along y."""
        return int(self.cut * self.periods[0]) + 1, int(self.cut * self.periods[1]) + 1

    @property
    def size(self) -> int:
        """Number of lattice points in the half plane i ≥ 0, those beyond ``cut`` included."""
        across, down = self.counts
        return across * (2 * down - 1)


def levels_of(
    cut: float,
    first: float,
    light: float,
    leak: float,
    tail: float,
    extent: float = 0.0,
    width: float = math.inf,
    passed: float = 0.0,
) -> list[Level]:
    """Return the levels of a lens.

    cut      : highest frequency of the lens, cycles/pitch
    first    : reach of the first level, pitches
    tail     : c of a tail c/r, which bounds the light of an edge r pitches away; 0: the PSF ends at ``first``
    light    : light that may be neglected;  leak: error allowed to the windows' kernels
    extent   : extent of the footprint of photosite and low-pass filter, which widens a window's kernel
    width    : diameter of the scenery, if its light falls as the PSF, with the third power of the distance
    passed   : reach, if farther than the first, of the frequencies that photosites pass
    """

    def lost(reach: float) -> float:
        """Return the light of all periods of the scenery but the first, no nearer than ``reach``."""
        return tail / reach * min(1.0, OF_PERIODS * (width / reach) ** 2)

    if tail == 0.0:
        return [Level(cut, first, None, None)]
    levels: list[Level] = []
    takes, reach = None, max(first, passed)
    if passed > first and cut > PASSES[1]:
        takes = Window.passed(leak)
        first = max(first, taper_margin(leak)[0] / (takes.end - takes.begin) + extent)
        levels.append(Level(cut, first, None, takes))
    while lost(reach) > light:
        window = Window.reaching(reach - extent, leak)
        if window.end >= cut:
            reach *= 2.0
            continue
        levels.append(Level(cut if takes is None else takes.end, reach, takes, window, _every(takes)))
        takes, reach = window, NARROWER * reach
    levels.append(Level(cut if takes is None else takes.end, reach, takes, None, _every(takes)))
    return levels


def reach_of(levels: Sequence[Level]) -> float:
    """Return the reach of the levels that are summed at every photosite, pitches."""
    return max(level.reach for level in levels if level.near)


def _every(takes: Window | None) -> int:
    """Return a level's spacing, photosites: a power of two, so that its points are among those of the finer level."""
    return 1 if takes is None else 1 << max(0, math.floor(-math.log2(2.0 * OVERSAMPLED * takes.end)))


def lattice_of(level: Level, size: tuple[int, int], low: F64, high: F64, whole: int = 1) -> Lattice:
    """Return the lattice of a part of the frame.

    size      : photosites along x and along y
    low, high : (2,) corners of the light, pitches from the first photosite
    whole     : pitches of which a period is a multiple
    """
    unit = math.lcm(level.every, whole)
    periods, lows, highs = [], [], []
    for count, begin, end in zip(size, low.tolist(), high.tolist(), strict=True):
        first, last = -level.reach, count - 1.0 + level.reach
        begin, end = min(max(begin, first), last), max(min(end, last), first)
        # Equivalent sources may lie a little outside the light's box.
        period = max(count - 1.0 - begin, end, 1.0) + level.reach + BESIDE / level.cut
        period = max(period, end - begin + 1.0, count)
        periods.append(unit * fast_length(math.ceil(period / unit)))
        lows.append(first)
        highs.append(last)
    return Lattice((periods[0], periods[1]), level.cut, (lows[0], lows[1]), (highs[0], highs[1]))
