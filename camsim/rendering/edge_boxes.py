"""A tree of bounding boxes of edges, to find those along a circle without testing all."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel

GROUP = 8  # successive edges, usually of one outline, that share a box
TURNS = 20  # bits per axis of the Morton order
APART = (0x0000FFFF0000FFFF, 0x00FF00FF00FF00FF, 0x0F0F0F0F0F0F0F0F, 0x3333333333333333, 0x5555555555555555)
"""Masks of a number's bits after its groups of 16, 8, 4, 2, 1 bits have been spread apart by the same amount."""


class EdgeBoxes(NamedTuple):
    """Edges in groups, and a binary tree of their bounding boxes: the children of box ``k`` are 2k and 2k + 1.

    start, along, length : (n, 2), (n, 2), (n,) first points, unit vectors and lengths of the edges
    group : (leaves,) the group of edges of each leaf, −1 for none
    boxes : (2·leaves, 4) low x, low y, high x, high y; the leaves are the second half
    """

    start: F64
    along: F64
    length: F64
    group: I64
    boxes: F64

    @classmethod
    def of(cls, start: F64, end: F64, along: F64, length: F64) -> EdgeBoxes:
        """Build the tree; there must be at least one edge."""
        first = np.arange(0, len(start), GROUP)
        low = np.minimum.reduceat(np.minimum(start, end), first)
        high = np.maximum.reduceat(np.maximum(start, end), first)
        order = np.argsort(_along_a_curve(0.5 * (low + high)), kind="stable")
        leaves = 1 << (len(first) - 1).bit_length()
        group, boxes = np.full(leaves, -1), np.full((2 * leaves, 4), np.inf)
        boxes[:, 2:] = -np.inf
        group[: len(first)] = order
        boxes[leaves : leaves + len(first)] = np.concatenate([low, high], axis=1)[order]
        while leaves > 1:
            leaves //= 2
            of_two = boxes[2 * leaves : 4 * leaves].reshape(leaves, 2, 4)
            boxes[leaves : 2 * leaves, :2] = np.minimum(of_two[:, 0, :2], of_two[:, 1, :2])
            boxes[leaves : 2 * leaves, 2:] = np.maximum(of_two[:, 0, 2:], of_two[:, 1, 2:])
        return cls(start, along, length, group, boxes)


def _along_a_curve(places: F64) -> I64:
    """Return the Morton codes (n,) of places: sorting by them mostly keeps neighbouring places together."""
    columns = np.ascontiguousarray(places.T)
    columns = columns - columns.min(axis=1, keepdims=True)
    size = max(float(columns.max()), np.finfo(float).tiny)
    numbers = (columns / size * ((1 << TURNS) - 1)).astype(np.int64)
    # Interleave with zeros: spread the halves apart, then the halves of these, and so on.
    for step, kept in zip((16, 8, 4, 2, 1), APART, strict=True):
        numbers = (numbers | numbers << step) & kept
    along: I64 = numbers[0] | numbers[1] << 1
    return along


@kernel(allocates=True)
def groups_about(tree: EdgeBoxes, x: float, y: float, near: float, far: float, found: I64) -> int:
    """Write the groups that may have part of an edge at a distance of near … far from a place; return how many.

    found : (leaves,) memory
    """
    leaves, count = len(tree.group), 0
    stack = np.empty(64, np.int64)
    stack[0], depth = 1, 1
    while depth > 0:
        depth -= 1
        k = stack[depth]
        x0, y0, x1, y1 = tree.boxes[k]
        out_x, out_y = max(x0 - x, x - x1, 0.0), max(y0 - y, y - y1, 0.0)
        if out_x * out_x + out_y * out_y > far * far:
            continue
        in_x, in_y = max(x1 - x, x - x0), max(y1 - y, y - y0)
        if near > 0.0 and in_x * in_x + in_y * in_y < near * near:
            continue
        if k >= leaves:
            found[count] = tree.group[k - leaves]
            count += 1
        else:
            stack[depth], stack[depth + 1] = 2 * k + 1, 2 * k
            depth += 2
    return count
