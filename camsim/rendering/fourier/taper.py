"""The taper that brings a pattern to 0 before the period could wrap it round."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import F64

TAPER_DEGREE = 63


class Hem(NamedTuple):
    """A round taper: 1 out to ``inner``, 0 from ``outer`` on, with the β of its Kaiser–Bessel window."""

    inner: float
    outer: float
    sharpness: float

    @property
    def band(self) -> float:
        """How far its transform reaches, but for what it leaves outside: cycles per unit of its radii."""
        return (self.sharpness + 1.0) / (math.pi * (self.outer - self.inner))


def taper_margin(level: float) -> tuple[float, float]:
    """Return how far the taper's band reaches (in 1/width) and its β, for side lobes of ``level``.

    The taper's slope is a Kaiser–Bessel window: its transform is sinh(√(β² − x²))/√(…) with x = π·k·width up to
    x = β, and beyond only ripples of about 1/sinh β of its height.
    """
    sharpness = math.log(2.0 / level) + 1.0
    return (sharpness + 1.0) / math.pi, sharpness


def hem_from(inner: float, level: float, frame: float, cutoff: float) -> Hem:
    """Return a taper from ``inner`` on, for side lobes of ``level``, about a frame and below a cutoff.

    It is as wide as makes (cutoff + margin/width)·(frame + 2·(inner + width)) smallest, or nearly.
    """
    margin, sharpness = taper_margin(min(max(level, 1e-14), 1.0))
    return Hem(inner, inner + math.sqrt(margin * (frame + 2.0 * inner) / (2.0 * cutoff)), sharpness)


@functools.lru_cache(maxsize=64)
def taper(sharpness: float) -> np.polynomial.Chebyshev:
    """Return the taper from 1 at −1 to 0 at 1 as a polynomial: 1 minus the running integral of its window."""
    window = np.polynomial.Chebyshev.interpolate(
        lambda t: scipy.special.i0(sharpness * np.sqrt((1.0 - t) * (1.0 + t))) / scipy.special.i0(sharpness),
        TAPER_DEGREE,
    )
    total = window.integ(lbnd=-1)
    return 1.0 - total / total(1.0)


def tapered(distance: F64, inner: float, outer: float, shape: np.polynomial.Chebyshev) -> F64:
    """Return the taper at distances (0 or more)."""
    if outer == inner:
        return np.ones_like(distance)
    t = np.clip((2.0 * distance - inner - outer) / (outer - inner), -1.0, 1.0)
    values: F64 = shape(t)
    return values
