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
    if cos.size > 1:
        cos[1], sin[1] = (x / size, y / size) if size > 0.0 else (1.0, 0.0)
    for m in range(2, cos.size):
        # From halves, which are known: one after the other would wait for one another.
        a, b = m // 2, m - m // 2
        cos[m], sin[m] = cos[a] * cos[b] - sin[a] * sin[b], sin[a] * cos[b] + cos[a] * sin[b]


class Transfer(NamedTuple):
    """Transfers over |f|: values (rows, sets · columns) at multiples −2, −1, 0 … of ``1/per_unit``.

    order, sine : of each column, whose transfer is real where the order is even, else imaginary
    ends        : (4,) of real cosines, imaginary cosines, real sines, imaginary sines among the columns
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
        kind = 2 * sine + order % 2
        sorted_ = np.argsort(kind, kind="stable")
        flat = np.ascontiguousarray(np.moveaxis(values[:, sorted_], 1, 2)).reshape(len(values), -1)
        ends = np.searchsorted(kind[sorted_], np.arange(4), side="right")
        return cls(flat, per_unit, order[sorted_], sine[sorted_], ends, values.shape[2], cut)

    def at(self, fx: F64, fy: F64) -> C128:
        """Return the transfers (sets, places) at places (n,)."""
        out = np.zeros((self.sets, fx.size, 2))
        shared(fx.size, functools.partial(_look_up, fx, fy, self, out), least=AT_ONCE)
        values: C128 = out.view(complex)[..., 0]
        return values

    def on_lattice(self, fx: F64, fy: F64) -> C128:
        """Return the transfers (sets, fy, fx) on a lattice."""
        out = np.zeros((self.sets, fy.size, fx.size, 2))
        paired = bool((fy == -fy[::-1]).all())
        shared(fy.size, functools.partial(_on_lattice, fx, fy, paired, self, out), least=-(-AT_ONCE // fx.size))
        values: C128 = out.view(complex)[..., 0]
        return values


class _Room(NamedTuple):
    """What a look-up writes to.

    weight : of six points;  turns: cosines and sines, ``turn`` those of columns
    sums   : (sets, 4) of real cosines, imaginary cosines, real sines, imaginary sines
    """

    weight: F64
    turns: F64
    turn: F64
    columns: F64
    sums: F64


@kernel(forceinline=True)
def _room(transfer: Transfer) -> _Room:
    columns, sets = transfer.order.size, transfer.sets
    most = transfer.order.max() if columns else 0
    return _Room(np.empty(6), np.empty((2, most + 1)), np.empty(columns), np.empty(columns * sets), np.empty((sets, 4)))


@kernel(forceinline=True)
def _sum(x: float, y: float, transfer: Transfer, room: _Room) -> bool:
    """Write sums at a place; False where nothing passes."""
    f = math.sqrt(x * x + y * y)
    if f >= transfer.cut:
        return False
    u = f * transfer.per_unit
    cell = int(u)
    weight, columns, turn, ends = room.weight, room.columns, room.turn, transfer.ends
    six_points(u - cell, weight)
    a, b, c = transfer.values[cell], transfer.values[cell + 1], transfer.values[cell + 2]
    d, e, g = transfer.values[cell + 3], transfer.values[cell + 4], transfer.values[cell + 5]
    for q in range(columns.size):
        columns[q] = weight[0] * a[q] + weight[1] * b[q] + weight[2] * c[q]
        columns[q] += weight[3] * d[q] + weight[4] * e[q] + weight[5] * g[q]
    turns(x, y, room.turns[0], room.turns[1])
    for q in range(turn.size):
        turn[q] = room.turns[transfer.sine[q], transfer.order[q]]
    for s in range(transfer.sets):
        begin, own = 0, columns[s * turn.size : (s + 1) * turn.size]
        for kind in range(4):
            total = 0.0
            for q in range(begin, ends[kind]):
                total += turn[q] * own[q]
            room.sums[s, kind], begin = total, ends[kind]
    return True


@kernel(error_model="numpy", fastmath={"contract"})
def _look_up(fx: F64, fy: F64, transfer: Transfer, out: F64, first: int, stop: int) -> None:
    """Write transfers at some of the places: (sets, places, 2)."""
    room = _room(transfer)
    for place in range(first, stop):
        if _sum(fx[place], fy[place], transfer, room):
            for s in range(transfer.sets):
                sums = room.sums[s]
                out[s, place, 0], out[s, place, 1] = sums[0] + sums[2], sums[1] + sums[3]


@kernel(error_model="numpy", fastmath={"contract"})
def _on_lattice(fx: F64, fy: F64, paired: bool, transfer: Transfer, out: F64, first: int, stop: int) -> None:
    """Write transfers in some rows: (sets, fy, fx, 2); paired: the last row is the first one's mirror image."""
    room = _room(transfer)
    for row in range(first, stop):
        other = fy.size - 1 - row
        if paired and other < row:
            continue  # whoever has the other one writes both
        for c in range(fx.size):
            if _sum(fx[c], fy[row], transfer, room):
                for s in range(transfer.sets):
                    sums = room.sums[s]
                    out[s, row, c, 0], out[s, row, c, 1] = sums[0] + sums[2], sums[1] + sums[3]
                    if paired and other > row:
                        out[s, other, c, 0], out[s, other, c, 1] = sums[0] - sums[2], sums[1] - sums[3]
