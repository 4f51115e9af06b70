"""The lattices of frequencies that an image is summed on: a fine one for what is near, coarser ones for what is far.

A sum over a lattice of frequencies sees everything again a period further on, and a lens's tail reaches there. The tail
is what the transfer's peak at zero frequency makes: far out it is smooth. So frequencies are shared among levels by
smooth windows, each level's below the one before it. What a window takes out of a level leaves a short kernel, so that
level's period need be no longer than its window and that kernel; what is below goes on a lattice of a longer period,
coarser by as much, which takes few frequencies however long it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from camsim.core.arrays import F64
from camsim.rendering.fast_length import fast_length
from camsim.rendering.waves.taper import taper, taper_margin, tapered

LOW_SHARE = 0.25  # of a window's end: where it begins to fall
NARROWER = 4.0  # times, from a level to the next
BESIDE = 3.0  # waves of the highest frequency, beyond its source, that what stands for light may lie
POINTS, FEWEST_POINTS, MOST_POINTS = (
    6.0,
    512,
    1 << 17,
)  # of a table of shares: a window's slope turns as fast as this asks
OVERSAMPLED = 2.0  # times as many points as a level's highest frequency needs, at the least: taps are for that


@dataclass(frozen=True, slots=True)
class Window:
    """A share of all frequencies: 1 from 0 to ``begin``, 0 from ``end`` on, cycles/pitch."""

    begin: float
    end: float
    sharpness: float

    def at(self, frequency: F64) -> F64:
        """Return the share at frequencies (n,)."""
        return tapered(frequency, self.begin, self.end, taper(self.sharpness))

    @classmethod
    def reaching(cls, reach: float, leak: float) -> Window:
        """Return the widest window whose kernel is within ``leak`` of nothing from ``reach`` pitches on."""
        margin, sharpness = taper_margin(leak)
        end = margin / (reach * (1.0 - LOW_SHARE))
        return cls(LOW_SHARE * end, end, sharpness)


@dataclass(frozen=True, slots=True)
class Level:
    """Frequencies that one lattice takes.

    cut   : the highest, cycles/pitch
    reach : how far its kernel sees, pitches
    takes : the window that it is below; None: none, the first level's
    leaves : what the next one takes; None: the last
    every : photosites between the points that it is summed at
    """

    cut: float
    reach: float
    takes: Window | None
    leaves: Window | None
    every: int = 1

    def shares(self, precision: float) -> tuple[F64, float]:
        """Return how much of a frequency is this level's, for straight lines between, and points per cycle/pitch.

        The last value holds for all higher frequencies up to the cut.
        """
        end = self.cut if self.takes is not None else 0.0 if self.leaves is None else self.leaves.end
        if end == 0.0:
            return np.ones(2), 1.0
        points = int(min(MOST_POINTS, max(FEWEST_POINTS, POINTS * math.sqrt(1.0 / precision))))
        frequency = np.linspace(0.0, end, points + 1)
        share = np.ones_like(frequency) if self.takes is None else self.takes.at(frequency)
        if self.leaves is not None:
            share -= self.leaves.at(frequency)
        return share, points / end


@dataclass(frozen=True, slots=True)
class Lattice:
    """Frequencies (i/px, j/py) of a part of the frame, |f| up to ``cut``, and the light that they are of.

    low, high : corners of all that the part sees, pitches from its first photosite
    some : the first j and the one past the last, of a lattice that is taken in parts; None: all
    """

    periods: tuple[int, int]
    cut: float
    low: tuple[float, float]
    high: tuple[float, float]
    some: tuple[int, int] | None = None

    @property
    def rows(self) -> range:
        """All j."""
        down = self.counts[1]
        return range(*self.some) if self.some else range(1 - down, down)

    def parts(self, most: float) -> Iterator[Lattice]:
        """Yield parts of about so many frequencies."""
        rows, columns = self.rows, self.counts[0]
        count = math.ceil(columns * len(rows) / most)
        ends = [rows.start + len(rows) * k // count for k in range(count + 1)]
        for some in pairwise(ends):
            yield replace(self, some=some)

    @property
    def counts(self) -> tuple[int, int]:
        """How many from 0 on, along x and along y."""
        return int(self.cut * self.periods[0]) + 1, int(self.cut * self.periods[1]) + 1

    @property
    def size(self) -> int:
        """Frequencies of the half plane i ≥ 0, whether within ``cut`` or not."""
        across, down = self.counts
        return across * (2 * down - 1)


def levels_of(
    cut: float, first: float, light: float, leak: float, farthest: float, tail: float, extent: float = 0.0
) -> list[Level]:
    """Return the levels of a lens.

    cut      : its highest frequency
    first    : how far the first level sees
    tail     : c of a tail c/r, the most light that an edge shows r pitches away; 0: the lens's light ends at ``first``
    light    : light that may be left out;  leak: what windows' kernels may leave
    farthest : distance of the farthest source
    extent   : how far photosite and low-pass filter spread light, around which a window's kernel lies
    """
    if tail == 0.0:
        return [Level(cut, first, None, None)]
    levels: list[Level] = []
    takes, reach = None, first
    while tail / reach > light and (reach < 4.0 * farthest or tail / reach > 0.3 * light):
        window = Window.reaching(reach - extent, leak)
        if window.end >= cut:
            reach *= 2.0
            continue
        levels.append(Level(cut if takes is None else takes.end, reach, takes, window, _every(takes)))
        takes, reach = window, NARROWER * reach
    levels.append(Level(cut if takes is None else takes.end, reach, takes, None, _every(takes)))
    return levels


def _every(takes: Window | None) -> int:
    """Return a power of two, so that each level's points are among those of the one before."""
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
        # What stands for light may lie a little beyond it.
        period = max(count - 1.0 - begin, end, 1.0) + level.reach + BESIDE / level.cut
        period = max(period, end - begin + 1.0, count)
        periods.append(unit * fast_length(math.ceil(period / unit)))
        lows.append(first)
        highs.append(last)
    return Lattice((periods[0], periods[1]), level.cut, (lows[0], lows[1]), (highs[0], highs[1]))
