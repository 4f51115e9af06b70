"""Cubic splines through the samples of pictures."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel


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
    for r in range(rows):
        for c in range(1, cols):
            picture[r, c] -= picture[r, c - 1] * across[c - 1]
        right = 0.0
        for c in range(cols - 1, -1, -1):
            right = (picture[r, c] - right) * across[c]
            picture[r, c] = right
