"""Bessel functions J0 and J1 (SciPy's take a tenth of a second to import, with relative errors of 1e-11 far out).

``jinc`` takes SciPy's, which are faster near 0.
"""

from __future__ import annotations

import numpy as np
import scipy

from camsim.core.arrays import F64

FAR = 30.0
NODES = 18  # the error of the mean over them is of 72nd order, 2·J₇₂(30) < 1e-17
TERMS = 20  # of Hankel's series: the first one neglected is below 1e-18 from 30 on
_ALONG = np.cos((np.arange(NODES) + 0.5) * (np.pi / (2 * NODES))).tolist()


def bessel_j0_j1(x: F64) -> tuple[F64, F64]:
    """Return J0 and J1 at ``x`` ≥ 0 (any shape), with an absolute error of some 1e-16, relative for J1 near 0.

    Up to FAR, Bessel's integrals (DLMF 10.9.1, 10.9.2): the means of cos(x·cos θ) and of cos θ·sin(x·cos θ) over a
    quarter turn, by the midpoint rule, whose error is of negligible orders. Beyond, Hankel's expansion (DLMF 10.17.3).

    >>> [values.round(6).tolist() for values in bessel_j0_j1(np.array([0.0, 1.0, 100.0]))]
    [[1.0, 0.765198, 0.019986], [0.0, 0.440051, -0.077145]]
    """
    x = np.asarray(x, np.float64)
    is_far = x > FAR
    j0, j1 = np.empty(x.shape), np.empty(x.shape)
    for here, values in ((~is_far, _near), (is_far, _far)):
        if here.any():
            j0[here], j1[here] = values(x[here])
    return j0, j1


def jinc(x: F64) -> F64:
    """Return J1(x)/x at ``x`` ≥ 0 (any shape).

    >>> jinc(np.array([0.0, 1.0, 4.0])).round(6)
    array([ 0.5     ,  0.440051, -0.016511])
    """
    near = x < 1e-4
    safe = np.where(near, 1.0, x)
    values: F64 = np.where(near, 0.5 - x * x / 16.0, scipy.special.j1(safe) / safe)
    return values


def _near(x: F64) -> tuple[F64, F64]:
    j0, j1 = np.zeros(len(x)), np.zeros(len(x))
    for along in _ALONG:
        j0 += np.cos(x * along)
        j1 += along * np.sin(x * along)
    return j0 / NODES, j1 / NODES


def _far(x: F64) -> tuple[F64, F64]:
    """J_n = √(2/πx)·(P·cos ω − Q·sin ω), ω = x − nπ/2 − π/4, with cos ω and sin ω from cos x and sin x."""
    cos, sin, size = np.cos(x), np.sin(x), 1.0 / np.sqrt(np.pi * x)
    square = 1.0 / (x * x)
    # P and Q are the even and odd terms of a series Σ a_k·(i/x)^k of each order; all four by Horner's rule at once.
    p0, q0, p1, q1 = series = np.zeros((4, x.size)) + _SERIES[-1]
    for terms in _SERIES[-2::-1]:
        series *= square
        series += terms
    q0 /= x
    q1 /= x
    return size * (p0 * (sin + cos) - q0 * (sin - cos)), size * (p1 * (sin - cos) + q1 * (sin + cos))


def _hankel(order: int) -> tuple[list[float], list[float]]:
    """Return the coefficients of P and of Q, in powers of 1/x²."""
    a = [1.0]
    for k in range(1, TERMS):
        a.append(a[-1] * (4 * order**2 - (2 * k - 1) ** 2) / (8 * k))
    signed = [value if k % 4 < 2 else -value for k, value in enumerate(a)]
    return signed[::2], signed[1::2]


_SERIES = np.array([*_hankel(0), *_hankel(1)]).T[:, :, None]  # (terms, 4, 1)
