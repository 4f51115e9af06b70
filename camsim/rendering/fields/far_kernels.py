"""Light put on a coarse lattice, and photosites read off it, by Lagrange's interpolation; arrays only."""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.arrays import F64, U8
from camsim.kernels import kernel, shared

POINTS = 8  # of the interpolation along an axis


@kernel()
def _weights(place: float, out: F64) -> int:
    """Set Lagrange's weights of the lattice points about a place, and return the first of them."""
    first = math.floor(place) - (POINTS // 2 - 1)
    t = place - first
    for k in range(POINTS):
        product = 1.0
        for other in range(POINTS):
            if other != k:
                product *= (t - other) / (k - other)
        out[k] = product
    return first


def deposit(x: F64, y: F64, light: F64, lattice: F64) -> None:
    """Add light (modes, n) at places (n,), in steps, to lattices (modes, rows, cols)."""
    shared(len(light), lambda begin, end: _deposit(x, y, light, lattice, begin, end))


@kernel()
def _deposit(x: F64, y: F64, light: F64, lattice: F64, begin: int, end: int) -> None:
    across, down = np.empty(POINTS), np.empty(POINTS)
    for m in range(begin, end):
        for q in range(x.size):
            col, row = _weights(x[q], across), _weights(y[q], down)
            for i in range(POINTS):
                share = light[m, q] * down[i]
                for j in range(POINTS):
                    lattice[m, row + i, col + j] += share * across[j]


def deposit_rows(x: F64, y: F64, light: F64, lattice: F64) -> None:
    """Add light (modes, y.size, x.size) at all pairs of places, in steps, to lattices (modes, rows, cols)."""
    for own, whole in zip(light, lattice, strict=True):
        lines = np.zeros((y.size, whole.shape[1]))
        shared(y.size, functools.partial(_across, x, own, lines))
        # One thread for each row of the lattice: what is added to it comes in one order.
        shared(len(whole), functools.partial(_down, y, lines, whole))


@kernel()
def _across(x: F64, light: F64, lines: F64, begin: int, end: int) -> None:
    """Add light (rows, x.size) to lines (rows, cols)."""
    firsts, across = np.empty(x.size, np.int64), np.empty((x.size, POINTS))
    for c in range(x.size):
        firsts[c] = _weights(x[c], across[c])
    for r in range(begin, end):
        for c in range(x.size):
            for j in range(POINTS):
                lines[r, firsts[c] + j] += light[r, c] * across[c, j]


@kernel()
def _down(y: F64, lines: F64, lattice: F64, begin: int, end: int) -> None:
    """Add lines (y.size, cols) to the rows of a lattice."""
    down = np.empty(POINTS)
    for r in range(y.size):
        first = _weights(y[r], down)
        for row in range(max(first, begin), min(first + POINTS, end)):
            for c in range(lines.shape[1]):
                lattice[row, c] += down[row - first] * lines[r, c]


def read(lattice: F64, step: float, first: F64, channel: U8, image: F64) -> None:
    """Add lattices (channels, …), the first point at ``first``, to photosites (images, rows, cols) at whole places."""
    shared(channel.shape[1], lambda begin, end: _read(lattice, step, first, channel, image, begin, end))


@kernel()
def _read(lattice: F64, step: float, first: F64, channel: U8, image: F64, begin: int, end: int) -> None:
    images, _, cols = channel.shape
    firsts, shares = np.empty(cols, np.int64), np.empty((cols, POINTS))
    for c in range(cols):
        firsts[c] = _weights((c - first[0]) / step, shares[c])
    down, line = np.empty(POINTS), np.empty((len(lattice), lattice.shape[2]))
    for r in range(begin, end):
        line[:] = 0.0
        row = _weights((r - first[1]) / step, down)
        for k in range(len(lattice)):
            for i in range(POINTS):
                for c in range(lattice.shape[2]):
                    line[k, c] += down[i] * lattice[k, row + i, c]
        for n in range(images):
            for c in range(cols):
                total = 0.0
                for j in range(POINTS):
                    total += shares[c, j] * line[channel[n, r, c], firsts[c] + j]
                image[n, r, c] += total
