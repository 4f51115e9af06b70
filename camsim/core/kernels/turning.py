"""Cosine and sine of angles in turns, for loops that vectorise."""

from __future__ import annotations

import math

from camsim.core.kernels.dispatch import kernel

S3, S5, S7, S9, S11, S13, S15 = (math.pow(-1.0, n) / math.factorial(2 * n + 1) for n in range(1, 8))
C2, C4, C6, C8, C10, C12, C14, C16 = (math.pow(-1.0, n) / math.factorial(2 * n) for n in range(1, 9))


@kernel(forceinline=True)
def turned(turns: float) -> tuple[float, float]:
    """Return cosine and sine to 1e-11, from Taylor series of half the angle; loops over it vectorise."""
    h = math.pi * (turns - math.floor(turns + 0.5))
    z = h * h
    odd = S13 + z * S15
    odd = h * (1.0 + z * (S3 + z * (S5 + z * (S7 + z * (S9 + z * (S11 + z * odd))))))
    even = C12 + z * (C14 + z * C16)
    even = 1.0 + z * (C2 + z * (C4 + z * (C6 + z * (C8 + z * (C10 + z * even)))))
    return 1.0 - 2.0 * odd * odd, 2.0 * odd * even
