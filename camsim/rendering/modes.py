"""Choice of a few planes of which all others are mixtures to within an error."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, I64


def spanning(curves: F64, allowed: float) -> tuple[I64, F64]:
    """Return the rows (k,) of a few curves, and mixtures (k, planes) such that curves ≈ mixturesᵀ·curves[rows].

    curves  : (planes, n) signal of a plane of ones
    allowed : largest error of any plane's curve

    >>> rows, mixture = spanning(np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]), 1e-9)
    >>> rows.tolist(), mixture.round(9).tolist()
    ([2], [[0.333333333, 0.666666667, 1.0]])
    """
    rest = curves.copy()
    rows: list[int] = []
    basis: list[F64] = []
    while not rows or (len(rows) < len(curves) and np.abs(rest).max() > allowed):
        # The curve with the largest residual is next; no BLAS, whose sums depend on its threads.
        size = np.einsum("pn,pn->p", rest, rest)
        worst = int(np.argmax(size))
        if size[worst] == 0.0:
            return np.array([worst]), np.zeros((1, len(curves)))
        rows.append(worst)
        basis.append(rest[worst] / np.sqrt(size[worst]))
        for one in basis[-1:] + basis:
            rest -= np.einsum("pn,n->p", rest, one)[:, None] * one
    shares = np.einsum("mn,pn->mp", np.stack(basis), curves)
    return np.array(rows), np.linalg.solve(shares[:, rows], shares)
