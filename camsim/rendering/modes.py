"""Choice of a few mixtures of planes that express all planes to within an error."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64


def spanning(curves: F64, allowed: float) -> F64:
    """Return the fewest mixtures M (k, planes), orthonormal rows, that express every plane as MᵀM·planes.

    curves  : (planes, sets, n) signals of a plane of ones
    allowed : largest error of a plane, Σ |curve − MᵀM·curves| over a set

    >>> spanning(np.array([[[1.0, 2.0]], [[2.0, 4.0]], [[2.0, 4.0]]]), 1e-9).round(9).tolist()
    [[0.333333333, 0.666666667, 0.666666667]]
    """
    vectors = np.linalg.svd(curves.reshape(len(curves), -1), full_matrices=False)[0].T
    vectors *= np.where(vectors.sum(axis=1, keepdims=True) < 0.0, -1.0, 1.0)  # either sign spans the same
    rest = curves.copy()
    for count, one in enumerate(vectors[: len(curves) - 1], start=1):
        rest -= one[:, None, None] * np.einsum("p,psn->sn", one, rest)
        if np.abs(rest).sum(axis=2).max() <= allowed:
            return np.ascontiguousarray(vectors[:count])
    return np.eye(len(curves))
