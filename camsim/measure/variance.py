"""The variance of every photosite about a fit, from residuals corrected for leverage."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64

_FEW = 8.0
"""Degrees of freedom below which a group gives no separate variance."""


def variances(d: F64, level: F64, r: F64, leverage: F64, *, away: float, rise: float) -> F64:
    """Return the variance of each photosite.

    d     : distance from the edge;  level: fitted signal, 0 on the dark side, 1 on the bright one;  r: residual
    away  : distance from the edge at which its two sides begin

    Leverage reduces the residual of a photosite: for uniform noise E[r²] = (1 − leverage)·σ². So Σr²/Σ(1 − leverage)
    is the variance of a group; for one photosite, or the few on the rise of a sharp edge, this quotient of two small
    numbers is uninformative. Noise depends on the light, as photon noise does: it is estimated on the two sides and
    interpolated by level. Excess near the edge is model misfit, and is added there.
    """
    square, free = r * r, np.maximum(1.0 - leverage, 0.0)

    def of(group: npt.NDArray[np.bool_], otherwise: float) -> float:
        total = float(np.sum(free[group]))
        return float(np.sum(square[group])) / total if total > _FEW else otherwise

    every = float(np.sum(square)) / max(float(np.sum(free)), 1.0)
    dark, bright = of(d < -away, every), of(d > away, every)
    variance: F64 = dark + (bright - dark) * np.clip(level, 0.0, 1.0)
    near = np.abs(d) <= rise
    total = float(np.sum(free[near]))
    more = float(np.sum(square[near] - free[near] * variance[near])) / total if total > 0.0 else 0.0
    variance[near] += max(more, 0.0)
    return variance
