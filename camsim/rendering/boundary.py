"""The exact boundary engine: the light on a photosite as a sum over edges (docs/rendering.md has the formulas).

Every edge is a line minus its two ends. Seen from a photosite, the line is one look-up in the edge response of its
direction (or its far form), and an end is the half line beyond it: closed form when it is far, quadrature over the
tabulated field when it is near (edge.py). Far contributions vary slowly: a quadtree collects them on Chebyshev nodes
of the largest tile for which they are smooth, and crowds of edges come as cells (crowd.py) of the size of the tile or
larger. Only what is left is visited per photosite.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba as nb
import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.rendering.crowd import Cells, cell_at_points
from camsim.rendering.edge import Edges, Numbers, Tables, edge_at, line_at, moments_of, rings_at, rings_of_line_at
from camsim.rendering.far import across, far_line, weigh
from camsim.rendering.smooth import ENDS, LINE, WHOLE, far_and_quiet, far_at_points

CELL = 3  # what a tile's list may hold besides a WHOLE edge or a LINE


class Scratch(NamedTuple):
    """Where one thread writes what it needs for a moment."""

    node_x: F64  # a tile's nodes about its centre, and an edge's far form there (4, order²)
    node_y: F64
    node_g: F64
    site_x: F64  # a tile's photosites about its first one, and an edge's far form there (4, leaf²)
    site_y: F64
    site_g: F64
    site_sums: F64  # (channels, leaf²) what cells send there
    quiet: U8  # (leaf²,)
    opened: I64  # (cells,)


@nb.njit(cache=True)
def _scratch(leaf: int, order: int, channels: int, cells: int) -> Scratch:
    nodes, sites = order * order, leaf * leaf
    index = np.arange(sites)
    return Scratch(
        np.empty(nodes),
        np.empty(nodes),
        np.empty((4, nodes)),
        (index % leaf).astype(np.float64),
        (index // leaf).astype(np.float64),
        np.empty((4, sites)),
        np.empty((channels, sites)),
        np.empty(sites, np.uint8),
        np.empty(cells, np.int64),
    )


@nb.njit(cache=True, inline="always")
def _gap(dx: float, dy: float, half_x: float, half_y: float) -> float:
    """Distance of a point at (dx, dy) from a box around the origin."""
    gap_x, gap_y = max(abs(dx) - half_x, 0.0), max(abs(dy) - half_y, 0.0)
    return math.sqrt(gap_x * gap_x + gap_y * gap_y)


@nb.njit(cache=True)
def _smooth_part(e: int, state: int, x: float, y: float, half: float, edges: Edges, n: Numbers) -> int:
    """Return which part of an edge is quiet and smooth over a tile, −1 for none."""
    apart = n.separation * half
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    spread = half * (abs(tx) + abs(ty))
    line_gap = abs(h) - spread if s1 < spread and s2 > -spread else math.inf
    if state == LINE:
        return LINE if line_gap >= apart and line_gap >= n.quiet_line else -1
    x2, y2 = dx + edges.length[e] * tx, dy + edges.length[e] * ty
    gap = min(_gap(dx, dy, half, half), _gap(x2, y2, half, half))
    if gap < n.quiet_end or gap < apart:
        return -1
    if line_gap >= apart and line_gap >= (n.quiet_line if edges.response[e] >= 0 else n.quiet_end):
        return WHOLE
    return ENDS if edges.response[e] >= 0 and s1 <= -spread and s2 >= spread else -1


@nb.njit(cache=True)
def _collect(
    x: float,
    y: float,
    half: float,
    last: bool,
    count: int,
    source: I64,
    state: U8,
    keep: I64,
    keep_state: U8,
    sums: F64,
    scratch: Scratch,
    edges: Edges,
    cells: Cells,
    tables: Tables,
    n: Numbers,
) -> tuple[int, int]:
    """Add to ``sums`` every source that is smooth over the tile at (x, y); list the others, count all but LINEs.

    sums : (channels, order²) at the tile's nodes; ``last`` says that the tile will not be quartered
    """
    kept = 0
    lines = 0
    apart = n.separation * half
    px, py, g, opened = scratch.node_x, scratch.node_y, scratch.node_g, scratch.opened
    for i in range(n.nodes.size):
        for j in range(n.nodes.size):
            px[i * n.nodes.size + j] = half * n.nodes[j]
            py[i * n.nodes.size + j] = half * n.nodes[i]
    for item in range(count):
        first, end = source[item], source[item] + 1
        waiting = 0
        if state[item] == CELL:
            opened[0] = source[item]
            first, end, waiting = 0, 0, 1
        while waiting > 0 or end > first:
            for e in range(first, end):
                owed = WHOLE if state[item] == CELL else state[item]
                part = _smooth_part(e, owed, x, y, half, edges, n)
                if part >= 0:
                    far_at_points(e, part, x, y, px, py, edges, n, g)
                    for k in range(sums.shape[0]):
                        far = tables.far[edges.pair[e], k]
                        for i in range(px.size):
                            sums[k, i] += weigh((g[0, i], g[1, i], g[2, i], g[3, i]), far)
                if part < 0 or part == ENDS:
                    keep[kept] = e
                    keep_state[kept] = LINE if part == ENDS else owed
                    lines += keep_state[kept] == LINE
                    kept += 1
            first, end = 0, 0
            if waiting > 0:
                waiting -= 1
                c = opened[waiting]
                size = max(cells.half_x[c], cells.half_y[c])
                gap = _gap(cells.x[c] - x, cells.y[c] - y, half + cells.half_x[c], half + cells.half_y[c])
                if gap < n.quiet_end or gap < n.separation * size:
                    if last or size > half:
                        first, end = cells.first_edge[c], cells.first_edge[c + 1]
                        for child in range(cells.first_child[c], cells.first_child[c + 1]):
                            opened[waiting] = child
                            waiting += 1
                        continue
                elif gap >= apart:
                    cell_at_points(c, x, y, px, py, n.sigma2, n.m22, n.harmonic, cells, sums)
                    continue
                keep[kept] = c
                keep_state[kept] = CELL
                kept += 1
    return kept, kept - lines


@nb.njit(cache=True, error_model="numpy", fastmath={"contract"})
def _add_line(e: int, x0: float, y0: float, channel: U8, image: F64, edges: Edges, tables: Tables, n: Numbers) -> None:
    """Add an edge's line, half of it taken away, to a tile's photosites, the first of which is at (x0, y0)."""
    rows, cols = image.shape
    tx, ty = edges.tx[e], edges.ty[e]
    d, far = across(moments_of(e, edges, n)), tables.far[edges.pair[e]]
    for r in range(rows):
        h0 = (edges.x[e] - x0) * ty - (edges.y[e] - (y0 + r)) * tx
        # Columns before ``begin`` and from ``stop`` on are beyond the table: a loop without branches.
        begin, stop = 0, cols
        if abs(ty) > 1e-9:
            middle, half = h0 / ty, n.reach / abs(ty)
            begin = int(min(max(middle - half - 1.0, 0.0), float(cols)))
            stop = int(min(max(middle + half + 2.0, float(begin)), float(cols)))
        for low, high in ((0, begin), (stop, cols)):
            for c in range(low, high):
                image[r, c] += weigh(far_line(h0 - c * ty, d), far[channel[r, c]])
        for c in range(begin, stop):
            image[r, c] += line_at(h0 - c * ty, e, channel[r, c], edges, tables, n)
        if n.quiet_line > n.reach:
            for c in range(cols):
                image[r, c] += rings_of_line_at(h0 - c * ty, e, channel[r, c], edges, tables, n)


@nb.njit(cache=True)
def _finish(
    row: int,
    col: int,
    size: int,
    level: int,
    count: int,
    source: I64,
    state: U8,
    sums: F64,
    channel: U8,
    image: F64,
    scratch: Scratch,
    origin_x: float,
    origin_y: float,
    edges: Edges,
    cells: Cells,
    tables: Tables,
    n: Numbers,
) -> None:
    """Write the photosites of one tile: background, what was collected, and what its list still holds."""
    rows, cols = min(size, image.shape[0] - row), min(size, image.shape[1] - col)
    order = n.nodes.size
    line = np.empty((sums.shape[0], order))
    weights = n.to_photosites[level]
    for r in range(rows):
        for k in range(sums.shape[0]):
            for j in range(order):
                line[k, j] = 0.0
            for i in range(order):
                for j in range(order):
                    line[k, j] += weights[r, i] * sums[k, i * order + j]
        for c in range(cols):
            k = channel[row + r, col + c]
            value = tables.base[k]
            for j in range(order):
                value += weights[c, j] * line[k, j]
            image[row + r, col + c] = value
    x0, y0 = origin_x + col, origin_y + row
    px, py, g, quiet = scratch.site_x, scratch.site_y, scratch.site_g, scratch.quiet
    from_cells = False
    for m in range(count):
        e = source[m]
        if state[m] == LINE:
            part = slice(row, row + rows), slice(col, col + cols)
            _add_line(e, x0, y0, channel[part], image[part], edges, tables, n)
        elif state[m] == CELL:
            if not from_cells:
                scratch.site_sums[:] = 0.0
                from_cells = True
            cell_at_points(e, x0, y0, px, py, n.sigma2, n.m22, n.harmonic, cells, scratch.site_sums)
        else:
            far_and_quiet(e, x0, y0, px, py, edges, n, quiet)
            # Not the constant WHOLE: Numba would compile the function for it once more.
            far_at_points(e, np.int64(state[m]), x0, y0, px, py, edges, n, g)  # type: ignore[arg-type]
            for r in range(rows):
                for c in range(cols):
                    k = channel[row + r, col + c]
                    i = r * size + c
                    if quiet[i]:
                        far = tables.far[edges.pair[e], k]
                        image[row + r, col + c] += weigh((g[0, i], g[1, i], g[2, i], g[3, i]), far)
                    else:
                        image[row + r, col + c] += edge_at(x0 + c, y0 + r, e, k, edges, tables, n)
                        if n.quiet_end > n.near:
                            image[row + r, col + c] += rings_at(x0 + c, y0 + r, e, k, edges, tables, n)
    if from_cells:
        for r in range(rows):
            for c in range(cols):
                image[row + r, col + c] += scratch.site_sums[channel[row + r, col + c], r * size + c]


@nb.njit(cache=True, parallel=True)
def render_edges(
    origin_x: float, origin_y: float, channel: U8, edges: Edges, cells: Cells, tables: Tables, n: Numbers
) -> F64:
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
        # Level 0 of the stacks is "outside": all sources, nothing collected.
        source = np.empty((levels + 1, total), np.int64)
        state = np.empty((levels + 1, total), np.uint8)
        counts = np.zeros(levels + 1, np.int64)
        if cells.x.size:
            source[0, 0], state[0, 0], counts[0] = 0, CELL, 1
        else:
            source[0], state[0], counts[0] = np.arange(total), WHOLE, total
        sums = np.zeros((levels + 1, channels, order * order))
        scratch = _scratch(n.leaf, order, channels, cells.x.size)
        half_way = np.empty((order, order))
        child = np.zeros(levels + 1, np.int64)
        tile_row = np.zeros(levels + 1, np.int64)
        tile_col = np.zeros(levels + 1, np.int64)
        tile_row[1], tile_col[1] = (tile // across) * n.root, (tile % across) * n.root
        level = 1
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
                    size == n.leaf,
                    counts[level - 1],
                    source[level - 1],
                    state[level - 1],
                    source[level],
                    state[level],
                    sums[level],
                    scratch,
                    edges,
                    cells,
                    tables,
                    n,
                )
                if whole == 0 or size == n.leaf:
                    _finish(
                        row,
                        col,
                        size,
                        level - 1,
                        counts[level],
                        source[level],
                        state[level],
                        sums[level],
                        channel,
                        image,
                        scratch,
                        origin_x,
                        origin_y,
                        edges,
                        cells,
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
                                half_way[i, j] += w * sums[level, k, m * order + j]
                    for i in range(order):
                        for j in range(order):
                            value = 0.0
                            for m in range(order):
                                value += across_matrix[j, m] * half_way[i, m]
                            sums[level + 1, k, i * order + j] = value
                level += 1
                enter = True
    return image
