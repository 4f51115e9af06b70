"""The painter's rule, asked at a place: of all shapes that cover it the last one is seen. No polygon is clipped."""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel
from camsim.rendering.check.outlines import Outlines


@kernel()
def _side(o: Outlines, f: int, x: float, y: float, tx: float, ty: float, same: float) -> float:
    """Return +1 where a place lies on part ``f`` and a direction runs as that does, −1 if against it; 0 elsewhere."""
    if o.turn_rad[f] == 0.0:
        square = o.dx[f] ** 2 + o.dy[f] ** 2
        length = math.sqrt(square)
        t = ((x - o.x[f]) * o.dx[f] + (y - o.y[f]) * o.dy[f]) / square
        off = abs((x - o.x[f]) * o.dy[f] - (y - o.y[f]) * o.dx[f]) / length
        if off > same or t < 0.0 or t > 1.0:
            return 0.0
        return 1.0 if tx * o.dx[f] + ty * o.dy[f] > 0.0 else -1.0
    if abs(math.hypot(x - o.x[f], y - o.y[f]) - o.dx[f]) > same:
        return 0.0
    return 1.0 if -tx * (y - o.y[f]) + ty * (x - o.x[f]) > 0.0 else -1.0


@kernel()
def _winds(o: Outlines, begin: int, end: int, x: float, y: float) -> bool:
    """Return whether an outline winds about a place."""
    turns = 0
    for f in range(begin, end):
        if o.turn_rad[f] != 0.0:
            if math.hypot(x - o.x[f], y - o.y[f]) < o.dx[f]:
                turns += 1
            continue
        above, below = o.y[f] <= y, o.y[f] + o.dy[f] <= y
        if above != below:
            side = o.dx[f] * (y - o.y[f]) - (x - o.x[f]) * o.dy[f]
            if above and side > 0.0:
                turns += 1
            elif below and side < 0.0:
                turns -= 1
    return turns != 0


@kernel()
def _seen(
    o: Outlines, e: int, t: float, first: I64, begin: I64, near: I64, shape_boxes: F64, same: float
) -> tuple[int, int, int, bool]:
    """Return the shapes seen to the left and right of a place on part ``e`` (−1: none), how many others' outlines lie
    there too, and whether an earlier shape's does."""
    if o.turn_rad[e] == 0.0:
        x, y = o.x[e] + t * o.dx[e], o.y[e] + t * o.dy[e]
        tx, ty = o.dx[e], o.dy[e]
    else:
        angle = o.from_rad[e] + t * o.turn_rad[e]
        tx, ty = -math.sin(angle), math.cos(angle)
        x, y = o.x[e] + o.dx[e] * ty, o.y[e] - o.dx[e] * tx
    own = o.shape[e]
    left, right, touching, earlier = own, -1, 0, False
    for k in range(begin[own], begin[own + 1]):
        j = near[k]
        if x < shape_boxes[j, 0] - same or x > shape_boxes[j, 2] + same:
            continue
        if y < shape_boxes[j, 1] - same or y > shape_boxes[j, 3] + same:
            continue
        runs = 0.0
        for f in range(first[j], first[j + 1]):
            runs = _side(o, f, x, y, tx, ty, same)
            if runs != 0.0:
                break
        touching += runs != 0.0
        earlier |= runs != 0.0 and j < own
        inside = runs == 0.0 and _winds(o, first[j], first[j + 1], x, y)
        if (inside or runs > 0.0) and j > left:
            left = j
        if (inside or runs < 0.0) and j > right:
            right = j
    return left, right, touching, earlier


@kernel(parallel=True)
def sides_of(
    o: Outlines,
    owner: I64,
    low: F64,
    high: F64,
    first: I64,
    begin: I64,
    near: I64,
    shape_boxes: F64,
    of_shape: I64,
    same: float,
) -> tuple[I64, I64]:
    """Return the spectra to the left and right of every piece; the same twice where another piece stands for it."""
    left, right = np.zeros(len(owner), np.int64), np.zeros(len(owner), np.int64)
    for p in nb.prange(len(owner)):
        fewest = 1 << 60
        # Where another outline just touches a piece its sides are asked elsewhere; what runs along does so everywhere.
        for part in (0.5, 0.382, 0.7):
            t = low[p] + part * (high[p] - low[p])
            top_left, top_right, touching, earlier = _seen(o, owner[p], t, first, begin, near, shape_boxes, same)
            if touching >= fewest:
                continue
            fewest = touching
            left[p] = right[p] = 0
            if not earlier:
                left[p] = of_shape[top_left]
                right[p] = of_shape[top_right] if top_right >= 0 else 0
            if not touching:
                break
    return left, right
