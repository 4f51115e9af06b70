"""The taper between one level of frequencies and the next."""

from __future__ import annotations

import functools
import math

import numpy as np
import scipy

from camsim.core.arrays import F64

TAPER_DEGREE = 63


def taper_margin(level: float) -> tuple[float, float]:
    """Return the half bandwidth of the taper's slope (in 1/width) and its β, for side lobes of ``level``.

    The taper's slope is a Kaiser–Bessel window: its transform is sinh(√(β² − x²))/√(…) with x = π·k·width up to
    x = β, and beyond only ripples of about 1/sinh β of its height.
    """
    sharpness = math.log(2.0 / level) + 1.0
    return (sharpness + 1.0) / math.pi, sharpness


@functools.lru_cache(maxsize=64)
def taper(sharpness: float) -> np.polynomial.Chebyshev:
    """Return the taper from 1 at −1 to 0 at 1 as a polynomial: 1 minus the integral of its window from −1."""
    window = np.polynomial.Chebyshev.interpolate(
        lambda t: scipy.special.i0(sharpness * np.sqrt((1.0 - t) * (1.0 + t))) / scipy.special.i0(sharpness),
        TAPER_DEGREE,
    )
    total = window.integ(lbnd=-1)
    return 1.0 - total / total(1.0)


def tapered(distance: F64, inner: float, outer: float, shape: np.polynomial.Chebyshev) -> F64:
    """Return the taper, 1 up to the inner and 0 from the outer radius on, at distances (0 or more)."""
    if outer == inner:
        return np.ones_like(distance)
    t = np.clip((2.0 * distance - inner - outer) / (outer - inner), -1.0, 1.0)
    values: F64 = shape(t)
    return values
