"""Planes made fewer: what many of them give one channel are often few curves, to what may be wrong."""

from __future__ import annotations

import numpy as np

from camsim.arrays import F64


def mixed(curves: F64, allowed: float) -> tuple[F64, F64]:
    """Return modes (m, n) and mixtures (m, planes) with curves ≈ mixturesᵀ·modes, no more of them than keep the error.

    curves  : (planes, n) what a plane of ones gives, anywhere
    allowed : largest difference of any plane's curve

    >>> modes, mixture = mixed(np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]), 1e-9)
    >>> np.einsum("mp,mn->pn", mixture, modes).round(9).tolist()
    [[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]
    >>> len(modes)
    1
    """
    left, size, right = np.linalg.svd(curves, full_matrices=False)
    # What is left out of plane p after m modes: Σ over the others of left[p, k]·size[k]·right[k].
    rest = np.cumsum((np.abs(left) * size * np.abs(right).max(axis=1))[:, ::-1], axis=1)[:, ::-1].max(axis=0)
    count = max(1, int(np.count_nonzero(rest > allowed)))
    return np.ascontiguousarray(size[:count, None] * right[:count]), np.ascontiguousarray(left[:, :count].T)
