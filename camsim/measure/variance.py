"""The variance of every photosite about a fit, from residuals that the fit has made smaller."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64

_FEW = 8.0
"""Free photosites, below which a group tells no variance of its own."""


def variances(d: F64, level: F64, r: F64, leverage: F64, *, away: float, rise: float) -> F64:
    """Return the variance of each photosite.

    d     : distance from the edge;  level: fitted signal, 0 on the dark side, 1 on the bright one;  r: residual
    away  : how far from the edge its two sides begin

    A photosite pulls the fit towards itself by its leverage, and its residual is smaller for it: for even noise
    E[r²] = (1 − leverage)·σ². So Σr²/Σ(1 − leverage) is the variance of a group; of one photosite, or of the few on
    the rise of a sharp edge, the quotient of two small numbers says next to nothing. Noise changes with the light, as
    photon noise does: it is taken from the two sides, and between them in proportion to the level. What is found near
    the edge beyond that is what the model does not follow, and comes on top there.
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
