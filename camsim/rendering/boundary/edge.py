"""Contribution of one edge to one photosite: line and ends, near and far. Lengths are in pitches."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel
from camsim.rendering.boundary.far import across, far_edge, far_line, far_tail, mirrored, weigh
from camsim.rendering.boundary.potential import eight_points
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables, moments_of


@kernel(fastmath={"contract"})
def _flux(
    h: float,
    s_from: float,
    s_to: float,
    tx: float,
    ty: float,
    field: F64,
    n: Numbers,
) -> float:
    """Integrate −V·n along the edge from s_from to s_to, for a photosite at signed distance h."""
    panels = max(1, math.ceil((s_to - s_from) / n.piece))
    half = 0.5 * (s_to - s_from) / panels
    rule = min(int(2.0 * half / n.piece * n.gauss_count.size), n.gauss_count.size - 1)
    nx, ny = -ty, tx
    inv_step = 1.0 / n.field_step
    total = 0.0
    for p in range(panels):
        middle = s_from + (2 * p + 1) * half
        for q in range(n.gauss_count[rule]):
            s = middle + half * n.gauss_x[rule, q]
            for spot in range(len(n.apart)):
                vx = s * tx - h * nx + n.apart[spot, 0]
                vy = s * ty - h * ny + n.apart[spot, 1]
                ux, uy = abs(vx) * inv_step, abs(vy) * inv_step
                i, j = np.uintp(ux), np.uintp(uy)
                y0, y1, y2, y3, y4, y5, y6, y7 = eight_points(uy - j)
                # A stencil's corner is margin + 1 − order/2 = 1 beyond (i, j). One sum per column and component.
                i += np.uintp(1)
                j += np.uintp(1)
                a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = 0.0
                b0 = b1 = b2 = b3 = b4 = b5 = b6 = b7 = 0.0
                for w in eight_points(ux - np.uintp(ux)):
                    row = field[0, i, j : j + np.uintp(8)]
                    a0, a1, a2, a3 = a0 + w * row[0], a1 + w * row[1], a2 + w * row[2], a3 + w * row[3]
                    a4, a5, a6, a7 = a4 + w * row[4], a5 + w * row[5], a6 + w * row[6], a7 + w * row[7]
                    row = field[1, i, j : j + np.uintp(8)]
                    b0, b1, b2, b3 = b0 + w * row[0], b1 + w * row[1], b2 + w * row[2], b3 + w * row[3]
                    b4, b5, b6, b7 = b4 + w * row[4], b5 + w * row[5], b6 + w * row[6], b7 + w * row[7]
                    i += np.uintp(1)
                sum_x = (a0 * y0 + a1 * y1 + a2 * y2 + a3 * y3) + (a4 * y4 + a5 * y5 + a6 * y6 + a7 * y7)
                sum_y = (b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3) + (b4 * y4 + b5 * y5 + b6 * y6 + b7 * y7)
                if vx < 0.0:
                    sum_x = -sum_x
                if vy < 0.0:
                    sum_y = -sum_y
                total -= n.gauss_w[rule, q] * (sum_x * nx + sum_y * ny)
    return total * half / len(n.apart)


@kernel(forceinline=True)
def line_at(h: float, e: int, channel: int, edges: TabledEdges, tables: Tables, n: Numbers) -> float:
    """Return what the line through one edge contributes at signed distance h, minus the value half-way across it."""
    a = abs(h)
    if a >= n.reach:
        total: float = weigh(far_line(h, across(moments_of(e, edges, n))), tables.far[edges.pair[e], channel])
        return total
    u = a / n.response_step
    cell = int(u)
    t = u - cell
    c = tables.response[edges.response[e], edges.alike[e], channel, cell]
    value: float = edges.times[e] * (c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5])))))
    return value if h >= 0.0 else -value


@kernel()
def edge_at(x: float, y: float, e: int, channel: int, edges: TabledEdges, tables: Tables, n: Numbers) -> float:
    """Return what one edge contributes to one photosite, by the cheapest method that is accurate enough."""
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    cut = math.sqrt(max(n.near * n.near - h * h, 0.0))
    low, high = max(s1, -cut), min(s2, cut)
    far, moments = tables.far[edges.pair[e], channel], moments_of(e, edges, n)
    field, times = tables.field[edges.alike[e], channel], edges.times[e]
    sees_line = s1 < 0.0 < s2 and edges.response[e] >= 0 and abs(h) < n.reach
    total: float = 0.0
    if not sees_line or (s1 > -cut and s2 < cut and s2 - s1 < cut):
        if high <= low:
            return weigh(far_edge(h, s1, s2, moments), far)
        total = times * _flux(h, low, high, tx, ty, field, n)
        if s1 < low:
            total += weigh(far_edge(h, s1, low, moments), far)
        if s2 > high:
            total += weigh(far_edge(h, high, s2, moments), far)
        return total
    total = line_at(h, e, channel, edges, tables, n)
    for side in range(2):
        s = -s1 if side == 0 else s2
        if s < cut:
            if side == 0:
                total -= times * _flux(h, -cut, -s, tx, ty, field, n)
            else:
                total -= times * _flux(h, s, cut, tx, ty, field, n)
            s = cut
        if s < math.inf:
            total -= weigh(far_tail(h, s, mirrored(moments) if side == 0 else moments), far)
    return total
