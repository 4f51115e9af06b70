"""Kernels for Bessel functions of all orders up to some, and their integrals, at evenly spaced arguments.

Unsigned indices are not tested for being negative; with the test, loops would not be vectorised.
"""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel

FAR, TERMS = 25.0, 9  # argument from which on Hankel's series with this many terms has full precision
FARTHER, FEWER = 60.0, 4  # and with fewer terms
SMALLEST, LEAST = 1e-14, 1e-150  # argument taken for 0, and the first of a recurrence
BEYOND = 11.5  # times x^{1/3}: orders so far beyond x have J_n(x) < 1e-16


def _hankel(order: int) -> tuple[list[float], list[float]]:
    """Return the coefficients of Hankel's expansion, even and odd, in powers of −1/x² (DLMF 10.17.3)."""
    a = [1.0]
    for k in range(1, 2 * TERMS):
        a.append(a[-1] * (4 * order**2 - (2 * k - 1) ** 2) / (8 * k))
    signed = [value if k % 4 < 2 else -value for k, value in enumerate(a)]
    return signed[::2], signed[1::2]


HANKEL = np.array([*_hankel(0), *_hankel(1)])


@kernel()
def bessel_upwards(
    k: float, radius: F64, begin: np.uint64, end: np.uint64, series: F64, j: F64, integral: F64, some: F64
) -> None:
    """Set columns of J_0, J_1 … and, for even orders, ∫ J_m(t) t dt from 0 to x = k·radius, which are even and large.

    j, integral : (orders, radii);  some: (8, radii) for intermediate results
    The first two orders are Hankel's series, the others come by recurrence.
    """
    most = len(j) - 2
    x, step = k * radius[begin], k * (radius[1] - radius[0])
    terms = TERMS if x < FARTHER else FEWER
    c, s, step_c, step_s = math.cos(x), math.sin(x), math.cos(step), math.sin(step)
    for i in range(begin, end):
        some[0, i], some[1, i] = c, s
        c, s = c * step_c - s * step_s, c * step_s + s * step_c
    for i in range(begin, end):
        one = 1.0 / (k * radius[i])
        some[2, i], some[3, i] = one, one * one
        some[4, i], some[5, i], some[6, i], some[7, i] = 0.0, 0.0, 0.0, 0.0
    for t in range(terms - 1, -1, -1):
        for q in range(4):
            a = series[q, t]
            for i in range(begin, end):
                some[4 + q, i] = some[4 + q, i] * some[3, i] + a
    for i in range(begin, end):
        one = some[2, i]
        size = math.sqrt(one / math.pi)
        more, less = size * (some[1, i] + some[0, i]), size * (some[1, i] - some[0, i])
        j[0, i] = some[4, i] * more - some[5, i] * one * less
        j[1, i] = some[6, i] * less + some[7, i] * one * more
        integral[0, i] = j[1, i] / one
        some[4, i], some[5, i] = 1.0 - j[0, i], 2.0 / one
    for m in range(1, most + 1):
        two = 2.0 * m
        for i in range(begin, end):
            j[m + 1, i] = two * some[2, i] * j[m, i] - j[m - 1, i]
    # With Q_m = ∫ J_m: Q_{m+1} = Q_{m−1} − 2J_m and I_{m+1} = I_{m−1} − 2x·J_m + 2Q_m.
    for m in range(1, most, 2):
        for i in range(begin, end):
            integral[m + 1, i] = integral[m - 1, i] - some[5, i] * j[m, i] + 2.0 * some[4, i]
            some[4, i] -= 2.0 * j[m + 1, i]


@kernel()
def bessel_downwards(k: float, radius: F64, end: np.uint64, j: F64, integral: F64, some: F64) -> None:
    """Set columns of the same for all orders and any x, by Miller's recurrence from an order at which J vanishes."""
    most, first = len(j) - 2, np.uint64(0)
    for i in range(first, end):
        x = max(k * radius[i], SMALLEST)
        some[0, i], some[1, i], some[2, i], some[3, i], some[4, i], some[5, i] = x, 2.0 / x, 0.0, LEAST, 0.0, 0.0
    largest = k * radius[end - np.uint64(1)]
    for n in range(int(max(float(most), largest + BEYOND * largest ** (1.0 / 3.0))) + 4, -1, -1):
        sums, twice, wide = 4 + n % 2, 2.0 * n, False  # Σ J_n of the same parity from here on up
        for i in range(first, end):
            some[sums, i] += some[3, i]
        if n <= most:
            for i in range(first, end):
                j[n, i] = some[3, i]
                # I_m = x·J_{m+1} + 2m·Σ J_{m+2}, J_{m+4} …
                integral[n, i] = some[0, i] * some[2, i] + twice * (some[sums, i] - some[3, i])
        for i in range(first, end):
            now = some[3, i]
            some[2, i], some[3, i] = now, n * some[1, i] * now - some[2, i]
            wide |= abs(some[3, i]) > 1.0 / LEAST
        if wide:
            for i in range(first, end):
                less = LEAST if abs(some[3, i]) > 1.0 / LEAST else 1.0
                for q in range(2, 6):
                    some[q, i] *= less
                for m in range(n, most + 1):
                    j[m, i] *= less
                    integral[m, i] *= less
    for i in range(first, end):
        some[1, i] = 1.0 / (2.0 * some[4, i] - j[0, i])
    for m in range(most + 1):
        for i in range(first, end):
            j[m, i] *= some[1, i]
            integral[m, i] *= some[1, i]
