"""Which boxes touch: squares of doubling size, each box in one of the smallest that it fits into."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel

MOST_LEVELS = 40
TINY = float(np.finfo(float).tiny)
ROW = 1 << 31  # squares in a row: a square's number is y·ROW + x


class Squares(NamedTuple):
    """Boxes by the square that their low corner lies in.

    boxes      : (n, 4) low x, low y, high x, high y;  level: (n,) a square's side is size·2^level
    low, size  : corner of all, and the side of the smallest square
    first      : (levels + 1,) where each level begins in ``key`` and ``box``
    key, box   : (n,) number of the square, and the box, level by level in order
    """

    boxes: F64
    level: I64
    low: F64
    size: float
    first: I64
    key: I64
    box: I64

    @classmethod
    def of(cls, boxes: F64) -> Squares:
        """Sort boxes."""
        low = boxes[:, :2].min(axis=0)
        sides = (boxes[:, 2:] - boxes[:, :2]).max(axis=1)
        whole = float((boxes[:, 2:].max(axis=0) - low).max())
        typical = float(np.partition(sides, len(sides) // 2)[len(sides) // 2])
        size = max(typical, whole * 2.0 ** (1 - MOST_LEVELS), TINY)
        level = np.minimum(np.ceil(np.log2(np.maximum(sides, size) / size)), MOST_LEVELS).astype(np.int64)
        x, y = np.floor((boxes[:, :2] - low) / (size * 2.0**level)[:, None]).astype(np.int64).T
        key = y * ROW + x
        order = np.lexsort((key, level))
        first = np.searchsorted(level[order], np.arange(MOST_LEVELS + 2))
        return cls(boxes, level, low, size, first, key[order], order)


@kernel()
def _first_of(key: I64, begin: int, end: int, least: int) -> int:
    """Return where, from begin to end, sorted keys are ``least`` or more for the first time."""
    while begin < end:
        middle = (begin + end) // 2
        if key[middle] < least:
            begin = middle + 1
        else:
            end = middle
    return begin


@kernel()
def touching(squares: Squares, e: int, found: I64) -> int:
    """Write the boxes that touch box ``e`` and are no smaller, each pair once; return how many."""
    count = 0
    x0, y0, x1, y1 = squares.boxes[e]
    for level in range(squares.level[e], len(squares.first) - 1):
        begin, end = squares.first[level], squares.first[level + 1]
        if begin == end:
            continue
        side = squares.size * 2.0**level
        low_x, high_x = math.floor((x0 - squares.low[0]) / side) - 1, math.floor((x1 - squares.low[0]) / side)
        low_y, high_y = math.floor((y0 - squares.low[1]) / side) - 1, math.floor((y1 - squares.low[1]) / side)
        for row in range(max(low_y, 0), high_y + 1):
            k = _first_of(squares.key, begin, end, row * ROW + max(low_x, 0))
            while k < end and squares.key[k] <= row * ROW + high_x:
                f = squares.box[k]
                k += 1
                if level == squares.level[e] and f <= e:
                    continue
                b = squares.boxes[f]
                if b[0] > x1 or b[2] < x0 or b[1] > y1 or b[3] < y0:
                    continue
                found[count] = f
                count += 1
    return count


def pairs(squares: Squares) -> tuple[I64, I64]:
    """Return all pairs of boxes that touch, each once."""
    boxes = len(squares.level)
    found, room = np.empty(boxes, np.int64), 8 * boxes
    while True:
        one, two = np.empty((2, room), np.int64)
        total = _pairs(squares, found, one, two)
        if total <= room:
            return one[:total], two[:total]
        room = total


@kernel()
def _pairs(squares: Squares, found: I64, one: I64, two: I64) -> int:
    """Write as many pairs as there is room for; return how many there are."""
    total = 0
    for e in range(len(squares.level)):
        count = touching(squares, e, found)
        for k in range(count):
            if total < one.size:
                one[total], two[total] = e, found[k]
            total += 1
    return total
