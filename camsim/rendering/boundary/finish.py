"""A tile's photosites: the collected sums, interpolated, plus the remaining sources of its list one by one."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, U8
from camsim.core.kernels import kernel
from camsim.rendering.boundary.collect import Scratch, Stack, World, gap_from
from camsim.rendering.boundary.edge import edge_at, line_at
from camsim.rendering.boundary.far import across, far_line, weigh
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables, moments_of
from camsim.rendering.boundary.smooth import BRIEF, LINE, add_weighed, far_and_negligible, far_at_points


@kernel(error_model="numpy", fastmath={"contract"})
def _add_line(
    e: int, x0: float, y0: float, channel: U8, image: F64, edges: TabledEdges, tables: Tables, n: Numbers
) -> None:
    """Add an edge's line, minus its half-way value, to a tile's photosites, the first of which is at (x0, y0)."""
    rows, cols = image.shape
    tx, ty = edges.tx[e], edges.ty[e]
    d, far = across(moments_of(e, edges, n)), tables.far[edges.pair[e]]
    for r in range(rows):
        h0 = (edges.x[e] - x0) * ty - (edges.y[e] - (y0 + r)) * tx
        # Columns before ``begin`` and from ``stop`` on are beyond the table; separate loops have no branches.
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


@kernel(forceinline=True)
def _distance(e: int, x: float, y: float, half: float, edges: TabledEdges) -> float:
    """Return a lower bound of an edge's distance from a square about (x, y), by its middle."""
    reach = 0.5 * edges.length[e]
    x, y = edges.x[e] + reach * edges.tx[e] - x, edges.y[e] + reach * edges.ty[e] - y
    gap: float = gap_from(x, y, half, half) - reach
    return gap


@kernel()
def finish(
    level: int,
    origin_x: float,
    origin_y: float,
    channel: U8,
    image: F64,
    stack: Stack,
    scratch: Scratch,
    world: World,
) -> None:
    """Write the photosites of a level's tile: background, collected sums, and the remaining sources of its list."""
    edges, tables, n = world
    row, col, size = stack.row[level], stack.col[level], n.root >> (level - 1)
    count, source, state, sums = stack.listed[level], stack.source[level], stack.state[level], stack.sums[level]
    rows, cols = min(size, image.shape[0] - row), min(size, image.shape[1] - col)
    order = n.nodes.size
    line, site, weights = scratch.line, scratch.line_sites, n.to_photosites[level - 1]
    for r in range(rows):
        for k in range(sums.shape[0]):
            for j in range(order):
                line[k, j] = 0.0
            for i in range(order):
                for j in range(order):
                    line[k, j] += weights[i, r] * sums[k, i * order + j]
            # All channels at every photosite: vectorised, this is faster than one channel at each.
            for c in range(cols):
                site[k, c] = tables.base[k]
            for j in range(order):
                for c in range(cols):
                    site[k, c] += weights[j, c] * line[k, j]
        for c in range(cols):
            image[row + r, col + c] = site[channel[row + r, col + c], c]
    x0, y0 = origin_x + col, origin_y + row
    px, py, g, negligible = scratch.site_x, scratch.site_y, scratch.site_g, scratch.negligible
    from_all, half = scratch.site_sums, 0.5 * (n.leaf - 1)
    from_all[:] = 0.0
    for m in range(count):
        e = source[m]
        if state[m] == LINE:
            part = slice(row, row + rows), slice(col, col + cols)
            _add_line(e, x0, y0, channel[part], image[part], edges, tables, n)
        else:
            # Not the constant WHOLE, for which Numba would compile the function again.
            gap = _distance(e, x0 + half, y0 + half, half, edges)
            all_of_it = np.int64(BRIEF) if gap >= edges.brief[e] else np.int64(state[m])
            far_at_points(e, all_of_it, x0, y0, px, py, edges, n, g)  # type: ignore[arg-type]
            if gap >= (n.reach if edges.response[e] >= 0 else n.near):  # the ringing is negligible
                add_weighed(g, tables.far[edges.pair[e]], from_all)
                continue
            far_and_negligible(e, x0, y0, px, py, edges, n, negligible)
            for r in range(rows):
                for c in range(cols):
                    k = channel[row + r, col + c]
                    i = r * size + c
                    if negligible[i]:
                        far = tables.far[edges.pair[e], k]
                        image[row + r, col + c] += weigh((g[0, i], g[1, i], g[2, i], g[3, i]), far)
                    else:
                        image[row + r, col + c] += edge_at(x0 + c, y0 + r, e, k, edges, tables, n)
    if size == n.leaf:
        for r in range(rows):
            for c in range(cols):
                image[row + r, col + c] += from_all[channel[row + r, col + c], r * size + c]
