"""Splines through the samples of pictures."""

from __future__ import annotations

import functools

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel, shared

PLACES_AT_ONCE = 10_000


def coefficients_of(samples: F64) -> F64:
    """Return the cubic B-spline coefficients of pictures (n, rows, cols), mirrored half a sample beyond their ends.

    They solve c[k − 1] + 4·c[k] + c[k + 1] = 6·sample[k] down columns and along rows.

    >>> coefficients_of(np.array([[[1.0, 1.0, 7.0, 1.0, 1.0]]])).round(3).tolist()
    [[[1.545, -1.727, 11.364, -1.727, 1.545]]]
    """
    found: F64 = 36.0 * np.ascontiguousarray(samples, np.float64)
    down, across = (_pivots(count) for count in samples.shape[1:])
    for picture in found:
        _eliminate(picture, down, across)
    return found


def _pivots(count: int) -> F64:
    """Return the inverse pivots (count,) of the elimination."""
    pivots = np.empty(count)
    before = 0.0
    for k in range(count):
        diagonal = 4.0 + (k == 0) + (k == count - 1)
        before = pivots[k] = 1.0 / (diagonal - before)
    return pivots


@kernel()
def _eliminate(picture: F64, down: F64, across: F64) -> None:
    """Solve the equations of all columns, then of all rows, in place."""
    rows, cols = picture.shape
    for r in range(1, rows):
        for c in range(cols):
            picture[r, c] -= picture[r - 1, c] * down[r - 1]
    for r in range(rows - 1, -1, -1):
        for c in range(cols):
            below = picture[r + 1, c] if r + 1 < rows else 0.0
            picture[r, c] = (picture[r, c] - below) * down[r]
    for r in range(0, rows, 2):  # two at a time, as each step waits for the one before
        s = min(r + 1, rows - 1)
        one, two, pivot = 0.0, 0.0, 0.0
        for c in range(cols):
            one, two, pivot = picture[r, c] - one * pivot, picture[s, c] - two * pivot, across[c]
            picture[r, c], picture[s, c] = one, two
        one, two = 0.0, 0.0
        for c in range(cols - 1, -1, -1):
            one, two = (picture[r, c] - one) * across[c], (picture[s, c] - two) * across[c]
            picture[r, c], picture[s, c] = one, two


def values_of(coefficients: F64, degree: int, places: F64, some: np.ndarray | None = None) -> F64:
    """Return the values (planes, n) of splines of degree 0, 1 or 3 at places (n, 2), x and y.

    coefficients : (planes, rows, cols) on a lattice of cells: cell (r, c), from (c, r) on, uses those from (r, c) on
    some         : mask (rows, cols) of those that count; None: all

    >>> values_of(np.array([[[0.0, 4.0], [0.0, 4.0]]]), 1, np.array([[0.25, 0.5]])).tolist()
    [[1.0]]
    """
    some = np.ones(coefficients.shape[1:], bool) if some is None else some
    values = np.empty((len(coefficients), len(places)))
    work = functools.partial(_evaluate, coefficients, some, degree, places, values)
    shared(len(places), work, least=PLACES_AT_ONCE)
    return values


@kernel(allocates=True)
def _evaluate(
    coefficients: F64, some: np.ndarray, degree: int, places: F64, values: F64, begin: int, stop: int
) -> None:
    """Write the values at places begin … stop."""
    planes, rows, cols = coefficients.shape
    weights, both = np.empty((2, 4)), np.empty((4, 4))
    for n in range(begin, stop):
        col = min(max(int(places[n, 0]), 0), cols - 1 - degree)
        row = min(max(int(places[n, 1]), 0), rows - 1 - degree)
        _weigh(places[n, 0] - col, degree, weights[0])
        _weigh(places[n, 1] - row, degree, weights[1])
        for r in range(degree + 1):
            for c in range(degree + 1):
                both[r, c] = weights[1, r] * weights[0, c] if some[row + r, col + c] else 0.0
        for p in range(planes):
            value = 0.0
            for r in range(degree + 1):
                for c in range(degree + 1):
                    value += both[r, c] * coefficients[p, row + r, col + c]
            values[p, n] = value


@kernel()
def _weigh(t: float, degree: int, weights: F64) -> None:
    """Write the B-splines at a fraction of a cell."""
    u = 1.0 - t
    if degree == 0:
        weights[0] = 1.0
    elif degree == 1:
        weights[0], weights[1] = u, t
    else:
        weights[0], weights[3] = u * u * u / 6.0, t * t * t / 6.0
        weights[1] = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0
        weights[2] = (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0
