"""Cosine and sine of many turns, so plain that compilers take several at once."""

from __future__ import annotations

import math

from camsim.kernels import kernel


@kernel(error_model="numpy", fastmath={"contract"})
def _sine(half: float) -> float:
    """Return sin of at most a quarter of a turn."""
    h = half * half
    s = 1.0 - h * (1.0 / 272.0)
    s = 1.0 - h * (1.0 / 210.0) * s
    s = 1.0 - h * (1.0 / 156.0) * s
    s = 1.0 - h * (1.0 / 110.0) * s
    s = 1.0 - h * (1.0 / 72.0) * s
    s = 1.0 - h * (1.0 / 42.0) * s
    s = 1.0 - h * (1.0 / 20.0) * s
    return half * (1.0 - h * (1.0 / 6.0) * s)


@kernel(error_model="numpy", fastmath={"contract"})
def cosine(turns: float) -> float:
    """Return cos of 2π·turns, by the sine of half the angle."""
    s = _sine(math.pi * (turns - math.floor(turns + 0.5)))
    return 1.0 - 2.0 * s * s


@kernel(error_model="numpy", fastmath={"contract"})
def cos_sin(turns: float) -> tuple[float, float]:
    """Return cos and sin of 2π·turns, by the series of half the angle, at most a quarter of a turn: 2e-11."""
    half = math.pi * (turns - math.floor(turns + 0.5))
    h, s = half * half, _sine(half)
    c = 1.0 - h * (1.0 / 240.0)
    c = 1.0 - h * (1.0 / 182.0) * c
    c = 1.0 - h * (1.0 / 132.0) * c
    c = 1.0 - h * (1.0 / 90.0) * c
    c = 1.0 - h * (1.0 / 56.0) * c
    c = 1.0 - h * (1.0 / 30.0) * c
    c = 1.0 - h * (1.0 / 12.0) * c
    c = 1.0 - h * (1.0 / 2.0) * c
    return 1.0 - 2.0 * s * s, 2.0 * s * c
