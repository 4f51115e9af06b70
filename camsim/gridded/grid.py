"""Grids that points are spread to, by finufft, before what is spread is transformed."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.nonuniform import spread

WIDEST = 16  # cells of finufft's kernels
SAMPLED = 8  # places in a cell where a kernel is looked at: its sum there is its integral to rounding
PROBE = 64  # cells of a grid on which it is looked at
ROWS, COLUMNS = 16, 64  # transformed at a time: what stays in a cache
SMALL = 1_000_000  # points of a lattice, which all at once take as little: finufft's own transforms


def is_large(shape: tuple[int, int]) -> bool:
    """Whether a lattice is one that points are spread for here."""
    return shape[0] * shape[1] >= SMALL


class Spread(NamedTuple):
    """What points are spread to: some rows and columns of a grid."""

    rows: slice
    columns: slice
    values: C128


def spread_to(shape: tuple[int, ...], y: F64, x: F64, strengths: C128, precision: float) -> Spread:
    """Spread points to the part of a grid that they reach, if they do not go round: else to all of it."""
    rows, columns = shape
    down, across = _box(y, rows), _box(x, columns)
    y, x = (y - down.middle_rad) * down.finer, (x - across.middle_rad) * across.finer
    values = spread((y, x), strengths, (down.size, across.size), precision=precision)
    return Spread(down.cells, across.cells, values)


class _Box(NamedTuple):
    """Cells of a grid's axis: how many, the phase of their middle one, and what phases about it are multiplied by."""

    cells: slice
    size: int
    middle_rad: float
    finer: float


def _box(phase: F64, cells: int) -> _Box:
    """Return the cells that points are spread to; all of them where these go round."""
    step = math.tau / cells
    margin, middle = WIDEST // 2 + 1, cells // 2
    first = math.floor(float(phase.min()) / step) - margin
    size = max(math.ceil(float(phase.max()) / step) + margin - first + 1, 2 * WIDEST + 4)
    size += size % 2
    if first < -middle or first + size > cells - middle:
        return _Box(slice(0, cells), cells, 0.0, 1.0)
    return _Box(slice(first + middle, first + middle + size), size, (first + size // 2) * step, cells / size)


def runs(below: int, size: int, cells: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the places below 0, so many of all, and the others, and where a transform has them: those at its end."""
    return (slice(0, below), slice(cells - below, cells)), (slice(below, size), slice(0, size - below))


def of_kernel(places: F64, cells: int, precision: float) -> F64:
    """Return the transform of a point's kernel at places (n,), numbers of waves in a grid of so many cells."""
    away, heights = _kernel(precision)
    transform: F64 = np.cos(np.multiply.outer(places * (math.tau / cells), away)) @ heights
    return transform


@functools.lru_cache(maxsize=32)
def _kernel(precision: float) -> tuple[F64, F64]:
    """Return where a point's kernel was looked at (in cells from it), and it there, of unit sums over a cell's places.

    A kernel's width depends on the number of axes, so that it is looked at on a plane.
    """

    def row(offset: float) -> F64:
        """Return the row of cells through a point, that lies so far along it from one's middle."""
        place = np.zeros(1), np.array([offset * math.tau / PROBE])
        cells: F64 = spread(place, np.ones(1, complex), (PROBE, PROBE), precision=precision)[PROBE // 2].real
        return cells

    offsets = (np.arange(SAMPLED) + 0.5) / SAMPLED - 0.5
    heights = np.stack([row(offset) for offset in offsets.tolist()]) / math.sqrt(row(0.0)[PROBE // 2])
    away = (np.arange(PROBE) - PROBE // 2) - offsets[:, None]
    near = np.abs(away) <= 0.5 * WIDEST + 1.0
    return away[near], heights[near] / SAMPLED


def even(cells: float) -> int:
    """Return a quick length of a transform: even, so that cells lie alike about the middle."""
    half: int = scipy.fft.next_fast_len(math.ceil(0.5 * max(cells, 2.0 * WIDEST)))
    return 2 * half
