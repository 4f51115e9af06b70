"""Kernel that fills the rows of a PSF's table with sums of Bessel functions."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel
from camsim.numerics.bessel_kernels import FAR, HANKEL, bessel_downwards, bessel_upwards

ROWS = 64  # computed together: their Bessel functions stay in the fastest cache


@kernel(allocates=True)
def fill_rows(
    radius: F64, k: F64, weight: F64, shapes: F64, curves: F64, orders: I64, odd: bool, out: F64, begin: int, end: int
) -> None:
    """Set G, the point spread and its two derivatives (4, harmonics, kinds, rows) of a table at even radii.

    k, weight : (n,) 2π times frequencies, and that times the quadrature weights
    shapes, curves : (harmonics, n) and (n, kinds) transfers of footprint and lens;  odd: whether there are odd orders
    """
    most = 2
    for m in orders:
        most = max(most, m + 2)
    kinds, far = curves.shape[1], max(FAR, most + 0.0)
    both, integral, some = np.zeros((most + 4, ROWS)), np.zeros((most + 2, ROWS)), np.zeros((8, ROWS))
    found, rows, j = np.empty((4, len(orders), kinds, ROWS)), np.zeros(ROWS), both[2:]
    for first in range(begin, end, ROWS):
        count = min(ROWS, end - first)
        for i in range(ROWS):
            rows[i] = radius[first] + i * (radius[1] - radius[0])
            for q in range(4):
                for h in range(len(orders)):
                    for c in range(kinds):
                        found[q, h, c, i] = 0.0
        for n in range(len(k)):
            near = count
            while near > 0 and not odd and k[n] * rows[near - 1] >= far:
                near -= 1
            if near > 0:
                bessel_downwards(k[n], rows, np.uint64(near), j, integral, some)
            if near < count:
                bessel_upwards(k[n], rows, np.uint64(near), np.uint64(count), HANKEL, j, integral, some)
            for i in range(count):
                both[0, i], both[1, i] = j[2, i], -j[1, i]  # orders −2 and −1
            for h in range(len(orders)):
                m = orders[h]
                for q in range(kinds):
                    p = weight[n] * shapes[h, n] * curves[n, q]
                    g, slope, bend = p / (k[n] * k[n]), 0.5 * p * k[n], 0.25 * p * k[n] * k[n]
                    for i in range(count):
                        found[0, h, q, i] += g * integral[m, i]
                    for i in range(count):
                        found[1, h, q, i] += p * j[m, i]
                    for i in range(count):
                        found[2, h, q, i] += slope * (both[m + 1, i] - both[m + 3, i])
                    for i in range(count):
                        found[3, h, q, i] += bend * (both[m, i] - 2.0 * j[m, i] + both[m + 4, i])
        for q in range(4):
            for h in range(len(orders)):
                for c in range(kinds):
                    for i in range(count):
                        out[q, h, c, first + i] = found[q, h, c, i]
