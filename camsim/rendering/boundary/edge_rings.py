"""Ringing that the far forms of an edge neglect (separate, since few plans need it and edges are the inner loop)."""

from __future__ import annotations

import math

from camsim.core.arrays import F64
from camsim.core.kernels import kernel
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables
from camsim.rendering.boundary.ring_table import tabled_part
from camsim.rendering.boundary.rings import is_short, ring_part, ring_tail


@kernel()
def _rings_of_end(h: float, s: float, tx: float, ty: float, weights: F64, tables: Tables, n: Numbers) -> float:
    """Ringing of the half line from s ≥ 0 on in direction (tx, ty)."""
    if math.hypot(h, s) >= n.negligible_end:
        return 0.0
    return ring_tail(h, s, tx, ty, weights, tables.oscillations, tables.rings, n.turns, n.near)


@kernel()
def _rings_of_line(h: float, tx: float, ty: float, weights: F64, tables: Tables, n: Numbers) -> float:
    """Ringing of an infinite line; none within ``reach``, where its response includes it."""
    if not n.reach <= abs(h) < n.negligible_line:
        return 0.0
    ahead = ring_tail(h, 0.0, tx, ty, weights, tables.oscillations, tables.rings, n.turns, n.near)
    return ahead - ring_tail(-h, 0.0, -tx, -ty, weights, tables.oscillations, tables.rings, n.turns, n.near)


@kernel()
def _rings_of_part(
    h: float, s1: float, s2: float, e: int, channel: int, edges: TabledEdges, tables: Tables, n: Numbers
) -> float:
    """Ringing of the part s1 < s2 of an edge, every point of it beyond ``near``.

    A half line in the opposite direction has the photosite on its other side and runs against the edge: the two signs
    cancel.
    """
    tx, ty, weights = edges.tx[e], edges.ty[e], tables.ring_weights[edges.pair[e], channel]
    farthest, short = max(math.hypot(h, s1), math.hypot(h, s2)), tables.short_rings
    beside = s1 * s2 >= 0.0 or n.reach <= abs(h) < n.negligible_line
    if farthest < n.negligible_end and beside and is_short(s2 - s1, short.shortest, n.ring_phases):
        way = complex(tx, ty)
        if farthest < short.until:
            values = short.values[edges.alike[e], channel]
            looked_up: float = edges.times[e] * tabled_part(h, (s1, s2), way, values, short, n.turns, n.ring_phases)
            return looked_up
        return ring_part(h, (s1, s2), way, weights, tables.oscillations, tables.rings, n.turns, n.near, n.ring_phases)
    if s1 >= 0.0:
        return _rings_of_end(h, s1, tx, ty, weights, tables, n) - _rings_of_end(h, s2, tx, ty, weights, tables, n)
    if s2 <= 0.0:
        return _rings_of_end(-h, -s1, -tx, -ty, weights, tables, n) - _rings_of_end(
            -h, -s2, -tx, -ty, weights, tables, n
        )
    return (
        _rings_of_line(h, tx, ty, weights, tables, n)
        + _rings_of_end(-h, -s1, -tx, -ty, weights, tables, n)
        - _rings_of_end(h, s2, tx, ty, weights, tables, n)
    )


@kernel()
def rings_of_line_at(h: float, e: int, channel: int, edges: TabledEdges, tables: Tables, n: Numbers) -> float:
    """Ringing that the far form in ``line_at`` neglects."""
    weights = tables.ring_weights[edges.pair[e], channel]
    return _rings_of_line(h, edges.tx[e], edges.ty[e], weights, tables, n)


@kernel()
def rings_at(x: float, y: float, e: int, channel: int, edges: TabledEdges, tables: Tables, n: Numbers) -> float:
    """Ringing that the far forms in ``edge_at`` neglect."""
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    cut = math.sqrt(max(n.near * n.near - h * h, 0.0))
    if -cut < s1 and s2 < cut and s2 - s1 < cut:
        return 0.0
    if s1 < 0.0 < s2 and edges.response[e] >= 0 and abs(h) < n.reach:
        weights = tables.ring_weights[edges.pair[e], channel]
        behind = _rings_of_end(-h, max(-s1, cut), -tx, -ty, weights, tables, n)
        return behind - _rings_of_end(h, max(s2, cut), tx, ty, weights, tables, n)
    if s1 >= cut or s2 <= -cut or cut == 0.0:
        return _rings_of_part(h, s1, s2, e, channel, edges, tables, n)
    total = 0.0
    if s1 < -cut:
        total += _rings_of_part(h, s1, -cut, e, channel, edges, tables, n)
    if s2 > cut:
        total += _rings_of_part(h, cut, s2, e, channel, edges, tables, n)
    return total
