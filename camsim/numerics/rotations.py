"""Turns, exact at whole quarters."""

from __future__ import annotations

import math

QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


def cosine_and_sine(degrees: float) -> tuple[float, float]:
    """Return both, at whole quarters without the rounding of a cosine of π/2.

    >>> cosine_and_sine(270.0)
    (0.0, -1.0)
    """
    quarters = degrees / 90.0
    if quarters.is_integer():
        return QUARTERS[int(quarters) % 4]
    angle = math.radians(degrees)
    return math.cos(angle), math.sin(angle)
