"""Rotations, exact at multiples of a quarter turn."""

from __future__ import annotations

import math

QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


def cosine_and_sine(degrees: float) -> tuple[float, float]:
    """Return cosine and sine of an angle, exact at multiples of 90 degrees.

    >>> cosine_and_sine(270.0)
    (0.0, -1.0)
    """
    quarters = degrees / 90.0
    if quarters.is_integer():
        return QUARTERS[int(quarters) % 4]
    angle = math.radians(degrees)
    return math.cos(angle), math.sin(angle)
