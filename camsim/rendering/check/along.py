"""One piece of an outline integrated, as a point sees it in some channels: a straight one, or a Bézier curve."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I32, I64
from camsim.kernels import kernel
from camsim.rendering.check.records import Bent, Outlines

PANEL_BLURS = 8.0  # the longest piece that one rule integrates: of 4 it takes three fifths of as many nodes
SHORT = ((8, 0.25), (4, 0.03))
"""Nodes, and of its distance half an arc for which they do: 8^{−16} of what it gives."""
CUTS = 10  # where a round piece may be cut, its ends among them


class Energy(NamedTuple):
    """The same for one pair, and the channels that are asked for."""

    cells: F64  # (channels, n, 6)
    per_step: float
    far: F64  # (channels, 4)
    asked: I64  # (k,)


class Memory(NamedTuple):
    """What one thread writes on its way: the pieces that are near enough, where a round one is cut, and of the nodes of
    a panel the cells of the table in which they lie, where in these, and what each is taken times; what one piece adds
    to every channel, and all of them."""

    pieces: I64  # (pieces,)
    cuts: F64  # (CUTS,)
    cells: I32  # (nodes,)
    within: F64  # (nodes,)
    times: F64  # (nodes,)
    piece: F64  # (k,)
    total: F64  # (k,)


class Rules(NamedTuple):
    """Gauss rules (2, q), nodes and weights: of a panel, and two of fewer nodes for what is short and far.

    longest, tiny : pitches, of a panel, and of one that ``few`` nodes follow as well
    """

    panel: F64
    few: F64
    fewest: F64
    longest: float
    tiny: float


class _Powers(NamedTuple):
    """∫ds/r^k along a line for k = 3, 5, 7."""

    third: float
    fifth: float
    seventh: float


@kernel(forceinline=True)
def _beyond(h: float, s: float) -> _Powers:
    """The same over the half line from s ≥ 0."""
    r = math.hypot(h, s)
    u = s / r
    third = 1.0 / (r * (r + s))
    square = third * third
    return _Powers(third, square * (2.0 + u) / 3.0, square * third * (8.0 + 9.0 * u + 3.0 * u * u) / 15.0)


@kernel()
def _add_far_line(h: float, s1: float, s2: float, energy: Energy, piece: F64) -> None:
    """Add the far form over s1 … s2: the angle and the first three odd powers of 1/r."""
    angle = math.atan2(h * (s2 - s1), h * h + s1 * s2)
    if s1 < 0.0 < s2:
        whole, a, b, times = _beyond(h, 0.0), _beyond(h, -s1), _beyond(h, s2), 2.0
    else:
        whole, a, times = _beyond(h, min(abs(s1), abs(s2))), _beyond(h, max(abs(s1), abs(s2))), 1.0
        b = _Powers(0.0, 0.0, 0.0)
    third = times * whole.third - a.third - b.third
    fifth = times * whole.fifth - a.fifth - b.fifth
    seventh = times * whole.seventh - a.seventh - b.seventh
    for c in range(energy.asked.size):
        far = energy.far[energy.asked[c]]
        piece[c] += far[0] * angle - h * (far[1] * third + far[2] * fifth + far[3] * seventh)


@kernel(forceinline=True)
def _quintic(c: F64, t: float) -> float:
    value: float = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    return value


@kernel(forceinline=True)
def add_value(r: float, times: float, inside: bool, energy: Energy, piece: F64) -> None:
    """Add a number times E/r² from the table, or of its smooth powers."""
    cells, per_step, powers, asked = energy
    if inside:
        u = r * per_step
        cell = min(int(u), cells.shape[1] - 1)
        for c in range(asked.size):
            piece[c] += times * _quintic(cells[asked[c], cell], u - cell)
        return
    inv = 1.0 / r
    inv2 = inv * inv
    for c in range(asked.size):
        far = powers[asked[c]]
        piece[c] += times * inv2 * (far[0] - inv * (far[1] + inv2 * (far[2] + inv2 * far[3])))


@kernel(forceinline=True)
def look_up(count: int, energy: Energy, memory: Memory) -> None:
    """Add Σ times·E/r² over a panel's nodes, whose distances lie in ``within``.

    Where they lie in the table is found for all together, as vectors; what is looked up and added up comes one by one.
    """
    own, within, times = memory.cells, memory.within, memory.times
    last = np.int32(energy.cells.shape[1] - 1)
    for q in range(count):
        u = within[q] * energy.per_step
        own[q] = min(np.int32(u), last)
        within[q] = u - own[q]
    for c in range(energy.asked.size):
        table, inside = energy.cells[energy.asked[c]], 0.0
        for q in range(count):
            inside += times[q] * _quintic(table[np.uintp(own[q])], within[q])
        memory.piece[c] += inside


@kernel()
def add_straight(
    x: float, y: float, o: Outlines, e: int, radius: float, energy: Energy, rules: Rules, memory: Memory
) -> None:
    """Add one straight piece: h is how far its line passes the point by, s runs along it."""
    piece, length = memory.piece, math.hypot(o.dx[e], o.dy[e])
    tx, ty = o.dx[e] / length, o.dy[e] / length
    dx, dy = o.x[e] - x, o.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + length
    cut = math.sqrt(max(radius * radius - h * h, 0.0))
    low, high = max(s1, -cut), min(s2, cut)
    if high <= low:
        _add_far_line(h, s1, s2, energy, piece)
        return
    if s1 < low:
        _add_far_line(h, s1, low, energy, piece)
    if s2 > high:
        _add_far_line(h, high, s2, energy, piece)
    panels = math.ceil((high - low) / rules.longest)
    half = 0.5 * (high - low) / panels
    g = rules.few if high - low < rules.tiny else rules.panel
    for p in range(panels):
        middle = low + half * (2 * p + 1)
        for q in range(g.shape[1]):
            s = middle + half * g[0, q]
            memory.within[q] = math.sqrt(h * h + s * s)
            memory.times[q] = h * half * g[1, q]
        look_up(g.shape[1], energy, memory)


@kernel()
def add_bezier(x: float, y: float, bent: Bent, k: int, half: float, radius: float, energy: Energy, piece: F64) -> None:
    """Add one Bézier curve: (P × P′)·E/r² over t, by as many nodes as it takes; half: how far it reaches about t = 0.

    All of a curve that is partly within the radius is integrated with the table, which reaches as much farther.
    """
    x0, y0, x1, y1, x2, y2, x3, y3, eight, four = bent.terms[k]
    x0, y0 = x0 - x, y0 - y
    at = math.hypot(x0, y0)
    inside = at - half < radius
    order = bent.order[k]
    if not inside:
        order = 4 if at > four else 8 if at > eight else order
    g = bent.rules[order]
    for q in range(order):
        t = g[0, q]
        rx, ry = x0 + t * (x1 + t * (x2 + t * x3)), y0 + t * (y1 + t * (y2 + t * y3))
        wx, wy = x1 + t * (2.0 * x2 + t * 3.0 * x3), y1 + t * (2.0 * y2 + t * 3.0 * y3)
        add_value(math.sqrt(rx * rx + ry * ry), g[1, q] * (rx * wy - ry * wx), inside, energy, piece)
