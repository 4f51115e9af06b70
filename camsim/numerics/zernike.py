"""Zernike polynomials by OSA/ANSI index, of unit root mean square over the unit circle.

Source: ANSI Z80.28 (OSA/VSIA report of Thibos et al., 2002): j = (n(n + 2) + m)/2; cos(mθ) for m ≥ 0, sin(|m|θ) for
m < 0; θ from x towards y (y is down here, as everywhere in camsim).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np

from camsim.core.arrays import F64, I64

LARGEST_INDEX = 230  # order 20


def orders(index: int) -> tuple[int, int]:
    """Return n and m of an OSA/ANSI index.

    >>> [orders(j) for j in (0, 1, 2, 3, 4, 7, 8, 12)]
    [(0, 0), (1, -1), (1, 1), (2, -2), (2, 0), (3, -1), (3, 1), (4, 0)]
    """
    n = math.ceil(0.5 * (math.sqrt(9.0 + 8.0 * index) - 3.0))
    return n, 2 * index - n * (n + 2)


@functools.lru_cache(maxsize=64)
def radial_steps(m: int, count: int) -> F64:
    """Return a, b, c (count, 3) of the recurrence P_p = (a·s + b)·P_{p−1} − c·P_{p−2} of R = r^m·P_p; s = r², P₀ = 1.

    They are Jacobi polynomials P_p^(0, m)(2s − 1), 1 at the rim (DLMF 18.9.2). With powers of s seven digits would
    cancel at order 20, with the recurrence none.

    >>> radial_steps(0, 2)[1]  # defocus: 2r² − 1
    array([ 2., -1.,  0.])
    """
    steps = np.zeros((count, 3))
    for p in range(1, count):
        if p == 1:
            steps[p] = m + 2.0, -(m + 1.0), 0.0
            continue
        whole, one = 2.0 * p + m, 2.0 * p * (p + m) * (2 * p + m - 2.0)
        steps[p, 0] = 2.0 * (whole - 1.0) * whole * (whole - 2.0) / one
        steps[p, 1] = -(whole - 1.0) * (whole * (whole - 2.0) + m * m) / one
        steps[p, 2] = 2.0 * (p - 1.0) * (p + m - 1.0) * whole / one
    return steps


def norm(index: int) -> float:
    """Return the factor that makes the root mean square 1 of a polynomial whose radial part is 1 at the rim."""
    n, m = orders(index)
    return math.sqrt((2 if m else 1) * (n + 1))


def zernike_sum(index: tuple[int, ...], coefficients: Sequence[float], x: F64, y: F64) -> F64:
    """Return the sum of coefficients times polynomials at (x, y), in units of the circle's radius.

    >>> zernike_sum((4,), [1.0], np.array([0.0, 1.0]), np.zeros(2)).round(4)  # defocus: √3·(2r² − 1)
    array([-1.7321,  1.7321])
    """
    # A deferred import: reading a lens from a file needs no compiler.
    from camsim.core.kernels.zernike import fill_sum

    values = np.empty(np.broadcast_shapes(np.shape(x), np.shape(y)))
    # Copies: read-only arrays have another type, for which the kernel would be compiled again.
    x, y = (np.array(one, float).ravel() for one in np.broadcast_arrays(x, y))
    places, norms, steps = layout(index)
    count = len(steps) * 2 * steps.shape[1]
    terms = np.zeros(count)
    np.add.at(terms, places, np.asarray(coefficients) * norms)
    fill_sum(values.reshape(-1), x, y, terms.reshape(len(steps), 2, -1), steps)
    return values


@functools.lru_cache(maxsize=256)
def layout(index: tuple[int, ...]) -> tuple[I64, F64, F64]:
    """Return the indices of polynomials in an array (m, cos or sin, p), their norms, and all recurrences."""
    n, m = np.array([orders(j) for j in index], np.int64).reshape(-1, 2).T
    p = (n - np.abs(m)) // 2
    azimuthal, degrees = int(np.abs(m).max(initial=0)) + 1, int(p.max(initial=0)) + 1
    places = (2 * np.abs(m) + (m < 0)) * degrees + p
    return (
        places,
        np.array([norm(j) for j in index]),
        np.stack([radial_steps(one, degrees) for one in range(azimuthal)]),
    )


def zernike(index: int, x: F64, y: F64) -> F64:
    """Return one polynomial at (x, y)."""
    return zernike_sum((index,), [1.0], x, y)


def cosines(order: int, x: F64, y: F64) -> tuple[tuple[int, ...], F64, F64, F64]:
    """Return the indices of the cosine polynomials up to an order, with their values (n, k) and slopes at points.

    >>> index, values, along_x, along_y = cosines(2, np.array([0.5]), np.array([0.0]))
    >>> index, along_x.round(4)  # slopes of 1, 2x, √3·(2r² − 1) and √6·(x² − y²) along x
    ((0, 2, 4, 5), array([[0.    , 2.    , 3.4641, 2.4495]]))
    """
    square, columns = x * x + y * y, {}
    for m in range(order + 1):
        turned, before = (x + 1j * y) ** m, m * (x + 1j * y) ** max(m - 1, 0)
        values, slopes = [np.ones_like(square)], [np.zeros_like(square)]
        for p, (a, b, c) in enumerate(radial_steps(m, (order - m) // 2 + 1)):
            if p:
                last, other = (values[p - 2], slopes[p - 2]) if p > 1 else (0.0, 0.0)
                slopes.append(a * values[-1] + (a * square + b) * slopes[-1] - c * other)
                values.append((a * square + b) * values[-1] - c * last)
            n = m + 2 * p
            index = (n * (n + 2) + m) // 2
            along_x = 2.0 * x * slopes[p] * turned.real + values[p] * before.real
            along_y = 2.0 * y * slopes[p] * turned.real - values[p] * before.imag
            columns[index] = norm(index) * np.stack([values[p] * turned.real, along_x, along_y])
    found = np.stack([columns[index] for index in sorted(columns)], axis=-1)
    return tuple(sorted(columns)), found[0], found[1], found[2]
