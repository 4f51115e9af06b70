"""The exact boundary engine: the light on a photosite as a sum over edges (docs/rendering.md has the formulas).

Every edge is a line minus its two ends. Seen from a photosite, the line is one look-up in the edge response of its
direction (or its far form), and an end is the half line beyond it: closed form when it is far, quadrature over the
tabulated field when it is near (edge.py). Far contributions vary slowly, so a quadtree collects them on Chebyshev
nodes of the largest tile for which they are smooth, and only what is left is visited per photosite.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.rendering.edge import Edges, Numbers, Tables, edge_at, line_at, moments_of
from camsim.rendering.far import far_edge, far_line, far_tail, mirrored, weigh

WHOLE, LINE = 0, 1  # what a tile still owes of an edge: all of it, or its infinite line alone


@nb.njit(cache=True)
def _collect(
    x: float,
    y: float,
    half: float,
    count: int,
    source: I64,
    state: U8,
    keep: I64,
    keep_state: U8,
    cheb: F64,
    edges: Edges,
    tables: Tables,
    n: Numbers,
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
            if gap >= n.quiet_end and gap >= apart:
                if line_gap >= apart and line_gap >= (n.quiet_line if edges.response[e] >= 0 else n.quiet_end):
                    mode = 1
                elif edges.response[e] >= 0 and s1 <= -spread and s2 >= spread:
                    mode = 2
        elif line_gap >= apart and line_gap >= n.quiet_line:
            mode = 3
        if mode != 1 and mode != 3:
            keep[kept] = e
            keep_state[kept] = LINE if (mode == 2 or state[c] == LINE) else WHOLE
            if keep_state[kept] == WHOLE:
                whole += 1
            kept += 1
        if mode == 0:
            continue
        moments = moments_of(e, edges, n)
        for i in range(order):
            py = half * n.nodes[i]
            for j in range(order):
                px = half * n.nodes[j]
                hh = h - px * ty + py * tx
                ss = s1 - px * tx - py * ty
                if mode == 1:
                    g0, g1, g3, g5 = far_edge(hh, ss, ss + edges.length[e], moments)
                elif mode == 3:
                    g0, g1, g3, g5 = far_line(hh, moments)
                else:
                    a0, a1, a3, a5 = far_tail(hh, -ss, mirrored(moments))
                    g0, g1, g3, g5 = -a0, -a1, -a3, -a5
                    if s2 < math.inf:
                        a0, a1, a3, a5 = far_tail(hh, ss + edges.length[e], moments)
                        g0, g1, g3, g5 = g0 - a0, g1 - a1, g3 - a3, g5 - a5
                for k in range(channels):
                    far = tables.far[edges.pair[e], k]
                    cheb[k, i, j] += weigh((g0, g1, g3, g5), far)
    return kept, whole


@nb.njit(cache=True)
def _finish(
    row: int,
    col: int,
    size: int,
    level: int,
    count: int,
    source: I64,
    state: U8,
    cheb: F64,
    has_far: bool,
    origin_x: float,
    origin_y: float,
    channel: U8,
    image: F64,
    edges: Edges,
    tables: Tables,
    n: Numbers,
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
                for c in range(col, min(col + size, cols)):
                    image[r, c] += line_at(h0 - c * ty, e, channel[r, c], edges, tables, n)
            else:
                for c in range(col, min(col + size, cols)):
                    image[r, c] += edge_at(origin_x + c, y, e, channel[r, c], edges, tables, n)


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
    tiles = down * across
    for turn in nb.prange(tiles):
        # Threads take halves of the turns; crossing them spreads a crowded corner of the frame over all threads.
        tile = 2 * turn if 2 * turn < tiles else 2 * (turn - (tiles + 1) // 2) + 1
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
                    origin_x + col + half - 0.5,
                    origin_y + row + half - 0.5,
                    half,
                    counts[level - 1],
                    source[level - 1],
                    state[level - 1],
                    source[level],
                    state[level],
                    cheb[level],
                    edges,
                    tables,
                    n,
                )
                if whole == 0 or size <= n.smallest or (size <= n.leaf and whole <= n.crowded):
                    _finish(
                        row,
                        col,
                        size,
                        level - 1,
                        counts[level],
                        source[level],
                        state[level],
                        cheb[level],
                        True,
                        origin_x,
                        origin_y,
                        channel,
                        image,
                        edges,
                        tables,
                        n,
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
