"""The exact boundary engine: the light on a photosite as a sum over edges (RENDERING in docs/ has the formulas).

Every edge is a line minus its two ends. Seen from a photosite, the line is one look-up in the edge response of
its direction (or its far form), and an end is the half line beyond it: closed form when it is far, quadrature over
the tabulated field when it is near. Far contributions vary slowly, so a quadtree collects them on Chebyshev nodes
of the largest tile for which they are smooth, and only what is left is visited per photosite.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba as nb
import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.rendering.far import far_edge, far_line, far_tail

WHOLE, LINE = 0, 1  # what a tile still owes of an edge: all of it, or its infinite line alone


class Edges(NamedTuple):
    """Edges in pitches, with what each needs from the tables."""

    x: F64  # start
    y: F64
    tx: F64  # unit direction
    ty: F64
    length: F64
    m4_re: F64  # the footprint's fourth moment in the edge's frame
    m4_im: F64
    pair: I64  # which two spectra
    response: I64  # which edge response, −1 for none


class Tables(NamedTuple):
    """Everything that is tabulated, by pair of spectra and channel."""

    far: F64  # (pairs, channels, 4)
    field: F64  # (pairs, channels, 2, n, n)
    response: F64  # (directions, pairs, channels, cells, 6)
    base: F64  # (channels,) the background


class Numbers(NamedTuple):
    """The plan's settings as the kernels read them; lengths in pitches."""

    near: float  # an end within this distance is integrated
    reach: float  # an edge response is looked up to this distance
    field_step: float
    response_step: float
    panel: float
    gauss_x: F64
    gauss_w: F64
    sigma2: float  # footprint: second moment per axis, ⟨|ζ|⁴⟩
    m22: float
    separation: float  # a source is smooth over a tile when it is this many half-widths away
    nodes: F64  # (n,) Chebyshev nodes on −1 … 1
    to_children: F64  # (2, n, n)
    to_photosites: F64  # (levels, root, n), level 0 the root
    root: int
    leaf: int


@nb.njit(cache=True, inline="always")
def _respond(h: float, table: F64, far: F64, step: float, reach: float, sigma2: float, m22: float, m4_re: float) -> float:
    """Response across an infinite line, minus its half-way value."""
    a = abs(h)
    if a >= reach:
        g0, g1, g3, g5 = far_line(h, sigma2, m22, m4_re)
        return g0 * far[0] + g1 * far[1] + g3 * far[2] + g5 * far[3]
    u = a / step
    cell = int(u)
    t = u - cell
    c = table[cell]
    value = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    return value if h >= 0.0 else -value


@nb.njit(cache=True, inline="always")
def _weights(t: float) -> tuple[float, float, float, float, float, float, float, float]:
    """Lagrange weights of the eight nodes −3 … 4 at 0 ≤ t < 1; scalars, so that they stay in registers."""
    d0, d1, d2, d3 = t + 3.0, t + 2.0, t + 1.0, t
    d4, d5, d6, d7 = t - 1.0, t - 2.0, t - 3.0, t - 4.0
    p01, p23, p45, p67 = d0 * d1, d2 * d3, d4 * d5, d6 * d7
    p0123, p4567 = p01 * p23, p45 * p67
    a, b, c, d = p23 * p4567, p01 * p4567, p0123 * p67, p0123 * p45
    return (
        d1 * a * (-1.0 / 5040.0), d0 * a * (1.0 / 720.0), d3 * b * (-1.0 / 240.0), d2 * b * (1.0 / 144.0),
        d5 * c * (-1.0 / 144.0), d4 * c * (1.0 / 240.0), d7 * d * (-1.0 / 720.0), d6 * d * (1.0 / 5040.0),
    )


@nb.njit(cache=True, fastmath={"contract"})
def _flux(
    h: float, s_from: float, s_to: float, tx: float, ty: float, field: F64, step: float, panel: float, gauss_x: F64, gauss_w: F64
) -> float:
    """Integrate −V·n along the edge from s_from to s_to, seen from signed distance h."""
    panels = max(1, int(math.ceil((s_to - s_from) / panel)))
    half = 0.5 * (s_to - s_from) / panels
    nx, ny = -ty, tx
    inv_step = 1.0 / step
    total = 0.0
    for p in range(panels):
        middle = s_from + (2 * p + 1) * half
        for q in range(gauss_x.size):
            s = middle + half * gauss_x[q]
            vx = s * tx - h * nx
            vy = s * ty - h * ny
            ux, uy = abs(vx) * inv_step, abs(vy) * inv_step
            i, j = np.uintp(ux), np.uintp(uy)
            y0, y1, y2, y3, y4, y5, y6, y7 = _weights(uy - j)
            # A stencil's corner is margin + 1 − order/2 = 1 beyond (i, j). One running sum per column and component.
            i += np.uintp(1)
            j += np.uintp(1)
            a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = 0.0
            b0 = b1 = b2 = b3 = b4 = b5 = b6 = b7 = 0.0
            for w in _weights(ux - np.uintp(ux)):
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
            total -= gauss_w[q] * (sum_x * nx + sum_y * ny)
    return total * half


@nb.njit(cache=True)
def _edge_at(x: float, y: float, e: int, channel: int, edges: Edges, tables: Tables, n: Numbers) -> float:
    """Contribution of one edge to one photosite, by whichever of the ways is exact enough and cheap."""
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    pair = edges.pair[e]
    far = tables.far[pair, channel]
    m4_re, m4_im = edges.m4_re[e], edges.m4_im[e]
    r1, r2 = math.hypot(h, s1), math.hypot(h, s2)
    beside = s1 < 0.0 < s2
    sees_line = beside and edges.response[e] >= 0 and abs(h) < n.reach
    if not sees_line and min(r1, r2) >= n.near and (not beside or abs(h) >= n.near):
        g0, g1, g3, g5 = far_edge(h, s1, s2, n.sigma2, n.m22, m4_re, m4_im)
        return g0 * far[0] + g1 * far[1] + g3 * far[2] + g5 * far[3]
    field = tables.field[pair, channel]
    cut = math.sqrt(max(n.near * n.near - h * h, 0.0))
    low, high = max(s1, -cut), min(s2, cut)
    total = 0.0
    if not sees_line or (r1 < n.near and r2 < n.near and s2 - s1 < 2.0 * cut - (s2 - s1)):
        if high > low:
            total = _flux(h, low, high, tx, ty, field, n.field_step, n.panel, n.gauss_x, n.gauss_w)
            if s1 < low:
                g0, g1, g3, g5 = far_edge(h, s1, low, n.sigma2, n.m22, m4_re, m4_im)
                total += g0 * far[0] + g1 * far[1] + g3 * far[2] + g5 * far[3]
            if s2 > high:
                g0, g1, g3, g5 = far_edge(h, high, s2, n.sigma2, n.m22, m4_re, m4_im)
                total += g0 * far[0] + g1 * far[1] + g3 * far[2] + g5 * far[3]
        return total
    total = _respond(
        h, tables.response[edges.response[e], pair, channel], far, n.response_step, n.reach, n.sigma2, n.m22, m4_re
    )
    for side in range(2):
        s = -s1 if side == 0 else s2
        if s < cut:
            if side == 0:
                total -= _flux(h, -cut, -s, tx, ty, field, n.field_step, n.panel, n.gauss_x, n.gauss_w)
            else:
                total -= _flux(h, s, cut, tx, ty, field, n.field_step, n.panel, n.gauss_x, n.gauss_w)
            s = cut
        if s < math.inf:
            g0, g1, g3, g5 = far_tail(h, s, n.sigma2, n.m22, m4_re, -m4_im if side == 0 else m4_im)
            total -= g0 * far[0] + g1 * far[1] + g3 * far[2] + g5 * far[3]
    return total


@nb.njit(cache=True)
def _collect(
    x: float, y: float, half: float, count: int, source: I64, state: U8, keep: I64, keep_state: U8,
    cheb: F64, edges: Edges, tables: Tables, n: Numbers,
) -> tuple[int, int]:
    """Add to ``cheb`` every source that is smooth over the tile at (x, y); list the others, count the WHOLE ones."""
    kept = 0
    whole = 0
    apart = n.separation * half
    channels = tables.far.shape[1]
    order = n.nodes.size
    for c in range(count):
        e = source[c]
        tx, ty = edges.tx[e], edges.ty[e]
        dx, dy = edges.x[e] - x, edges.y[e] - y
        h = dx * ty - dy * tx
        s1 = dx * tx + dy * ty
        s2 = s1 + edges.length[e]
        spread = half * (abs(tx) + abs(ty))
        line_gap = abs(h) - spread if s1 < spread and s2 > -spread else math.inf
        mode = 0  # 1: whole edge, 2: minus both ends, 3: line
        if state[c] == WHOLE:
            x2, y2 = dx + edges.length[e] * tx, dy + edges.length[e] * ty
            gap1 = math.hypot(max(abs(dx) - half, 0.0), max(abs(dy) - half, 0.0))
            gap2 = math.hypot(max(abs(x2) - half, 0.0), max(abs(y2) - half, 0.0)) if s2 < math.inf else math.inf
            gap = min(gap1, gap2)
            if gap >= n.near and gap >= apart:
                if line_gap >= apart and line_gap >= (n.reach if edges.response[e] >= 0 else n.near):
                    mode = 1
                elif edges.response[e] >= 0 and s1 <= -spread and s2 >= spread:
                    mode = 2
        elif line_gap >= apart and line_gap >= n.reach:
            mode = 3
        if mode != 1 and mode != 3:
            keep[kept] = e
            keep_state[kept] = LINE if (mode == 2 or state[c] == LINE) else WHOLE
            if keep_state[kept] == WHOLE:
                whole += 1
            kept += 1
        if mode == 0:
            continue
        m4_re, m4_im = edges.m4_re[e], edges.m4_im[e]
        for i in range(order):
            py = half * n.nodes[i]
            for j in range(order):
                px = half * n.nodes[j]
                hh = h - px * ty + py * tx
                ss = s1 - px * tx - py * ty
                if mode == 1:
                    g0, g1, g3, g5 = far_edge(hh, ss, ss + edges.length[e], n.sigma2, n.m22, m4_re, m4_im)
                elif mode == 3:
                    g0, g1, g3, g5 = far_line(hh, n.sigma2, n.m22, m4_re)
                else:
                    a0, a1, a3, a5 = far_tail(hh, -ss, n.sigma2, n.m22, m4_re, -m4_im)
                    g0, g1, g3, g5 = -a0, -a1, -a3, -a5
                    if s2 < math.inf:
                        a0, a1, a3, a5 = far_tail(hh, ss + edges.length[e], n.sigma2, n.m22, m4_re, m4_im)
                        g0, g1, g3, g5 = g0 - a0, g1 - a1, g3 - a3, g5 - a5
                for k in range(channels):
                    far = tables.far[edges.pair[e], k]
                    cheb[k, i, j] += g0 * far[0] + g1 * far[1] + g3 * far[2] + g5 * far[3]
    return kept, whole


@nb.njit(cache=True)
def _finish(
    row: int, col: int, size: int, level: int, count: int, source: I64, state: U8, cheb: F64, has_far: bool,
    origin_x: float, origin_y: float, channel: U8, image: F64, edges: Edges, tables: Tables, n: Numbers,
) -> None:
    """Write the photosites of one tile: background, interpolated far part, lines, and whole edges."""
    rows, cols = image.shape
    channels = tables.far.shape[1]
    order = n.nodes.size
    line = np.empty((channels, order))
    weights = n.to_photosites[level]
    for r in range(row, min(row + size, rows)):
        y = origin_y + r
        if has_far:
            for k in range(channels):
                for j in range(order):
                    line[k, j] = 0.0
                for i in range(order):
                    w = weights[r - row, i]
                    for j in range(order):
                        line[k, j] += w * cheb[k, i, j]
        for c in range(col, min(col + size, cols)):
            k = channel[r, c]
            value = tables.base[k]
            if has_far:
                for j in range(order):
                    value += weights[c - col, j] * line[k, j]
            image[r, c] = value
        for m in range(count):
            e = source[m]
            tx, ty = edges.tx[e], edges.ty[e]
            if state[m] == LINE:
                h0 = (edges.x[e] - origin_x) * ty - (edges.y[e] - y) * tx
                m4_re = edges.m4_re[e]
                for c in range(col, min(col + size, cols)):
                    k = channel[r, c]
                    image[r, c] += _respond(
                        h0 - c * ty, tables.response[edges.response[e], edges.pair[e], k], tables.far[edges.pair[e], k],
                        n.response_step, n.reach, n.sigma2, n.m22, m4_re,
                    )
            else:
                for c in range(col, min(col + size, cols)):
                    image[r, c] += _edge_at(origin_x + c, y, e, channel[r, c], edges, tables, n)


@nb.njit(cache=True, parallel=True)
def render_edges(origin_x: float, origin_y: float, channel: U8, edges: Edges, tables: Tables, n: Numbers) -> F64:
    """Render every photosite in its own channel.

    origin   : x, y of the first photosite's centre, pitches
    channel  : (rows, cols) index of each photosite's channel
    returns  : (rows, cols), in the unit of the weights
    """
    rows, cols = channel.shape
    image = np.empty((rows, cols))
    down, across = (rows + n.root - 1) // n.root, (cols + n.root - 1) // n.root
    levels = n.to_photosites.shape[0]
    total = edges.x.size
    channels = tables.far.shape[1]
    order = n.nodes.size
    for tile in nb.prange(down * across):
        source = np.empty((levels + 1, total), np.int64)
        state = np.empty((levels + 1, total), np.uint8)
        source[0] = np.arange(total)
        state[0] = WHOLE
        counts = np.zeros(levels + 1, np.int64)
        counts[0] = total
        cheb = np.zeros((levels + 1, channels, order, order))
        half_way = np.empty((order, order))
        child = np.zeros(levels + 1, np.int64)
        tile_row = np.zeros(levels + 1, np.int64)
        tile_col = np.zeros(levels + 1, np.int64)
        tile_row[1], tile_col[1] = (tile // across) * n.root, (tile % across) * n.root
        level = 1  # level 0 of the stacks is "outside": all edges, no expansion
        enter = True
        while level > 0:
            size = n.root >> (level - 1)
            row, col = tile_row[level], tile_col[level]
            if enter:
                half = 0.5 * size
                counts[level], whole = _collect(
                    origin_x + col + half - 0.5, origin_y + row + half - 0.5, half, counts[level - 1],
                    source[level - 1], state[level - 1], source[level], state[level], cheb[level], edges, tables, n,
                )
                if whole == 0 or size <= n.leaf:
                    _finish(
                        row, col, size, level - 1, counts[level], source[level], state[level], cheb[level], True,
                        origin_x, origin_y, channel, image, edges, tables, n,
                    )
                    level -= 1
                    enter = False
                    continue
                child[level] = 0
            if child[level] == 4:
                level -= 1
                enter = False
                continue
            quarter = child[level]
            child[level] += 1
            r, c = row + (quarter // 2) * (size // 2), col + (quarter % 2) * (size // 2)
            enter = False
            if r < rows and c < cols:
                tile_row[level + 1], tile_col[level + 1] = r, c
                down_matrix, across_matrix = n.to_children[quarter // 2], n.to_children[quarter % 2]
                for k in range(channels):
                    half_way[:] = 0.0
                    for i in range(order):
                        for m in range(order):
                            w = down_matrix[i, m]
                            for j in range(order):
                                half_way[i, j] += w * cheb[level, k, m, j]
                    for i in range(order):
                        for j in range(order):
                            value = 0.0
                            for m in range(order):
                                value += across_matrix[j, m] * half_way[i, m]
                            cheb[level + 1, k, i, j] = value
                level += 1
                enter = True
    return image
