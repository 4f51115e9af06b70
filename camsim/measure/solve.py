"""The least-squares system of an edge's model, solved."""

from __future__ import annotations

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
    matrix, right = spline.normal_equations(rows, v, model)
    n = model.columns
    used = np.ones(n + EXTRAS, bool)
    used[n + TAIL] = tail
    used[n + ACROSS] = tail
    used[n + TURN : n + STRAY] = bool(np.any(rows.slope))
    used[n + STRAY :] = stray is not None
    if stray is not None:
        matrix[range(n + STRAY, n + EXTRAS), range(n + STRAY, n + EXTRAS)] += stray
    chosen = np.flatnonzero(used)
    part = matrix[np.ix_(chosen, chosen)]
    # Without photosites the curve continues smoothly: a tiny penalty on its third differences.
    third = np.diff(np.eye(n), 3, axis=0)
    part[:n, :n] += _RIDGE * v.size / n * (third.T @ third)
    factor = scipy.linalg.cho_factor(part + 1e-14 * np.diag(np.diag(part)), lower=True)
    coefficients, inverse = np.zeros(n + EXTRAS), np.zeros((n + EXTRAS, n + EXTRAS))
    coefficients[chosen] = scipy.linalg.cho_solve(factor, right[chosen])
    inverse[np.ix_(chosen, chosen)] = scipy.linalg.cho_solve(factor, np.eye(chosen.size))
    return coefficients, inverse
