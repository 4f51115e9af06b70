"""What the difference adds beside lines, and which photosites need more than lines; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

from camsim.arrays import F64, I64, U8
from camsim.kernels import kernel


class Lines(NamedTuple):
    """Edges as they are met along rows: first end, direction, length; response −1: too short to be a line."""

    x: F64
    y: F64
    tx: F64
    ty: F64
    length: F64
    response: I64
    pair: I64


class Responses(NamedTuple):
    """What a photosite h from a line sees: quintics (responses, pairs, channels, cells, 6) of h + near, by ``step``."""

    cells: F64
    near: float
    step: float


@kernel(forceinline=True)
def _between(at_zero: float, slope: float, low: float, high: float, begin: float, end: float) -> tuple[float, float]:
    """Return the part of begin … end where at_zero + slope·x lies in low … high."""
    if abs(slope) < 1e-12:
        return (begin, end) if low <= at_zero <= high else (1.0, 0.0)
    a, b = (low - at_zero) / slope, (high - at_zero) / slope
    return max(begin, min(a, b)), min(end, max(a, b))


@kernel(forceinline=True)
def _beside(ex: float, dy: float, tx: float, ty: float, length: float, near: float, cols: int) -> tuple[float, float]:
    """Return the columns of a row whose photosites have their foot on an edge, and the edge within ``near``.

    Of the photosite in column c, h = (ex − c)·ty − dy·tx and s = (c − ex)·tx − dy·ty.
    """
    begin, finish = _between(ex * ty - dy * tx, -ty, -near, near, 0.0, cols - 1.0)
    return _between(-ex * tx - dy * ty, tx, 0.0, length, begin, finish)


@kernel()
def mark(origin: tuple[float, float], lines: Lines, near: float, marked: U8, first: int, stop: int) -> None:
    """Mark the photosites within ``near`` of an end, or of an edge that is no line, in rows ``first`` … ``stop``.

    origin : x, y of the first of all
    """
    cols = marked.shape[1]
    for r in range(first, stop):
        for e in range(lines.x.size):
            tx, ty, length = lines.tx[e], lines.ty[e], lines.length[e]
            ex, dy = lines.x[e] - origin[0], lines.y[e] - origin[1] - r
            if max(dy, dy + length * ty) < -near or min(dy, dy + length * ty) > near:
                continue
            for end in range(2):
                square = near * near - (dy + end * length * ty) ** 2
                if square > 0.0:
                    half, middle = math.sqrt(square), ex + end * length * tx
                    for c in range(max(0, math.ceil(middle - half)), min(cols - 1, math.floor(middle + half)) + 1):
                        marked[r, c] = 1
            if lines.response[e] < 0:
                begin, finish = _beside(ex, dy, tx, ty, length, near, cols)
                for c in range(math.ceil(begin), math.floor(finish) + 1):
                    marked[r, c] = 1


@kernel()
def add_lines(
    origin: tuple[float, float],
    lines: Lines,
    responses: Responses,
    channel: U8,
    marked: U8,
    image: F64,
    first: int,
    stop: int,
) -> None:
    """Add what lines show to the photosites that are not marked, in rows ``first`` … ``stop``."""
    near, cols = responses.near, image.shape[1]
    last = responses.cells.shape[3] - 1
    for r in range(first, stop):
        for e in range(lines.x.size):
            response, pair = lines.response[e], lines.pair[e]
            tx, ty, length = lines.tx[e], lines.ty[e], lines.length[e]
            ex, dy = lines.x[e] - origin[0], lines.y[e] - origin[1] - r
            if response < 0 or max(dy, dy + length * ty) < -near or min(dy, dy + length * ty) > near:
                continue
            begin, finish = _beside(ex, dy, tx, ty, length, near, cols)
            for c in range(math.ceil(begin), math.floor(finish) + 1):
                if marked[r, c] == 0:
                    u = ((ex - c) * ty - dy * tx + near) / responses.step
                    cell = min(max(int(u), 0), last)
                    t = u - cell
                    p = responses.cells[response, pair, channel[r, c], cell]
                    image[r, c] += p[0] + t * (p[1] + t * (p[2] + t * (p[3] + t * (p[4] + t * p[5]))))
