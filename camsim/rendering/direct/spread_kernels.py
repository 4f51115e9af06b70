"""Kernels that fill the rows of a PSF's table with sums of Bessel functions."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel

FAR, TERMS = 25.0, 9  # argument from which on Hankel's series with this many terms has full precision
FARTHER, FEWER = 60.0, 4  # and with fewer terms


def _hankel(order: int) -> tuple[list[float], list[float]]:
    """Return the coefficients of Hankel's expansion, even and odd, in powers of −1/x² (DLMF 10.17.3)."""
    a = [1.0]
    for k in range(1, 2 * TERMS):
        a.append(a[-1] * (4 * order**2 - (2 * k - 1) ** 2) / (8 * k))
    signed = [value if k % 4 < 2 else -value for k, value in enumerate(a)]
    return signed[::2], signed[1::2]


SERIES = np.array([*_hankel(0), *_hankel(1)])


@kernel(forceinline=True)
def _upwards(x: float, one: float, wave: tuple[float, float], most: int, series: F64, j: F64, integral: F64) -> None:
    """Set J_0 … J_most and, for even orders, ∫ J_m(t) t dt from 0 to a large x, by recurrence from J_0 and J_1.

    one, wave : 1/x, and cosine and sine of x over √(πx)
    """
    square = one * one
    p0, q0, p1, q1 = 0.0, 0.0, 0.0, 0.0
    for k in range((TERMS if x < FARTHER else FEWER) - 1, -1, -1):
        p0, q0 = p0 * square + series[0, k], q0 * square + series[1, k]
        p1, q1 = p1 * square + series[2, k], q1 * square + series[3, k]
    q0, q1 = q0 * one, q1 * one
    cos, sin = wave
    j[0] = p0 * (sin + cos) - q0 * (sin - cos)
    j[1] = p1 * (sin - cos) + q1 * (sin + cos)
    for m in range(1, most):
        j[m + 1] = 2.0 * m * one * j[m] - j[m - 1]
    # With Q_m = ∫ J_m: Q_{m+1} = Q_{m−1} − 2J_m and I_{m+1} = I_{m−1} − 2x·J_m + 2Q_m.
    total = 1.0 - j[0]
    integral[0] = x * j[1]
    for m in range(1, most, 2):
        integral[m + 1] = integral[m - 1] - 2.0 * x * j[m] + 2.0 * total
        total -= 2.0 * j[m + 1]


@kernel()
def _downwards(x: float, most: int, j: F64, integral: F64) -> None:
    """Set the same for all orders, by Miller's recurrence downwards from an order at which J vanishes."""
    if x < 1e-8:
        j[: most + 1] = 0.0
        integral[: most + 1] = 0.0
        j[0] = 1.0
        return
    order = int(1.2 * max(float(most), x)) + 36
    above, now = 0.0, 1e-200
    total, odd, even = 0.0, 0.0, 0.0  # Σ J_n of the same parity from here on up
    for n in range(order, -1, -1):
        if n % 2:
            odd += now
        else:
            even += now
        if n <= most:
            j[n] = now
            # I_m = x·J_{m+1} + 2m·Σ J_{m+2}, J_{m+4} …
            integral[n] = x * above + 2.0 * n * ((odd if n % 2 else even) - now)
        above, now = now, 2.0 * n / x * now - above
        if abs(now) > 1e150:
            above, now, odd, even = above * 1e-150, now * 1e-150, odd * 1e-150, even * 1e-150
            for m in range(n, most + 1):
                j[m] *= 1e-150
                integral[m] *= 1e-150
    total = 1.0 / (2.0 * even - j[0])
    for m in range(most + 1):
        j[m] *= total
        integral[m] *= total


@kernel(allocates=True)
def fill_rows(
    radius: F64, k: F64, weight: F64, shapes: F64, curves: F64, orders: I64, odd: bool, out: F64, begin: int, end: int
) -> None:
    """Add G, the point spread and its two derivatives to rows (rows, 4, harmonics, kinds) of a table, at even radii.

    k, weight : (n,) 2π times frequencies, and that times the quadrature weights
    shapes, curves : (harmonics, n) and (n, kinds) transfers of footprint and lens;  odd: whether there are odd orders
    """
    most = 2
    for m in orders:
        most = max(most, m + 2)
    j, integral = np.zeros(most + 2), np.zeros(most + 2)
    far = max(FAR, most + 0.0)
    step = radius[1] - radius[0]
    one, size = np.empty(len(radius)), np.empty(len(radius))
    for row in range(begin, end):
        one[row] = 1.0 / max(radius[row], 1e-300)
        size[row] = math.sqrt(one[row] / math.pi)
    for n in range(len(k)):
        x = k[n] * radius[begin] if begin < end else 0.0
        cos, sin, step_cos, step_sin = math.cos(x), math.sin(x), math.cos(k[n] * step), math.sin(k[n] * step)
        one_k, size_k = 1.0 / k[n], 1.0 / math.sqrt(k[n])
        for row in range(begin, end):
            x = k[n] * radius[row]
            if x > far and not odd:
                now = size_k * size[row]
                _upwards(x, one_k * one[row], (now * cos, now * sin), most, SERIES, j, integral)
            else:
                _downwards(x, most, j, integral)
            cos, sin = cos * step_cos - sin * step_sin, cos * step_sin + sin * step_cos
            for h in range(len(orders)):
                m = orders[h]
                if m == 0:
                    slope, bend = -j[1], 0.5 * (j[2] - j[0])
                elif m == 1:
                    slope, bend = 0.5 * (j[0] - j[2]), 0.25 * (j[3] - 3.0 * j[1])
                else:
                    slope, bend = 0.5 * (j[m - 1] - j[m + 1]), 0.25 * (j[m - 2] - 2.0 * j[m] + j[m + 2])
                share = weight[n] * shapes[h, n]
                g, p = share * integral[m] * one_k * one_k, share * j[m]
                slope, bend = share * k[n] * slope, share * k[n] * k[n] * bend
                for q in range(curves.shape[1]):
                    curve = curves[n, q]
                    out[row, 0, h, q] += g * curve
                    out[row, 1, h, q] += p * curve
                    out[row, 2, h, q] += slope * curve
                    out[row, 3, h, q] += bend * curve
