"""Light put on a coarse lattice, and photosites read off it, by Lagrange's interpolation; arrays only."""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kernels import kernel, shared

POINTS = 8  # of the interpolation along an axis


def deposit(x: F64, y: F64, light: F64, lattice: F64) -> None:
    """Add light (modes, n) at places (n,), in steps, to lattices (modes, rows, cols)."""
    shared(len(light), functools.partial(_deposit, x, y, light, lattice))


def deposit_rows(x: F64, y: F64, light: F64, lattice: F64) -> None:
    """Add light (modes, y.size, x.size) at all pairs of places, in steps, to lattices (modes, rows, cols)."""
    (left, across), (top, down) = _weighed(x), _weighed(y)
    lines = np.empty((y.size, lattice.shape[2]))
    for own, its in zip(light, lattice, strict=True):
        shared(y.size, functools.partial(_lines, left, across, own, lines))
        shared(len(its), functools.partial(_add_lines, top, down, lines, its))


def read(lattice: F64, step: float, first: F64, row: int, channel: U8, image: F64) -> None:
    """Add lattices (channels, …), the first point at ``first``, to photosites (images, rows, cols) from a row on."""
    rows, cols = channel.shape[1:]
    left, across = _weighed((np.arange(cols) - first[0]) / step)
    top, down = _weighed((np.arange(row, row + rows) - first[1]) / step)
    shared(rows, functools.partial(_read, lattice, left, across, top, down, channel, image))


@kernel()
def _weights(place: float, out: F64) -> int:
    """Set Lagrange's weights of the lattice points about a place, and return the first of them."""
    first = int(math.floor(place)) - (POINTS // 2 - 1)  # noqa: RUF046 (compiled, the floor is a float)
    t = place - first
    for k in range(POINTS):
        product = 1.0
        for other in range(POINTS):
            if other != k:
                product *= (t - other) / (k - other)
        out[k] = product
    return first


@kernel(allocates=True)
def _weighed(places: F64) -> tuple[I64, F64]:
    firsts, weights = np.empty(places.size, np.int64), np.empty((places.size, POINTS))
    for q in range(places.size):
        firsts[q] = _weights(places[q], weights[q])
    return firsts, weights


@kernel(allocates=True)
def _deposit(x: F64, y: F64, light: F64, lattice: F64, low: int, high: int) -> None:
    """Deposit some modes."""
    across, down = np.empty(POINTS), np.empty(POINTS)
    for m in range(low, high):
        for q in range(x.size):
            col, row = _weights(x[q], across), _weights(y[q], down)
            for i in range(POINTS):
                share = light[m, q] * down[i]
                for j in range(POINTS):
                    lattice[m, row + i, col + j] += share * across[j]


@kernel()
def _lines(left: I64, across: F64, light: F64, lines: F64, low: int, high: int) -> None:
    """Set some rows of lines to their light (rows, places), put on the lattice's columns."""
    for r in range(low, high):
        lines[r] = 0.0
        for c in range(left.size):
            for j in range(POINTS):
                lines[r, left[c] + j] += light[r, c] * across[c, j]


@kernel()
def _add_lines(top: I64, down: F64, lines: F64, lattice: F64, low: int, high: int) -> None:
    """Add lines to some rows of a lattice, to each in the lines' order."""
    for row in range(low, high):
        for r in range(top.size):
            i = row - top[r]
            if 0 <= i < POINTS:
                for c in range(lattice.shape[1]):
                    lattice[row, c] += down[r, i] * lines[r, c]


@kernel(allocates=True)
def _read(
    lattice: F64, left: I64, across: F64, top: I64, down: F64, channel: U8, image: F64, low: int, high: int
) -> None:
    """Read some rows of photosites."""
    line = np.empty((len(lattice), lattice.shape[2]))
    for r in range(low, high):
        line[:] = 0.0
        for k in range(len(lattice)):
            for i in range(POINTS):
                for c in range(lattice.shape[2]):
                    line[k, c] += down[r, i] * lattice[k, top[r] + i, c]
        for n in range(len(channel)):
            for c in range(channel.shape[2]):
                total = 0.0
                for j in range(POINTS):
                    total += across[c, j] * line[channel[n, r, c], left[c] + j]
                image[n, r, c] += total
