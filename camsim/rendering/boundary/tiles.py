"""The exact boundary engine: the light on a photosite as a sum over edges (docs/mathematics.md has the formulas).

Every edge is a line minus its two ends. For a photosite, the line is one look-up in the edge response of its direction
(or its far form), and an end is the half line beyond it: a closed form if it is far, quadrature over the tabulated
field if it is near (edge.py). Far contributions vary slowly: a quadtree collects them on the Chebyshev nodes of the
largest tile over which they are smooth. Only the remaining edges are evaluated at each photosite.
"""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, U8
from camsim.core.kernels import kernel, shared
from camsim.rendering.boundary.collect import Scratch, Stack, World, collect, scratch_of, stack_of
from camsim.rendering.boundary.finish import finish
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables


@kernel()
def _hand_down(level: int, quarter: int, stack: Stack, n: Numbers, half_way: F64) -> None:
    """Interpolate a tile's sums to the nodes of one of its quarters, one level down."""
    order = n.nodes.size
    down_matrix, across_matrix = n.to_children[quarter // 2], n.to_children[quarter % 2]
    for k in range(stack.sums.shape[1]):
        half_way[:] = 0.0
        for i in range(order):
            for m in range(order):
                w = down_matrix[i, m]
                for j in range(order):
                    half_way[i, j] += w * stack.sums[level, k, m * order + j]
        for i in range(order):
            for j in range(order):
                value = 0.0
                for m in range(order):
                    value += across_matrix[j, m] * half_way[i, m]
                stack.sums[level + 1, k, i * order + j] = value


@kernel()
def _descend(
    row: int,
    col: int,
    origin_x: float,
    origin_y: float,
    channel: U8,
    image: F64,
    stack: Stack,
    scratch: Scratch,
    world: World,
) -> None:
    """Render one of the largest tiles: quarter it until only lines remain, or it is a leaf."""
    rows, cols = image.shape
    n = world.numbers
    stack.row[1], stack.col[1] = row, col
    stack.sums[1] = 0.0
    level = 1
    enter = True
    while level > 0:
        size = n.root >> (level - 1)
        if enter:
            half = 0.5 * size
            x, y = origin_x + stack.col[level] + half - 0.5, origin_y + stack.row[level] + half - 0.5
            whole = collect(level, x, y, stack, scratch, world)
            if whole == 0 or size == n.leaf:
                finish(level, origin_x, origin_y, channel, image, stack, scratch, world)
                level -= 1
                enter = False
                continue
            stack.quarter[level] = 0
        enter = False
        quarter = stack.quarter[level]
        if quarter == 4:
            level -= 1
            continue
        stack.quarter[level] += 1
        r = stack.row[level] + (quarter // 2) * (size // 2)
        c = stack.col[level] + (quarter % 2) * (size // 2)
        if r < rows and c < cols:
            stack.row[level + 1], stack.col[level + 1] = r, c
            _hand_down(level, quarter, stack, n, scratch.half_way)
            level += 1
            enter = True


@kernel()
def render_tiles(
    first: int,
    end: int,
    origin_x: float,
    origin_y: float,
    channel: U8,
    image: F64,
    stack: Stack,
    scratch: Scratch,
    world: World,
) -> None:
    """Render tiles first … end of the largest size, counted row by row."""
    n = world.numbers
    across = (channel.shape[1] + n.root - 1) // n.root
    for tile in range(first, end):
        row, col = (tile // across) * n.root, (tile % across) * n.root
        _descend(row, col, origin_x, origin_y, channel, image, stack, scratch, world)


def render_edges(origin_x: float, origin_y: float, channel: U8, edges: TabledEdges, tables: Tables, n: Numbers) -> F64:
    """Render every photosite in the channel assigned to it.

    origin   : x, y of the first photosite's centre, pitches
    channel  : (rows, cols) index of each photosite's channel
    returns  : (rows, cols), in the unit of the weights
    """
    rows, cols = channel.shape
    image, world = np.empty((rows, cols)), World(edges, tables, n)

    def work(first: int, end: int) -> None:
        render_tiles(first, end, origin_x, origin_y, channel, image, stack_of(world), scratch_of(world), world)

    shared(-(-rows // n.root) * -(-cols // n.root), work)
    return image
