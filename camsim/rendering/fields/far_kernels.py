"""Light put on a coarse lattice, and photosites read off it, by Lagrange's interpolation; arrays only."""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from camsim.arrays import F64, U8
from camsim.kernels import kernel

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


@kernel(parallel=True)
def deposit(x: F64, y: F64, light: F64, lattice: F64) -> None:
    """Add light (modes, n) at places (n,), in steps, to lattices (modes, rows, cols)."""
    for m in nb.prange(len(light)):
        across, down = np.empty(POINTS), np.empty(POINTS)
        for q in range(x.size):
            col, row = _weights(x[q], across), _weights(y[q], down)
            for i in range(POINTS):
                share = light[m, q] * down[i]
                for j in range(POINTS):
                    lattice[m, row + i, col + j] += share * across[j]


@kernel(parallel=True)
def deposit_rows(x: F64, y: F64, light: F64, lattice: F64) -> None:
    """Add light (modes, y.size, x.size) at all pairs of places, in steps, to lattices (modes, rows, cols)."""
    modes, rows, cols = lattice.shape
    firsts, across = np.empty(x.size, np.int64), np.empty((x.size, POINTS))
    for c in range(x.size):
        firsts[c] = _weights(x[c], across[c])
    begins, down = np.empty(y.size, np.int64), np.empty((y.size, POINTS))
    for r in range(y.size):
        begins[r] = _weights(y[r], down[r])
    for m in range(modes):
        lines = np.zeros((y.size, cols))
        for r in nb.prange(y.size):
            for c in range(x.size):
                for j in range(POINTS):
                    lines[r, firsts[c] + j] += light[m, r, c] * across[c, j]
        # One thread for each row of the lattice: what is added to it comes in one order.
        for row in nb.prange(rows):
            for r in range(y.size):
                i = row - begins[r]
                if 0 <= i < POINTS:
                    for c in range(cols):
                        lattice[m, row, c] += down[r, i] * lines[r, c]


@kernel(parallel=True)
def read(lattice: F64, step: float, first: F64, channel: U8, image: F64) -> None:
    """Add lattices (channels, …), the first point at ``first``, to photosites (images, rows, cols) at whole places."""
    images, rows, cols = channel.shape
    firsts, shares = np.empty(cols, np.int64), np.empty((cols, POINTS))
    for c in range(cols):
        firsts[c] = _weights((c - first[0]) / step, shares[c])
    for r in nb.prange(rows):
        down, line = np.empty(POINTS), np.zeros((len(lattice), lattice.shape[2]))
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
