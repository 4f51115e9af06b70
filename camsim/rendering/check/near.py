"""Which boxes touch: squares of doubling size, each box in one of the smallest that it fits into."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel

MOST_LEVELS = 40
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
        size = max(float(np.median(sides)), whole * 2.0 ** (1 - MOST_LEVELS), np.finfo(float).tiny)
        level = np.clip(np.ceil(np.log2(np.maximum(sides, size) / size)), 0, MOST_LEVELS).astype(np.int64)
        x, y = np.floor((boxes[:, :2] - low) / (size * 2.0**level)[:, None]).astype(np.int64).T
        key = y * ROW + x
        order = np.lexsort((key, level))
        first = np.searchsorted(level[order], np.arange(MOST_LEVELS + 2))
        return cls(boxes, level, low, size, first, key[order], order)


@kernel()
def touching(squares: Squares, e: int, found: I64) -> tuple[I64, int]:
    """Write the boxes that touch box ``e`` and are no smaller, each pair once; return where, and how many."""
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
            k = begin + np.searchsorted(squares.key[begin:end], row * ROW + max(low_x, 0))
            while k < end and squares.key[k] <= row * ROW + high_x:
                f = squares.box[k]
                k += 1
                if level == squares.level[e] and f <= e:
                    continue
                b = squares.boxes[f]
                if b[0] > x1 or b[2] < x0 or b[1] > y1 or b[3] < y0:
                    continue
                if count == found.size:
                    more = np.empty(2 * count, np.int64)
                    more[:count] = found
                    found = more
                found[count] = f
                count += 1
    return found, count


@kernel()
def pairs(squares: Squares) -> tuple[I64, I64]:
    """Return all pairs of boxes that touch, each once."""
    one, two = np.empty(64, np.int64), np.empty(64, np.int64)
    total = 0
    found = np.empty(64, np.int64)
    for e in range(len(squares.level)):
        found, count = touching(squares, e, found)
        if total + count > one.size:
            more_one, more_two = np.empty(2 * (total + count), np.int64), np.empty(2 * (total + count), np.int64)
            more_one[:total], more_two[:total] = one[:total], two[:total]
            one, two = more_one, more_two
        one[total : total + count] = e
        two[total : total + count] = found[:count]
        total += count
    return one[:total], two[:total]
