"""One of Zernike's polynomials at many places."""

from __future__ import annotations

import numpy as np

from camsim.arrays import F64
from camsim.kernels.dispatch import kernel

AT_ONCE = 256  # places: what goes from power to power stays in the nearest cache, and loops are vectors


@kernel()
def fill_zernike(values: F64, x: F64, y: F64, factors: F64, turns: int, sine: bool, norm: float) -> None:
    """Fill in norm·(a polynomial in r²)·r^turns·cos or sin(turns·θ).

    factors : of the powers of r², highest first

    >>> import numpy as np
    >>> values = np.empty(1)
    >>> fill_zernike(values, np.array([2.0]), np.array([1.0]), np.array([1.0, 3.0]), 2, True, 0.5)
    >>> values  # ½·(r² + 3)·2xy
    array([16.])
    """
    square, radial = np.empty(AT_ONCE), np.empty(AT_ONCE)
    real, other, turned = np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE)
    for first in range(0, x.size, AT_ONCE):
        count = min(AT_ONCE, x.size - first)
        px, py, own = x[first : first + count], y[first : first + count], values[first : first + count]
        for i in range(count):
            square[i] = px[i] * px[i] + py[i] * py[i]
            radial[i], real[i], other[i] = 0.0, 1.0, 0.0
        for factor in factors:
            for i in range(count):
                radial[i] = radial[i] * square[i] + factor
        for _ in range(turns):
            for i in range(count):
                turned[i] = real[i] * px[i] - other[i] * py[i]
            for i in range(count):
                other[i] = real[i] * py[i] + other[i] * px[i]
            real, turned = turned, real
        if sine:
            real, other = other, real
        for i in range(count):
            own[i] = norm * radial[i] * real[i]
