"""Reduction of planes to few modes that represent all of their curves to within an error."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64


def mixed(curves: F64, allowed: float, most: int | None = None) -> tuple[F64, F64]:
    """Return modes (m, n) and mixtures (m, planes) with curves ≈ mixturesᵀ·modes, as few as the error allows.

    curves  : (planes, n) signal of a plane of ones
    allowed : largest error of any plane's curve
    most    : largest number of modes, whether they reach the error or not

    >>> modes, mixture = mixed(np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]), 1e-9)
    >>> np.einsum("mp,mn->pn", mixture, modes).round(9).tolist()
    [[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]
    >>> len(modes)
    1
    """
    rest = curves.copy()
    basis: list[F64] = []
    while len(basis) < min(len(curves), most or len(curves)) and np.abs(rest).max() > allowed:
        # The curve with the largest residual gives the next mode; no BLAS, whose sums depend on its threads.
        size = np.einsum("pn,pn->p", rest, rest)
        worst = int(np.argmax(size))
        basis.append(rest[worst] / np.sqrt(size[worst]))
        for one in basis[-1:] + basis:
            rest -= np.einsum("pn,n->p", rest, one)[:, None] * one
    if not basis:
        return np.zeros((1, curves.shape[1])), np.zeros((1, len(curves)))
    modes = np.stack(basis)
    return modes, np.einsum("mn,pn->mp", modes, curves)
