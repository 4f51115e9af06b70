"""The radial potential Φ of a lens, Φ'(r) = E(r)/2πr: the flux of its gradient through edges is the light.

If a pattern depends only on ρ = r/blur, so does Φ: one table serves every f-number and every wavelength.
"""

from __future__ import annotations

import functools
import math
import threading

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics.pattern import Pattern

STEP_PER_BLUR = 1.0 / 32.0
ORDER = 10  # points of the Lagrange rule; with the step above its error is below 1e-12
_GAUSS_X, _GAUSS_W = gauss_legendre(8)  # on a step of 1/32 exact to rounding
_lock = threading.Lock()


def potential(pattern: Pattern, rho_max: float) -> F64:
    """Return Φ(i·step), i = 0, 1, … past ``rho_max``; Φ(0) = 0."""
    cells = 2048
    while cells * STEP_PER_BLUR < rho_max + ORDER * STEP_PER_BLUR:
        cells *= 2
    with _lock:
        return _potential(pattern, cells)


@functools.cache
def _potential(pattern: Pattern, cells: int) -> F64:
    edge = np.arange(cells) * STEP_PER_BLUR
    rho = edge[:, None] + 0.5 * STEP_PER_BLUR * (1.0 + _GAUSS_X)
    slope = pattern.energy(rho) / (2.0 * math.pi * rho)
    phi = np.concatenate([[0.0], np.cumsum(slope @ _GAUSS_W * (0.5 * STEP_PER_BLUR))])
    phi.flags.writeable = False
    return phi


@kernel(forceinline=True)
def lagrange_weights(t: float, order: int, scale: F64, out: F64) -> None:
    """Write the Lagrange weights of the nodes 1 − order/2 … order/2 at 0 ≤ t < 1 into ``out``.

    ``scale`` is ``lagrange_scale(order)``; products from either side keep it linear in the order.
    """
    u = t - (1 - order // 2)
    left = 1.0
    for i in range(order):
        out[i] = left * scale[i]
        left *= u - i
    right = 1.0
    for i in range(order - 1, -1, -1):
        out[i] *= right
        right *= u - i


@kernel(forceinline=True)
def eight_points(t: float) -> tuple[float, float, float, float, float, float, float, float]:
    """Lagrange weights of the eight nodes −3 … 4 at 0 ≤ t < 1; scalars, so that they stay in registers."""
    d0, d1, d2, d3 = t + 3.0, t + 2.0, t + 1.0, t
    d4, d5, d6, d7 = t - 1.0, t - 2.0, t - 3.0, t - 4.0
    p01, p23, p45, p67 = d0 * d1, d2 * d3, d4 * d5, d6 * d7
    p0123, p4567 = p01 * p23, p45 * p67
    a, b, c, d = p23 * p4567, p01 * p4567, p0123 * p67, p0123 * p45
    return (
        d1 * a * (-1.0 / 5040.0),
        d0 * a * (1.0 / 720.0),
        d3 * b * (-1.0 / 240.0),
        d2 * b * (1.0 / 144.0),
        d5 * c * (-1.0 / 144.0),
        d4 * c * (1.0 / 240.0),
        d7 * d * (-1.0 / 720.0),
        d6 * d * (1.0 / 5040.0),
    )


def lagrange_scale(order: int) -> F64:
    """Return 1/Π_{j≠i}(i − j), the constant part of the Lagrange weights."""
    return np.array(
        [(-1.0) ** (order - 1 - i) / (math.factorial(i) * math.factorial(order - 1 - i)) for i in range(order)]
    )


SCALE = lagrange_scale(ORDER)


@kernel(forceinline=True)
def at_cell(radial: F64, cell: int, weights: F64) -> float:
    """Interpolate an even function tabulated (``radial``) at 0, 1, 2 …, in a cell whose Lagrange weights are given."""
    value = 0.0
    for m in range(ORDER):
        value += weights[m] * radial[abs(cell + 1 - ORDER // 2 + m)]
    return value


@kernel(forceinline=True)
def at_radius(radial: F64, u: float, weights: F64) -> float:
    """Interpolate at u ≥ 0 an even function tabulated (``radial``) at 0, 1, 2 …; ``weights`` is (ORDER,) scratch."""
    cell = int(u)
    lagrange_weights(u - cell, ORDER, SCALE, weights)
    return at_cell(radial, cell, weights)


def contract(phi: F64, blur: F64, weights: F64, step: float, count: int) -> F64:
    """Return Σ_j weights[k, j]·Φ(m·step/blur[j]) as (k, m): the potential of a polychromatic pattern."""
    out = np.zeros((count, len(weights)))  # sets contiguous: loops vectorise
    _contract(phi, blur, np.ascontiguousarray(weights.T), step, np.empty(ORDER), out)
    return np.ascontiguousarray(out.T)


@kernel()
def _contract(phi: F64, blur: F64, of_wavelength: F64, step: float, scratch: F64, out: F64) -> None:
    count, sets = out.shape
    for j in range(blur.size):
        scale = step / (blur[j] * STEP_PER_BLUR)
        for m in range(count):
            value = at_radius(phi, m * scale, scratch)
            for k in range(sets):
                out[m, k] += of_wavelength[j, k] * value
