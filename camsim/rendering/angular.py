"""Transfers over |f| and angle: columns of a table times cosines and sines, looked up anywhere."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel, shared

AT_ONCE = 500  # frequencies: fewer are no work for a thread of its own


@kernel(forceinline=True)
def six_points(t: float, weight: F64) -> None:
    """Write what values at −2 … 3 weigh at t, 0 … 1."""
    a, b, c, d, e = t + 2.0, t + 1.0, t - 1.0, t - 2.0, t - 3.0
    weight[0], weight[1], weight[2] = -b * t * c * d * e / 120.0, a * t * c * d * e / 24.0, -a * b * c * d * e / 12.0
    weight[3], weight[4], weight[5] = a * b * t * d * e / 12.0, -a * b * t * c * e / 24.0, a * b * t * c * d / 120.0


@kernel(forceinline=True)
def turns(x: float, y: float, cos: F64, sin: F64) -> None:
    """Write cos mφ and sin mφ of the direction (x, y), which may be none."""
    size = math.sqrt(x * x + y * y)
    cos[0], sin[0] = 1.0, 0.0
    u, v = (x / size, y / size) if size > 0.0 else (1.0, 0.0)
    for m in range(cos.size - 1):
        cos[m + 1], sin[m + 1] = cos[m] * u - sin[m] * v, sin[m] * u + cos[m] * v


class Transfer(NamedTuple):
    """Transfers over |f|: values (rows, columns · sets) at multiples −2, −1, 0 … of ``1/per_unit``.

    order, sine : of each column, whose transfer is real where the order is even, else imaginary
    sets        : patterns side by side in each column;  cut: the highest |f|
    """

    values: F64
    per_unit: float
    order: I64
    sine: I64
    sets: int
    cut: float

    def at(self, fx: F64, fy: F64) -> C128:
        """Return the transfers (sets, places) at places (n,)."""
        out = np.zeros((fx.size, self.sets, 2))
        shared(fx.size, functools.partial(_look_up, fx, fy, self, out), least=AT_ONCE)
        values: C128 = out.view(complex)[..., 0]
        return values.T


@kernel(error_model="numpy", fastmath={"contract"})
def _look_up(fx: F64, fy: F64, transfer: Transfer, out: F64, first: int, stop: int) -> None:
    """Write transfers at some of the places: (places, sets, 2)."""
    sets, columns = transfer.sets, transfer.order.size
    most = transfer.order.max() if columns else 0
    cos, sin = np.empty(most + 1), np.empty(most + 1)
    weight = np.empty(6)
    sums = np.empty(columns * sets)
    for place in range(first, stop):
        out[place] = 0.0
        f = math.sqrt(fx[place] * fx[place] + fy[place] * fy[place])
        if f >= transfer.cut:
            continue
        u = f * transfer.per_unit
        cell = int(u)
        t = u - cell
        six_points(t, weight)
        sums[:] = 0.0
        for k in range(6):
            own = transfer.values[cell + k]
            for q in range(sums.size):
                sums[q] += weight[k] * own[q]
        turns(fx[place], fy[place], cos, sin)
        for q in range(columns):
            m = transfer.order[q]
            turn = sin[m] if transfer.sine[q] else cos[m]
            for s in range(sets):
                out[place, s, m % 2] += turn * sums[q * sets + s]
