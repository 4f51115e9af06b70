"""Collection of a tile's far sources: those that are smooth over all of it, summed on its Chebyshev nodes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.kernels import kernel
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables
from camsim.rendering.boundary.smooth import BRIEF, ENDS, LINE, WHOLE, add_weighed, far_at_points


class World(NamedTuple):
    """The data that all tiles share: edges, tables and settings."""

    edges: TabledEdges
    tables: Tables
    numbers: Numbers


class Stack(NamedTuple):
    """The nested tiles of one thread, the largest at level 1; level 0 is "outside": all sources, nothing collected."""

    row: I64  # (levels + 1,) of each tile's first photosite
    col: I64
    quarter: I64  # the next to be entered
    listed: I64  # number of sources that are not smooth over the tile
    source: I64  # (levels + 1, sources) their indices
    state: U8  # WHOLE or LINE
    sums: F64  # (levels + 1, channels, order²) sum of the smooth sources, at the tile's nodes


class Scratch(NamedTuple):
    """Scratch memory of one thread."""

    node_x: F64  # a tile's nodes relative to its centre, and an edge's far form there (4, order²)
    node_y: F64
    node_g: F64
    half_way: F64  # (order, order) a tile's sums, interpolated along one axis
    line: F64  # (channels, order) a tile's sums, interpolated to one row of photosites
    line_sites: F64  # (channels, root) and to each photosite of the row
    site_x: F64  # a tile's photosites relative to its first one, and an edge's far form there (4, leaf²)
    site_y: F64
    site_g: F64
    site_sums: F64  # (channels, leaf²) sum of edges with negligible ringing there
    negligible: U8  # (leaf²,)


def stack_of(world: World) -> Stack:
    """Return a stack with all sources at level 0."""
    edges, order = world.edges.x.size, world.numbers.nodes.size
    levels, channels = world.numbers.to_photosites.shape[0], world.tables.far.shape[1]
    row, col, quarter, listed = np.zeros((4, levels + 1), np.int64)
    source, state = np.empty((levels + 1, edges), np.int64), np.empty((levels + 1, edges), np.uint8)
    source[0], state[0], listed[0] = np.arange(edges), WHOLE, edges
    return Stack(row, col, quarter, listed, source, state, np.zeros((levels + 1, channels, order * order)))


def scratch_of(world: World) -> Scratch:
    """Return new scratch memory for one thread."""
    leaf, order, channels = world.numbers.leaf, world.numbers.nodes.size, world.tables.far.shape[1]
    nodes, sites = order * order, leaf * leaf
    index = np.arange(sites)
    return Scratch(
        node_x=np.empty(nodes),
        node_y=np.empty(nodes),
        node_g=np.empty((4, nodes)),
        half_way=np.empty((order, order)),
        line=np.empty((channels, order)),
        line_sites=np.empty((channels, world.numbers.root)),
        site_x=(index % leaf).astype(np.float64),
        site_y=(index // leaf).astype(np.float64),
        site_g=np.empty((4, sites)),
        site_sums=np.empty((channels, sites)),
        negligible=np.empty(sites, np.uint8),
    )


@kernel(forceinline=True)
def gap_from(dx: float, dy: float, half_x: float, half_y: float) -> float:
    """Distance of a point at (dx, dy) from a box around the origin."""
    gap_x, gap_y = max(abs(dx) - half_x, 0.0), max(abs(dy) - half_y, 0.0)
    return math.sqrt(gap_x * gap_x + gap_y * gap_y)


@kernel()
def _smooth_part(e: int, state: int, x: float, y: float, half: float, edges: TabledEdges, n: Numbers) -> int:
    """Return the part of an edge that is smooth over a tile, with negligible ringing; −1 for none."""
    apart = n.separation * half
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    spread = half * (abs(tx) + abs(ty))
    line_gap = abs(h) - spread if s1 < spread and s2 > -spread else math.inf
    if state == LINE:
        return LINE if line_gap >= apart and line_gap >= n.reach else -1
    x2, y2 = dx + edges.length[e] * tx, dy + edges.length[e] * ty
    gap = min(gap_from(dx, dy, half, half), gap_from(x2, y2, half, half))
    if gap < n.near or gap < apart:
        return -1
    if line_gap >= apart and line_gap >= (n.reach if edges.response[e] >= 0 else n.near):
        return BRIEF if gap >= edges.brief[e] else WHOLE
    return ENDS if edges.response[e] >= 0 and s1 <= -spread and s2 >= spread else -1


@kernel()
def collect(level: int, x: float, y: float, stack: Stack, scratch: Scratch, world: World) -> int:
    """Sum the sources that are smooth over a level's tile about (x, y), list the others, and count those not LINE."""
    edges, tables, n = world
    size = n.root >> (level - 1)
    half = 0.5 * size
    count, source, state = stack.listed[level - 1], stack.source[level - 1], stack.state[level - 1]
    keep, keep_state, sums = stack.source[level], stack.state[level], stack.sums[level]
    retained = 0
    lines = 0
    px, py, g = scratch.node_x, scratch.node_y, scratch.node_g
    for i in range(n.nodes.size):
        for j in range(n.nodes.size):
            px[i * n.nodes.size + j] = half * n.nodes[j]
            py[i * n.nodes.size + j] = half * n.nodes[i]
    for item in range(count):
        e = source[item]
        part = _smooth_part(e, state[item], x, y, half, edges, n)
        if part >= 0:
            far_at_points(e, part, x, y, px, py, edges, n, g)
            add_weighed(g, tables.far[edges.pair[e]], sums)
        if part < 0 or part == ENDS:
            keep[retained] = e
            keep_state[retained] = LINE if part == ENDS else state[item]
            lines += keep_state[retained] == LINE
            retained += 1
    stack.listed[level] = retained
    return retained - lines
