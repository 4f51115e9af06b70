"""The taper between one level of frequencies and the next."""

from __future__ import annotations

import functools
import math

import numpy as np
import scipy

from camsim.core.arrays import F64

TAPER_DEGREE, ROUNDING = 63, 1e-17


def taper_margin(level: float) -> tuple[float, float]:
    """Return the half bandwidth of the taper's slope (in 1/width) and its β, for side lobes of ``level``.

    The taper's slope is a Kaiser–Bessel window: its transform is sinh(√(β² − x²))/√(…) with x = π·k·width up to
    x = β, and beyond only ripples of about 1/sinh β of its height.
    """
    sharpness = math.log(2.0 / level) + 1.0
    return (sharpness + 1.0) / math.pi, sharpness


@functools.lru_cache(maxsize=64)
def taper(sharpness: float) -> F64:
    """Return the taper from ½ at −1 to −½ at 1, as coefficients of the Chebyshev polynomials of odd degree.

    It is the negative integral of its window, whose highest degrees are left out below rounding.
    """
    window = np.polynomial.Chebyshev.interpolate(
        lambda t: scipy.special.i0(sharpness * np.sqrt((1.0 - t) * (1.0 + t))) / scipy.special.i0(sharpness),
        TAPER_DEGREE,
    )
    odd: F64 = np.array(window.integ().coef[1::2], np.float64)
    odd *= -0.5 / odd.sum()
    return odd[: int(np.flatnonzero(np.abs(odd) > ROUNDING).max()) + 1]


def tapered(distance: F64, inner: float, outer: float, shape: F64) -> F64:
    """Return the taper, 1 up to the inner and 0 from the outer radius on, at distances (0 or more)."""
    values: F64 = np.where(distance < outer, 1.0, 0.0)
    between = (distance > inner) & (distance < outer)
    t = (2.0 * distance[between] - inner - outer) / (outer - inner)
    # Clenshaw's recurrence over odd degrees: T_{n+2} = 2·T_2·T_n − T_{n−2}.
    twice = 4.0 * t * t - 2.0
    one, two = np.zeros_like(t), np.zeros_like(t)
    for c in shape[::-1].tolist():
        two *= -1.0
        two += c
        two += twice * one
        one, two = two, one
    values[between] = 0.5 + t * (one - two)
    return values
