"""Cuts of outlines where they cross, touch or overlap one another.

Touching bounding boxes are found first: of boxes sorted by their left sides, each is tested against those that begin
within it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel
from camsim.rendering.direct.records import Outlines

STEPS = 2  # of Newton's method
SHORTEST = 0.1  # of a piece, over the distance below which places coincide


class Near(NamedTuple):
    """Neighbours of each box, itself included, in order.

    begin, other : first entry of each box in ``other``, and the indices of the neighbours
    """

    begin: I64
    other: I64

    @classmethod
    def of(cls, boxes: F64) -> Near:
        """Find the boxes (n, 4) low x, low y, high x, high y that touch; an infinite one touches none."""
        some = np.flatnonzero(np.isfinite(boxes).all(axis=1))
        some = some[np.argsort(boxes[some, 0], kind="stable")]
        by_x, room, count = boxes[some], 8 * some.size, len(boxes)
        while True:
            one, two = np.empty((2, room), np.int64)
            total = _pairs(by_x, one, two)
            if total <= room:
                break
            room = total
        one, two = some[one[:total]], some[two[:total]]
        both = np.sort(np.concatenate([some * count + some, one * count + two, two * count + one]))
        whose, other = np.divmod(both, max(count, 1))
        return cls(np.searchsorted(whose, np.arange(count + 1)), other)


@kernel()
def _pairs(by_x: F64, one: I64, two: I64) -> int:
    """Write pairs of touching boxes, sorted by low x, up to the arrays' size; return the number of all pairs."""
    total = 0
    for e in range(len(by_x)):
        _, low, right, high = by_x[e]
        for f in range(e + 1, len(by_x)):
            if by_x[f, 0] > right:
                break
            if by_x[f, 1] <= high and by_x[f, 3] >= low:
                if total < one.size:
                    one[total], two[total] = e, f
                total += 1
    return total


@kernel(forceinline=True)
def place_at(o: Outlines, e: int, t: float) -> tuple[float, float, float, float]:
    """Return the place on a part at a fraction t of it, and the derivative there with respect to t."""
    if o.turn_rad[e] == 0.0:
        return o.x[e] + t * o.dx[e], o.y[e] + t * o.dy[e], o.dx[e], o.dy[e]
    angle = o.from_rad[e] + t * o.turn_rad[e]
    x, y = o.dx[e] * math.cos(angle), o.dx[e] * math.sin(angle)
    return o.x[e] + x, o.y[e] + y, -o.turn_rad[e] * y, o.turn_rad[e] * x


@kernel()
def share_of(o: Outlines, e: int, x: float, y: float, slack: float) -> float:
    """Return the foot of the perpendicular from a place to a part, as a fraction of the part's length.

    Within ``slack`` before the start of an arc it is slightly negative rather than far above 1.
    """
    if o.turn_rad[e] == 0.0:
        square = o.dx[e] ** 2 + o.dy[e] ** 2
        if square == 0.0:  # its length underflows: no place lies on it
            return -1.0
        along: float = ((x - o.x[e]) * o.dx[e] + (y - o.y[e]) * o.dy[e]) / square
        return along
    turn: float = abs(o.turn_rad[e])
    angle: float = math.atan2(y - o.y[e], x - o.x[e]) - o.from_rad[e]
    angle = (angle if o.turn_rad[e] > 0.0 else -angle) % math.tau
    if angle > turn and math.tau - angle <= slack / o.dx[e]:
        angle -= math.tau
    return angle / turn


@kernel(forceinline=True)
def _out_of(o: Outlines, e: int, x: float, y: float) -> tuple[float, float, float]:
    """Return the signed distance of a place outside a part's circle or right of its line, and its gradient."""
    if o.turn_rad[e] == 0.0:
        length = math.hypot(o.dx[e], o.dy[e])
        out = ((x - o.x[e]) * o.dy[e] - (y - o.y[e]) * o.dx[e]) / length
        return out, o.dy[e] / length, -o.dx[e] / length
    gap = math.hypot(x - o.x[e], y - o.y[e])
    if gap == 0.0:
        return -o.dx[e], 1.0, 0.0
    return gap - o.dx[e], (x - o.x[e]) / gap, (y - o.y[e]) / gap


@kernel()
def off_of(o: Outlines, e: int, x: float, y: float) -> float:
    """Return the distance of a place from a part's line or circle."""
    return abs(_out_of(o, e, x, y)[0])


@kernel(forceinline=True)
def _far_off(o: Outlines, e: int, x: float, y: float, same: float) -> bool:
    """Return whether a place clearly lies off a straight part; a fast test that needs no square root."""
    away: bool = abs((x - o.x[e]) * o.dy[e] - (y - o.y[e]) * o.dx[e]) > same * (abs(o.dx[e]) + abs(o.dy[e]))
    return away and o.turn_rad[e] == 0.0


@kernel()
def lies_on(o: Outlines, e: int, x: float, y: float, same: float) -> bool:
    """Return whether a place lies on a part, to within ``same``."""
    if _far_off(o, e, x, y, same) or off_of(o, e, x, y) > same:
        return False
    long = math.hypot(o.dx[e], o.dy[e]) if o.turn_rad[e] == 0.0 else o.dx[e] * abs(o.turn_rad[e])
    share = share_of(o, e, x, y, same)
    return -same <= share * long <= long + same


@kernel()
def _add(o: Outlines, e: int, x: float, y: float, same: float, out: F64, count: int) -> int:
    """Append the position of a place on a part, as a fraction of it, if it lies there; return the new count."""
    if not _far_off(o, e, x, y, same) and off_of(o, e, x, y) <= same:
        t = share_of(o, e, x, y, same)
        if 0.0 < t < 1.0:
            out[count] = t
            return count + 1
    return count


@kernel()
def _both(o: Outlines, e: int, f: int, x: float, y: float, room: float, same: float, out: F64, count: int) -> int:
    """Append a place on part ``e`` if it also lies on part ``f``, after refinement by Newton's method.

    room : largest step: where circles nearly touch, half their chord is the root of a difference that cancels
    """
    for _ in range(STEPS):
        off_e, ex, ey = _out_of(o, e, x, y)
        off_f, fx, fy = _out_of(o, f, x, y)
        cross = ex * fy - ey * fx
        if cross == 0.0:
            break
        step_x, step_y = (fy * off_e - ey * off_f) / cross, (ex * off_f - fx * off_e) / cross
        if math.hypot(step_x, step_y) > room:
            break
        x, y = x - step_x, y - step_y
    return _add(o, e, x, y, 1e3 * same, out, count) if lies_on(o, f, x, y, 1e3 * same) else count


@kernel()
def _crossings(o: Outlines, ends: F64, e: int, f: int, same: float, out: F64) -> int:
    """Write where part ``e`` meets part ``f``, as fractions of ``e``; return how many (at most four)."""
    count = 0
    if o.turn_rad[e] == 0.0 and o.turn_rad[f] == 0.0:
        begin = (o.x[f] - o.x[e]) * o.dy[e] - (o.y[f] - o.y[e]) * o.dx[e]
        end = begin + o.dx[f] * o.dy[e] - o.dy[f] * o.dx[e]
        near = 2.0 * same * (abs(o.dx[e]) + abs(o.dy[e]))
        if min(begin, end) > near or max(begin, end) < -near:
            return 0  # f lies on one side of e
        cross = o.dx[e] * o.dy[f] - o.dy[e] * o.dx[f]
        if cross != 0.0:
            gap_x, gap_y = o.x[f] - o.x[e], o.y[f] - o.y[e]
            t = (gap_x * o.dy[f] - gap_y * o.dx[f]) / cross
            u = (gap_x * o.dy[e] - gap_y * o.dx[e]) / cross
            slack = same / math.hypot(o.dx[f], o.dy[f])
            if 0.0 < t < 1.0 and -slack <= u <= 1.0 + slack:
                out[count] = t
                count += 1
    elif o.turn_rad[e] == 0.0 or o.turn_rad[f] == 0.0:
        line, ring = (e, f) if o.turn_rad[e] == 0.0 else (f, e)
        length = math.hypot(o.dx[line], o.dy[line])
        tx, ty = o.dx[line] / length, o.dy[line] / length
        px, py = o.x[ring] - o.x[line], o.y[ring] - o.y[line]
        foot, off = px * tx + py * ty, px * ty - py * tx
        square = (o.dx[ring] - off) * (o.dx[ring] + off)
        if square > 0.0:
            half, room = math.sqrt(square), math.sqrt(o.dx[ring] * same)
            for s in (foot - half, foot + half):
                if -room <= s <= length + room:
                    count = _both(o, e, f, o.x[line] + s * tx, o.y[line] + s * ty, room, same, out, count)
    else:
        px, py = o.x[f] - o.x[e], o.y[f] - o.y[e]
        gap = math.hypot(px, py)
        if gap > same:
            # Compute from the smaller circle: a large radius would cancel the digits of a short sagitta.
            a, b = (e, f) if o.dx[e] <= o.dx[f] else (f, e)
            sign = 1.0 if a == e else -1.0
            along = 0.5 * (gap + (o.dx[a] - o.dx[b]) * (o.dx[a] + o.dx[b]) / gap)
            square = (o.dx[a] - along) * (o.dx[a] + along)
            if square > 0.0:
                half, room = math.sqrt(square), math.sqrt(o.dx[a] * same)
                for side in (-half, half):
                    x = o.x[a] + sign * (along * px - side * py) / gap
                    y = o.y[a] + sign * (along * py + side * px) / gap
                    count = _both(o, e, f, x, y, room, same, out, count)
    # End points of the other part: parts that overlap along their length do not cross.
    if abs(o.turn_rad[f]) < math.tau * (1.0 - 1e-15):
        for k in (0, 2):
            count = _add(o, e, ends[f, k], ends[f, k + 1], same, out, count)
    return count


@kernel()
def _apart(o: Outlines, e: int, box: F64) -> bool:
    """Return whether a part's line or circle clearly misses a box (4,)."""
    off = off_of(o, e, 0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3]))
    away: bool = off > 0.51 * math.hypot(box[2] - box[0], box[3] - box[1])
    return away


def _cuts(o: Outlines, ends: F64, boxes: F64, near: Near, same: F64) -> tuple[I64, F64]:
    """Return all cuts: the part of each (n,), and its position as a fraction of it (n,)."""
    room = 16 * len(o.x)
    while True:
        owner, places = np.empty(room, np.int64), np.empty(room)
        total = _cut(o, ends, boxes, near, same, np.empty(8), owner, places)
        if total <= room:
            return owner[:total], places[:total]
        room = total


@kernel()
def _cut(o: Outlines, ends: F64, boxes: F64, near: Near, same: F64, out: F64, owner: I64, places: F64) -> int:
    """Write cuts up to the arrays' size; return the number of all cuts."""
    total = 0
    for e in range(len(o.x)):
        for k in range(near.begin[e], near.begin[e + 1]):
            f = near.other[k]
            if e == f or _apart(o, e, boxes[f]) or _apart(o, f, boxes[e]):
                continue
            cuts = _crossings(o, ends, e, f, max(same[e], same[f]), out)
            for cut in range(cuts):
                if total < places.size:
                    owner[total], places[total] = e, out[cut]
                total += 1
    return total


def pieces_between_cuts(o: Outlines, ends: F64, boxes: F64, near: Near, same: F64) -> tuple[I64, F64, F64]:
    """Return the pieces between all cuts: the part of each, and its start and end as fractions of the part.

    ends, boxes, same : (n, 4) of each part, and (n,) distance below which places coincide
    near : parts with touching boxes
    """
    cut_owner, places = _cuts(o, ends, boxes, near, same)
    parts = np.arange(len(same))
    owner = np.concatenate([parts, parts, cut_owner])
    ends = np.concatenate([np.zeros(len(same)), np.ones(len(same)), places])
    order = np.lexsort((ends, owner))
    owner, ends = owner[order], ends[order]
    low, high = ends[:-1], ends[1:]
    # A piece no longer than rounding has no direction.
    real = (owner[:-1] == owner[1:]) & ((high - low) * o.length[owner[:-1]] > SHORTEST * same[owner[:-1]])
    return owner[:-1][real], low[real], high[real]
