"""The least-squares system of an edge's model, solved."""

from __future__ import annotations

import functools

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.measure import spline
from camsim.measure.spline import ACROSS, EXTRAS, STRAY, TAIL, TURN, Model, Placed

_RIDGE = 1e-9


def solve(rows: Placed, v: F64, model: Model, *, tail: bool = True, stray: F64 | None = None) -> tuple[F64, F64]:
    """Return the coefficients and the inverse of the normal equations; for columns left out, both are zero.

    tail   : whether the tail and the shading across the edge are fitted
    stray : penalties on the squares of the coefficients of light from other edges; None leaves them out
    """
    matrix, right = spline.normal_equations(rows, v, model._replace(tail=tail, stray=stray is not None))
    n = model.columns
    used = np.ones(n + EXTRAS, bool)
    used[n + TAIL] = tail
    used[n + ACROSS] = tail
    used[n + TURN : n + STRAY] = bool(np.any(rows.slope))
    used[n + STRAY :] = stray is not None
    if stray is not None:
        matrix[range(n + STRAY, n + EXTRAS), range(n + STRAY, n + EXTRAS)] += stray
    chosen = np.flatnonzero(used)
    square = np.ix_(chosen, chosen)
    part = matrix[square]
    # Without photosites the curve continues smoothly: a tiny penalty on its third differences.
    part[:n, :n] += _RIDGE * v.size / n * _third_differences(n)
    part[np.diag_indices_from(part)] *= 1.0 + 1e-14
    factor, fault = scipy.linalg.lapack.dpotrf(part, lower=True)  # of cho_factor's time, half is its checks
    if fault:
        raise np.linalg.LinAlgError("an edge's model is singular")
    coefficients, inverse = np.zeros(n + EXTRAS), np.zeros((n + EXTRAS, n + EXTRAS))
    coefficients[chosen] = scipy.linalg.lapack.dpotrs(factor, right[chosen], lower=True)[0]
    inverse[square] = scipy.linalg.lapack.dpotrs(factor, np.eye(chosen.size), lower=True)[0]
    return coefficients, inverse


@functools.cache
def _third_differences(columns: int) -> F64:
    """Return the sum of squares of third differences as a matrix."""
    third = np.diff(np.eye(columns), 3, axis=0)
    return third.T @ third
