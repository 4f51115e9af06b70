"""Transfers over |f| and angle: columns of a table times cosines and sines, looked up anywhere."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel, shared

AT_ONCE = 500  # frequencies: fewer are no work for a thread of its own
TOGETHER = 32  # frequencies that are turned and added up side by side, as vectors; all of it stays in the nearest cache
LANES = 8  # columns of a table at a time, always as many
KINDS = 8  # of columns: even orders, then odd ones; of these cosines, then sines; of these half of it even, then odd


@kernel(forceinline=True)
def six_points(t: float, weight: F64) -> None:
    """Write what values at −2 … 3 weigh at t, 0 … 1."""
    a, b, c, d, e = t + 2.0, t + 1.0, t - 1.0, t - 2.0, t - 3.0
    p, q, r = 1.0 / 120.0, 1.0 / 24.0, 1.0 / 12.0
    weight[0], weight[1], weight[2] = -p * b * t * c * d * e, q * a * t * c * d * e, -r * a * b * c * d * e
    weight[3], weight[4], weight[5] = r * a * b * t * d * e, -q * a * b * t * c * e, p * a * b * t * c * d


@kernel(forceinline=True)
def turns(x: float, y: float, cos: F64, sin: F64) -> None:
    """Write cos mφ and sin mφ of the direction (x, y), which may be none."""
    size = math.sqrt(x * x + y * y)
    cos[0], sin[0] = 1.0, 0.0
    if cos.size > 1:
        cos[1], sin[1] = (x / size, y / size) if size > 0.0 else (1.0, 0.0)
    for m in range(2, cos.size):
        # From halves, which are known: one after the other would wait for one another.
        a, b = m // 2, m - m // 2
        cos[m], sin[m] = cos[a] * cos[b] - sin[a] * sin[b], sin[a] * cos[b] + cos[a] * sin[b]


class Transfer(NamedTuple):
    """Transfers over |f|: values (rows, sets · columns) at multiples −2, −1, 0 … of ``1/per_unit``.

    values      : with zeros up to a multiple of ``LANES``
    order, sine : of each column, whose transfer is real where the order is even, else imaginary
    ends        : (KINDS,) where each kind ends among the columns
    sets        : patterns;  cut: the highest |f|
    """

    values: F64
    per_unit: float
    order: I64
    sine: I64
    ends: I64
    sets: int
    cut: float

    @classmethod
    def of(cls, values: F64, per_unit: float, order: I64, sine: I64, cut: float) -> Transfer:
        """Return them of values (rows, columns, sets)."""
        kind = 4 * (order % 2) + 2 * sine + order // 2 % 2
        sorted_ = np.argsort(kind, kind="stable")
        flat = np.zeros((len(values), -(-values[0].size // LANES) * LANES))
        flat[:, : values[0].size] = np.moveaxis(values[:, sorted_], 1, 2).reshape(len(values), -1)
        ends = np.searchsorted(kind[sorted_], np.arange(KINDS), side="right")
        return cls(flat, per_unit, order[sorted_], sine[sorted_], ends, values.shape[2], cut)

    def at(self, fx: F64, fy: F64) -> C128:
        """Return the transfers (sets, places) at places (n,)."""
        out = np.zeros((self.sets, fx.size, 2))
        shared(fx.size, functools.partial(_look_up, fx, fy, self, out), least=AT_ONCE)
        values: C128 = out.view(complex)[..., 0]
        return values

    def on_quarters(self, steps: tuple[float, float], counts: tuple[int, int]) -> F64:
        """Return the transfers at (i·step, ±j·step), real and imaginary parts apart: (sets, 2, j, 2, i).

        counts : of i and of j, 0 on.  Where both ways are alike what is looked up at (i, j) serves (j, i).
        """
        out = np.zeros((self.sets, 2, counts[1], 2, counts[0]))
        alike = steps[0] == steps[1] and counts[0] == counts[1]
        work = functools.partial(_on_quarters, steps, alike, self, out)
        shared(counts[1], work, least=-(-AT_ONCE // counts[0]))
        return out


class _Room(NamedTuple):
    """What a look-up of ``TOGETHER`` frequencies writes to.

    weights, cells : (6, frequencies) of six points, and where they begin, −1 where nothing passes
    row, columns : of one frequency, (sets · columns, frequencies) of all
    cos, sin : (orders, frequencies);  sums: (KINDS + 4, frequencies) of a kind's columns times their own turns, and at
             the end of odd orders' times the other: what a quarter of a turn makes of their own
    """

    weights: F64
    cells: I64
    row: F64
    columns: F64
    cos: F64
    sin: F64
    sums: F64


@kernel(allocates=True, forceinline=True)
def _room(transfer: Transfer) -> _Room:
    most = transfer.order.max() if transfer.order.size else 0
    return _Room(
        np.empty((6, TOGETHER)),
        np.empty(TOGETHER, np.int64),
        np.empty(transfer.values.shape[1]),
        np.empty((transfer.values.shape[1], TOGETHER)),
        np.ones((most + 2, TOGETHER)),
        np.zeros((most + 2, TOGETHER)),
        np.empty((KINDS + 4, TOGETHER)),
    )


@kernel(forceinline=True)
def _columns(x: F64, y: F64, transfer: Transfer, room: _Room) -> None:
    """Write what the table has at places, as many as x is long, and their turns."""
    weights, cells, row, columns, cos, sin = room.weights, room.cells, room.row, room.columns, room.cos, room.sin
    values = transfer.values
    for c in range(x.size):
        f = math.sqrt(x[c] * x[c] + y[c] * y[c])
        cos[1, c], sin[1, c] = (x[c] / f, y[c] / f) if f > 0.0 else (0.0, 0.0)  # at 0 there is order 0 alone
        u = f * transfer.per_unit
        cells[c] = int(u) if f < transfer.cut else -1
        six_points(u - int(u), weights[:, c])
    for c in range(x.size):
        cell = cells[c]
        if cell < 0:
            columns[:, c] = 0.0
            continue
        a, b, d, e, g, h = weights[0, c], weights[1, c], weights[2, c], weights[3, c], weights[4, c], weights[5, c]
        for low in range(0, row.size, LANES):
            for k in range(low, low + LANES):
                row[k] = a * values[cell, k] + b * values[cell + 1, k] + d * values[cell + 2, k]
                row[k] += e * values[cell + 3, k] + g * values[cell + 4, k] + h * values[cell + 5, k]
        for k in range(row.size):
            columns[k, c] = row[k]
    for m in range(2, len(cos) - 1):
        # From halves, which are known.
        a, b = m // 2, m - m // 2
        for c in range(x.size):
            cos[m, c] = cos[a, c] * cos[b, c] - sin[a, c] * sin[b, c]
            sin[m, c] = sin[a, c] * cos[b, c] + cos[a, c] * sin[b, c]


@kernel(forceinline=True)
def _sum(own: int, count: int, both: bool, transfer: Transfer, room: _Room) -> None:
    """Add up one set's columns; both: times the other turns too."""
    columns, sums, begin = room.columns, room.sums, 0
    size = transfer.order.size
    for kind in range(KINDS):
        total, other = sums[kind], sums[kind + 4 if kind >= 4 else kind]
        total[:count] = 0.0
        other[:count] = 0.0
        for q in range(begin, transfer.ends[kind]):
            column, m = columns[own * size + q], transfer.order[q]
            turn, across = (room.sin[m], room.cos[m]) if transfer.sine[q] else (room.cos[m], room.sin[m])
            for c in range(count):
                total[c] += turn[c] * column[c]
            if both and kind >= 4:
                for c in range(count):
                    other[c] += across[c] * column[c]
        begin = transfer.ends[kind]


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def _look_up(fx: F64, fy: F64, transfer: Transfer, out: F64, first: int, stop: int) -> None:
    """Write transfers at some of the places: (sets, places, 2)."""
    room = _room(transfer)
    for low in range(first, stop, TOGETHER):
        high = min(low + TOGETHER, stop)
        _columns(fx[low:high], fy[low:high], transfer, room)
        for s in range(transfer.sets):
            _sum(s, high - low, False, transfer, room)
            sums = room.sums
            for c in range(high - low):
                out[s, low + c, 0] = sums[0, c] + sums[1, c] + sums[2, c] + sums[3, c]
                out[s, low + c, 1] = sums[4, c] + sums[5, c] + sums[6, c] + sums[7, c]


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def _on_quarters(steps: tuple[float, float], alike: bool, transfer: Transfer, out: F64, first: int, stop: int) -> None:
    """Write transfers in some rows, and, where both ways are alike, in some columns: (sets, 2, j, 2, i)."""
    room, x, y = _room(transfer), np.empty(TOGETHER), np.empty(TOGETHER)
    for j in range(first, stop):
        inside = transfer.cut * transfer.cut - (j * steps[1]) ** 2
        if inside <= 0.0:
            continue
        end = min(out.shape[4], math.floor(math.sqrt(inside) / steps[0]) + 1)
        for low in range(j if alike else 0, end, TOGETHER):
            count = min(TOGETHER, end - low)
            for c in range(count):
                x[c], y[c] = (low + c) * steps[0], j * steps[1]
            _columns(x[:count], y[:count], transfer, room)
            for s in range(transfer.sets):
                _sum(s, count, alike, transfer, room)
                # a, b: halves of even orders even, odd;  p, q: likewise of odd orders, cosines and then sines.
                a, b, a_sin, b_sin = room.sums[0], room.sums[1], room.sums[2], room.sums[3]
                p, q, p_sin, q_sin = room.sums[4], room.sums[5], room.sums[6], room.sums[7]
                for side in range(2):
                    sign = 1.0 - 2.0 * side
                    real, imaginary = out[s, side, j, 0, low : low + count], out[s, side, j, 1, low : low + count]
                    for c in range(count):
                        real[c] = a[c] + b[c] + sign * (a_sin[c] + b_sin[c])
                        imaginary[c] = p[c] + q[c] + sign * (p_sin[c] + q_sin[c])
                if alike:
                    # cos m(90° − φ) is ± cos mφ or ± sin mφ.
                    p, q, p_sin, q_sin = room.sums[8], room.sums[9], room.sums[10], room.sums[11]
                    for side in range(2):
                        sign, whole = 1.0 - 2.0 * side, out[s, side]
                        for c in range(count):
                            whole[low + c, 0, j] = a[c] - b[c] - sign * (a_sin[c] - b_sin[c])
                            whole[low + c, 1, j] = p[c] - q[c] + sign * (p_sin[c] - q_sin[c])
