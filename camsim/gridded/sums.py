"""Sums of plane waves on a lattice, from points that are spread to the cells that they reach.

finufft makes room for a grid twice as large each way as there are waves, and transforms all of it. But scenery fills
half a period each way: points are spread to a box here. Its rows are transformed, of which half are waves that are
asked for, and then these waves' columns.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.gridded.grid import COLUMNS, ROWS, even, is_large, of_kernel, runs, spread_to
from camsim.nonuniform import finer, modes

KEPT = 64  # axes: of a transform's strips, one after the other


def sums(y: F64, x: F64, strengths: C128, shape: tuple[int, int], times: tuple[C128, C128], precision: float) -> C128:
    """Return times[0][j]·times[1][i]·Σ_q strengths[q]·exp(−i(j·y[q] + i·x[q])), (j, i) integers about 0: (shape).

    y, x      : (m,) radians, least work where they are all about 0
    times     : what rows and columns are multiplied by
    precision : relative to the sum of the strengths' sizes

    >>> import numpy as np
    >>> ones = np.ones(2, complex), np.ones(3, complex)
    >>> found = sums(np.array([np.pi]), np.array([0.5 * np.pi]), np.ones(1, complex), (2, 3), ones, 1e-12)
    >>> found.real.round(9) + 0.0
    array([[ 0., -1.,  0.],
           [ 0.,  1.,  0.]])
    """
    if not is_large(shape):
        return modes((y, x), strengths, shape, precision=precision, sign=-1) * times[0][:, None] * times[1]
    cells = [even(finer(precision) * size) for size in shape]
    out = spread_to((cells[0], cells[1]), y, x, strengths, precision)
    down, across = (
        own * _from_corner(size, count, some.start, precision)
        for own, size, count, some in zip(times, shape, cells, (out.rows, out.columns), strict=True)
    )
    lines = _along(out.values, cells[1], across)
    del out  # before as much is made of them
    return _down(lines, cells[0], down)


def _along(values: C128, cells: int, times: C128) -> C128:
    """Return the rows of a box transformed, those of the waves that are asked for, multiplied."""
    lines = np.empty((len(values), times.size), complex)
    for first in range(0, len(values), ROWS):
        some = slice(first, first + ROWS)
        waves = scipy.fft.fft(values[some], n=cells, axis=1)
        for own, wanted in runs(times.size // 2, times.size, cells):
            np.multiply(waves[:, wanted], times[own], out=lines[some, own])
    return lines


def _down(lines: C128, cells: int, times: C128) -> C128:
    """Return the columns transformed, likewise."""
    total = np.empty((times.size, lines.shape[1]), complex)
    for first in range(0, lines.shape[1], COLUMNS):
        some = slice(first, first + COLUMNS)
        waves = scipy.fft.fft(lines[:, some], n=cells, axis=0)
        for own, wanted in runs(times.size // 2, times.size, cells):
            np.multiply(waves[wanted], times[own, None], out=total[own, some])
    return total


@functools.lru_cache(maxsize=KEPT)
def _from_corner(size: int, cells: int, first: int, precision: float) -> C128:
    """Return what a box's waves are multiplied by: over the kernel's transform, and turned as far as it lies off 0."""
    places = np.arange(size) - size // 2
    turns = (places * (first - cells // 2)) % cells / cells
    times: C128 = np.exp(-2j * math.pi * turns) / of_kernel(places.astype(float), cells, precision)
    return times
