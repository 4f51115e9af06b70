"""The least-squares system of an edge's model, solved."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.measure import spline
from camsim.measure.spline import ACROSS, EXTRAS, STRAY, TAIL, TURN, Model, Placed

_RIDGE = 1e-9


class _Factored(NamedTuple):
    """The normal equations of the columns used: their Cholesky factor, and the right-hand side."""

    chosen: I64
    factor: F64
    right: F64

    @classmethod
    def of(cls, rows: Placed, v: F64, model: Model, *, tail: bool, stray: F64 | None) -> _Factored:
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
        part = matrix[chosen[:, None], chosen]
        # Without photosites the curve continues smoothly: a tiny penalty on its third differences.
        part[:n, :n] += _RIDGE * v.size / n * _third_differences(n)
        part.flat[:: chosen.size + 1] *= 1.0 + 1e-14
        if not spline.factor(part):
            raise np.linalg.LinAlgError("the normal equations of an edge's model are singular")
        return cls(chosen, part, right[chosen])

    def solution(self, right: F64) -> F64:
        solution = right.reshape(len(right), -1).copy()
        spline.substitute(self.factor, solution)
        return solution.reshape(right.shape)


def fitted(rows: Placed, v: F64, model: Model, *, tail: bool = True, stray: F64 | None = None) -> F64:
    """Return the coefficients; those of columns left out are zero.

    tail   : whether the tail and the shading across the edge are fitted
    stray : penalties on the squares of the coefficients of light from other edges; None leaves them out
    """
    found = _Factored.of(rows, v, model, tail=tail, stray=stray)
    coefficients = np.zeros(model.columns + EXTRAS)
    coefficients[found.chosen] = found.solution(found.right)
    return coefficients


def solve(rows: Placed, v: F64, model: Model, *, tail: bool = True, stray: F64 | None = None) -> tuple[F64, F64]:
    """Return the coefficients, as ``fitted`` does, and the inverse of the normal equations, zero where they are."""
    found, size = _Factored.of(rows, v, model, tail=tail, stray=stray), model.columns + EXTRAS
    coefficients, inverse = np.zeros(size), np.zeros((size, size))
    coefficients[found.chosen] = found.solution(found.right)
    inverse[np.ix_(found.chosen, found.chosen)] = found.solution(np.eye(found.chosen.size))
    return coefficients, inverse


@functools.cache
def _third_differences(columns: int) -> F64:
    """Return the sum of squares of third differences as a matrix."""
    third = np.diff(np.eye(columns), 3, axis=0)
    return third.T @ third
