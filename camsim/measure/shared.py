"""Noise that all photosites of a row or column share: what it adds to the covariance of a fit's right-hand side."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64
from camsim.measure import spline
from camsim.measure.spline import Model, Placed


def shared_scatter(place: F64, rows: Placed, r: F64, one: F64, model: Model, inverse: F64) -> F64:
    """Return the contribution of noise shared by photosites of a row or column to the sum of variance·row·rowᵀ.

    place : row, or column, of each photosite;  rows: rows of the fit's matrix
    r     : residuals of photosites;  one: their variances, as if all were independent

    For independent photosites the expected sum of squares of the places' residual sums is known. With V the variances,
    H the hat matrix and Z the incidence of photosites and places, it is

        E Σ_j (Σ_i∈j r_i)² = tr Zᵀ(1 − H)V(1 − H)Z;

    the excess is that of shared noise, σ² (‖Zᵀ(1 − H)Z‖² − tr Zᵀ(1 − H)Z), which ``one`` already includes. An edge
    along the rows absorbs most of it.
    """
    values, group = np.unique(place, return_inverse=True)
    sums = spline.group_sums(rows, np.ones(r.size), group, values.size, model)
    weighted = spline.group_sums(rows, one, group, values.size, model)
    count = np.bincount(group, minlength=values.size)
    taken = np.sum(inverse @ sums * sums, axis=0)
    free = float(r.size - taken.sum())
    outer = sums @ sums.T
    gram = outer @ inverse
    square = float(np.sum(count**2) - 2.0 * np.sum(count * taken) + np.einsum("ab,ba->", gram, gram))
    if not square > 2.0 * free:
        return np.zeros_like(inverse)
    spread = inverse @ spline.scatter(rows, one, model) @ inverse
    independent = float(np.sum(one) - 2.0 * float(np.sum(inverse @ weighted * sums)))
    independent += float(np.einsum("ab,ab->", spread, outer))
    found = float(np.sum(np.bincount(group, r, minlength=values.size) ** 2))
    more: F64 = max((found - independent) / (square - free), 0.0) * outer
    return more
