"""Cells of a lattice and the outlines of its visible part: which cells are visible, and nodes over those cut."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.kernels import kernel
from camsim.numerics.quadrature import gauss_rules

NEXT_TO = 1e-9  # of a cell: an outline this near to a side may be on it
ASKED_AT = 0.3137  # coordinate in a cell at which visibility is tested: unlike its centre, no side of a field is there
FLAT = 1e-13  # of a cell: shorter bands and sections of a line carry no light
MORE = 3  # additional nodes on a short section


@kernel()
def cell_states(start: F64, end: F64, flips: U8, is_cut: np.ndarray) -> None:
    """Count changes of visibility (rows, cols + 1) at columns, modulo 256; mark the cells that segments (n, 2) cut."""
    rows, cols = is_cut.shape
    for s in range(len(start)):
        x0, y0, x1, y1 = start[s, 0], start[s, 1], end[s, 0], end[s, 1]
        low, high = min(y0, y1), max(y0, y1)
        is_flat = high - low <= NEXT_TO
        slope = 0.0 if is_flat else (x1 - x0) / (y1 - y0)
        for row in range(max(0, math.ceil(max(low, 0.0) - ASKED_AT)), min(rows - 1.0, math.floor(high)) + 1):
            y = row + ASKED_AT
            if (y0 <= y) != (y1 <= y):
                x = x0 + (y - y0) * slope
                flips[row, int(min(max(math.ceil(x - ASKED_AT), 0.0), cols + 0.0))] += 1
        first, last = math.floor(max(low, -1.0) + NEXT_TO), math.floor(min(high, rows + 1.0) - NEXT_TO)
        for row in range(max(first, 0), min(last, rows - 1) + 1):
            if is_flat:
                a, b = x0, x1
            else:
                a, b = x0 + (max(low, row + 0.0) - y0) * slope, x0 + (min(high, row + 1.0) - y0) * slope
            a, b = max(min(a, b), -1.0) + NEXT_TO, min(max(a, b), cols + 1.0) - NEXT_TO
            for col in range(max(math.floor(a), 0), min(math.floor(b), cols - 1) + 1):
                is_cut[row, col] = True


def cut_nodes(start: F64, end: F64, cells: I64, order: int) -> tuple[I64, F64]:
    """Return where each cell's nodes begin (n + 1,), and nodes and weights, together (m, 3), over its visible part.

    cells : (n, 2) rows and columns; nodes are relative to a cell's corner;  order: nodes of a rule along a side
    """
    most = order + MORE
    nodes, weights, _ = gauss_rules(tuple(range(1, most + 1)))
    begins, room = np.zeros(len(cells) + 1, np.int64), most * most * len(cells)
    while True:
        out = np.empty((room, 3))
        _lay(start, end, cells, order, nodes, weights, begins, out)
        if (room := int(begins[-1])) <= len(out):
            return begins, out[:room]


@kernel()
def _lay(start: F64, end: F64, cells: I64, order: int, nodes: F64, weights: F64, begins: I64, out: F64) -> None:
    """Write the nodes of all cells up to the array's size, and where they begin."""
    for k in range(len(cells)):
        row, col = float(cells[k, 0]), float(cells[k, 1])
        begins[k + 1] = begins[k] + _cut_nodes(start, end, col, row, order, nodes, weights, out[begins[k] :])


@kernel(forceinline=True)
def _line(s: int, y: float, start: F64, end: F64, col: float, row: float) -> float:
    """Return the x coordinate of a segment's line at height y in a cell; s of −1 and −2 are the cell's sides."""
    if s < 0:
        return -1.0 - s
    x0, y0, x1, y1 = start[s, 0] - col, start[s, 1] - row, end[s, 0] - col, end[s, 1] - row
    x: float = min(max(x0 + (y - y0) / (y1 - y0) * (x1 - x0), 0.0), 1.0)
    return x


@kernel(allocates=True)
def _cut_nodes(start: F64, end: F64, col: float, row: float, order: int, nodes: F64, weights: F64, out: F64) -> int:
    """Write nodes up to the array's size; return the number of all nodes.

    Between the heights where an outline begins, ends or meets a side, the crossings have a fixed order; the sections
    between them are alternately visible and hidden.
    """
    near, count = np.empty(len(start), np.int64), 0
    heights, bands = np.empty(4 * len(start) + 2), 2
    heights[0], heights[1] = 0.0, 1.0
    for s in range(len(start)):
        x0, y0, x1, y1 = start[s, 0] - col, start[s, 1] - row, end[s, 0] - col, end[s, 1] - row
        if max(y0, y1) <= 0.0 or min(y0, y1) >= 1.0 or min(x0, x1) >= 1.0:
            continue
        near[count] = s
        count += 1
        if max(x0, x1) <= 0.0:
            continue  # to the left: it only decides whether the left side is visible
        for y in (y0, y1):
            if 0.0 < y < 1.0:
                heights[bands] = y
                bands += 1
        for side in (0.0, 1.0):
            if (x0 < side) != (x1 < side):
                y = y0 + (side - x0) / (x1 - x0) * (y1 - y0)
                if 0.0 < y < 1.0:
                    heights[bands] = y
                    bands += 1
    sorted_heights = np.sort(heights[:bands])
    found, place = np.empty(count + 2, np.int64), np.empty(count + 2)
    written = 0
    for band in range(bands - 1):
        y0, y1 = sorted_heights[band], sorted_heights[band + 1]
        if y1 - y0 <= FLAT:
            continue
        middle, inside, crossings = 0.5 * (y0 + y1), False, 0
        for k in range(count):
            s = near[k]
            if (start[s, 1] - row <= middle) == (end[s, 1] - row <= middle):
                continue
            xa, ya = start[s, 0] - col, start[s, 1] - row
            x = xa + (middle - ya) / (end[s, 1] - row - ya) * (end[s, 0] - col - xa)
            if x <= 0.0:
                inside = not inside
            elif x < 1.0:
                k_place = crossings
                while k_place > 0 and place[k_place - 1] > x:
                    place[k_place], found[k_place] = place[k_place - 1], found[k_place - 1]
                    k_place -= 1
                place[k_place], found[k_place] = x, s
                crossings += 1
        left = -1
        for k in range(crossings + 1):
            right = found[k] if k < crossings else -2
            if inside:
                l0, l1 = _line(left, y0, start, end, col, row), _line(left, y1, start, end, col, row)
                r0, r1 = _line(right, y0, start, end, col, row), _line(right, y1, start, end, col, row)
                wide = max(r0 - l0, r1 - l1)
                if wide > FLAT:
                    slide = max(abs(l1 - l0), abs(r1 - r0))
                    rows, cols = _count(order, math.hypot(y1 - y0, slide)), _count(order, wide)
                    for i in range(rows):
                        y = 0.5 * (y0 + y1) + 0.5 * (y1 - y0) * nodes[rows - 1, i]
                        share = (y - y0) / (y1 - y0)
                        low, high = l0 + share * (l1 - l0), r0 + share * (r1 - r0)
                        size = 0.25 * (y1 - y0) * weights[rows - 1, i] * (high - low)
                        for j in range(cols):
                            if written < len(out):
                                out[written, 0] = 0.5 * (low + high) + 0.5 * (high - low) * nodes[cols - 1, j]
                                out[written, 1] = y
                                out[written, 2] = size * weights[cols - 1, j]
                            written += 1
            inside = not inside
            left = right
    return written


@kernel(forceinline=True)
def _count(order: int, length: float) -> int:
    """Return how many nodes resolve a section of a cell as well as ``order`` nodes resolve its side."""
    return min(order + MORE, math.ceil(order * min(length, 1.0)) + MORE)
