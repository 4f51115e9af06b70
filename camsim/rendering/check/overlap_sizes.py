"""How many nodes follow an aberrated lens's transfer: a search, before anything is summed, and what sums take."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.optics.difference import Difference
from camsim.quadrature import chebyshev
from camsim.rendering.check.overlap_kernels import overlap_nodes
from camsim.rendering.check.overlap_sums import steps, transfer_of

SHIFTS, ANGLES = np.array([0.07, 0.25, 0.5, 0.8]), np.pi * np.array([0.02, 0.29, 0.55])  # where nodes are counted
FEWEST_RULE, FEWEST = 12, 32
OF_SERIES = 0.1  # of what may be wrong: terms from which on a series ends
OF_FASTEST = 0.8  # of the most that any place turns by, which few do
GROWTH = 1.3
PLACES, FINER = 6, 1.25  # at which it is held against overlaps, and by how many times as many nodes
PER_NODE, PER_NODE_OF_COLOUR, PER_DIRECT_NODE = 6e-8, 4.5e-9, 6e-8  # seconds of one core, measured
PER_ROW, PER_COLUMN = 1.5e-8, 2e-9  # of one of a table for each wavelength and shift, and of what makes it


class Sizes(NamedTuple):
    """Nodes of the overlap's rule either way, along √(1 − ν), half round, over wavelengths, and rows of a table."""

    rule: int
    shifts: int
    angles: int
    colours: int
    rows: int

    def larger(self) -> Sizes:
        """Return more of each."""
        return Sizes(*(math.ceil(GROWTH * size) if size > 1 else 1 for size in self))

    @property
    def finer_rule(self) -> int:
        """The rule that judges."""
        return math.ceil(FINER * self.rule) + 8

    def seconds(self, wavelengths: int, sets: int) -> float:
        """Return what sums over wavelengths are expected to take."""
        overlaps = self.rule**2 * self.angles * (PER_NODE + PER_NODE_OF_COLOUR * self.colours)
        rows = self.rows * (PER_ROW * wavelengths + PER_COLUMN * sets * self.colours * self.angles)
        return self.shifts * (overlaps + rows) + PER_DIRECT_NODE * wavelengths * PLACES * self.finer_rule**2


@functools.lru_cache(maxsize=64)
def sizes_of(rest: Difference, low_nm: float, high_nm: float, allowed: float, most: float) -> Sizes | None:
    """Return nodes that follow the transfers at the shortest wavelength, None where these are too many."""
    before, rule = transfer_of(rest, low_nm, FEWEST_RULE, SHIFTS, ANGLES), FEWEST_RULE
    while True:
        rule = math.ceil(1.25 * rule)
        if rule**2 * FEWEST**2 > 2.0 * most:
            return None
        found = transfer_of(rest, low_nm, rule, SHIFTS, ANGLES)
        if np.abs(found - before).max() <= allowed:
            break
        before = found
    count = FEWEST
    while True:
        if rule**2 * count**2 > 4.0 * most:
            return None
        shift = 1.0 - (0.5 * (1.0 + chebyshev(count))) ** 2
        along = transfer_of(rest, low_nm, rule, shift, ANGLES[:2])
        half = transfer_of(rest, low_nm, rule, SHIFTS[::2], np.pi * np.arange(count) / count)
        around = scipy.fft.fft(np.concatenate([half, half.conj()], axis=1), axis=1)[:, :count]
        series = np.abs(scipy.fft.dct(along.view(float), axis=0)).max(axis=1), np.abs(around).max(axis=0)
        shifts, angles = (int(np.flatnonzero(own > OF_SERIES * allowed * count)[-1]) + 2 for own in series)
        if max(shifts, angles) <= 0.85 * count:
            break
        count *= 2
    if rule**2 * shifts * angles > most:
        return None
    rows = math.ceil(40.0 * allowed ** (-1.0 / 6.0))
    return Sizes(rule, shifts, angles, _colours(rest, low_nm, high_nm, allowed), rows)


def _colours(rest: Difference, low_nm: float, high_nm: float, allowed: float) -> int:
    """Return how many evenly spaced colours follow what turns the fastest between two wavelengths.

    By a turn of φ the polynomial through n places h apart is wrong by φⁿ/n! times hⁿ(n − 1)!/4 at the most.
    """
    along, across, _ = overlap_nodes(FEWEST_RULE, SHIFTS)
    cos, sin = np.cos(ANGLES)[:, None], np.sin(ANGLES)[:, None]
    step = steps(rest, low_nm, SHIFTS[:, None, None], cos, sin, (along[:, None], across[:, None]))
    turn = OF_FASTEST * 2.0 * math.pi * float(np.abs(step).max()) * (1.0 - low_nm / high_nm)
    count = 1
    while (turn / max(count - 1, 0.5)) ** count > 4.0 * count * allowed:
        count += 1
    return count
