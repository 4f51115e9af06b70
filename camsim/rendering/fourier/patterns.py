"""A lens's pattern on a lattice: how many samples it has, and how many rows of it are made at a time."""

from __future__ import annotations

import math
from typing import NamedTuple

from camsim.gridded import PER_WAVE
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.tile import Tile

FEWEST_SAMPLES = 4_000_000  # at a time, whatever they take
STRIP_BYTES = 3.6e8  # what strips of a pattern behind pictures may take
NODES_BYTES, OF_FEW_BYTES = 3.3e8, 90.0  # of the pupil's nodes at a time; of small patterns so much for each sample


def samples_of(kernel: Kernel, tile: Tile) -> float:
    """Return the points of a pattern's period, as finely as the band asks for."""
    return 4.0 * math.prod(kernel.cuts(tile.cut)) * tile.periods[0] * tile.periods[1]


class Lattice(NamedTuple):
    """A pattern's samples along one axis: how many make up the period, how far apart, the first's number, how many."""

    size: int
    step: float
    first: int
    samples: int


def lattices_of(cuts: tuple[float, float], tile: Tile) -> list[Lattice]:
    """Return a pattern's samples along x and along y, where its band ends at ``cuts``."""
    found = []
    for period, (low, high), cut in zip(tile.periods, tile.spans, cuts, strict=True):
        size = fast_length(math.ceil(PER_WAVE * cut * period) + 1)
        first, last = math.ceil(low * size / period), math.floor(high * size / period)
        found.append(Lattice(size, period / size, first, last - first + 1))
    return found


def pattern_of(kernel: Kernel, tile: Tile) -> tuple[int, int]:
    """Return the rows and columns of the pattern itself, as far as it is taken."""
    x, y = lattices_of(kernel.cuts(tile.cut), tile)
    return y.samples, x.samples


def rows_at_once(kernel: Kernel, pattern: tuple[int, int], spare_bytes: float) -> int:
    """Return how many rows of a pattern are made at a time: all of them, where that fits.

    Every strip is summed from every node of the pupil.
    """
    rows, columns = pattern
    fewest, most = min(rows, math.ceil(FEWEST_SAMPLES / columns)), rows
    if kernel.pattern_bytes(pattern) > spare_bytes:
        # ``most`` are too many, and ``fewest`` are made whatever they take.
        while most - fewest > 1:
            middle = (fewest + most) // 2
            fits = kernel.pattern_bytes((middle, columns)) <= spare_bytes
            fewest, most = (middle, most) if fits else (fewest, middle)
        most = fewest
    return math.ceil(rows / math.ceil(rows / most))


def made_bytes(kernel: Kernel, rows: int, columns: int) -> float:
    """Return what is held while so many rows of a pattern are made, the pupil's nodes included."""
    return kernel.pattern_bytes((rows, columns)) + min(NODES_BYTES, OF_FEW_BYTES * rows * columns)
