"""Where outlines cross, touch or run along one another: there they are cut."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel
from camsim.rendering.check.outlines import Outlines


@kernel()
def _on_line(o: Outlines, e: int, x: float, y: float, same: float, out: F64, count: int) -> int:
    """Append where a place lies on a part, as a share of it (nothing where it does not)."""
    if o.turn_rad[e] == 0.0:
        square = o.dx[e] ** 2 + o.dy[e] ** 2
        t = ((x - o.x[e]) * o.dx[e] + (y - o.y[e]) * o.dy[e]) / square
        off = abs((x - o.x[e]) * o.dy[e] - (y - o.y[e]) * o.dx[e]) / math.sqrt(square)
        if off <= same and 0.0 < t < 1.0:
            out[count] = t
            return count + 1
    elif abs(math.hypot(x - o.x[e], y - o.y[e]) - o.dx[e]) <= same:
        t = ((math.atan2(y - o.y[e], x - o.x[e]) - o.from_rad[e]) % math.tau) / o.turn_rad[e]
        if 0.0 < t < 1.0:
            out[count] = t
            return count + 1
    return count


@kernel()
def _crossings(o: Outlines, e: int, f: int, same: float, out: F64) -> int:
    """Write where part ``e`` meets part ``f``, as shares of ``e``; return how many (at most six)."""
    count = 0
    if o.turn_rad[e] == 0.0 and o.turn_rad[f] == 0.0:
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
        square = o.dx[ring] ** 2 - off * off
        if square > 0.0:
            half = math.sqrt(square)
            for s in (foot - half, foot + half):
                if -same <= s <= length + same:
                    x, y = o.x[line] + s * tx, o.y[line] + s * ty
                    count = _on_line(o, e, x, y, 1e3 * same, out, count)
    else:
        px, py = o.x[f] - o.x[e], o.y[f] - o.y[e]
        gap = math.hypot(px, py)
        if gap > same:
            along = (gap * gap + o.dx[e] ** 2 - o.dx[f] ** 2) / (2.0 * gap)
            square = o.dx[e] ** 2 - along * along
            if square > 0.0:
                half = math.sqrt(square)
                for side in (-half, half):
                    x = o.x[e] + (along * px - side * py) / gap
                    y = o.y[e] + (along * py + side * px) / gap
                    count = _on_line(o, e, x, y, 1e3 * same, out, count)
    # The other part's ends: parts that run along each other cross nowhere.
    if o.turn_rad[f] == 0.0:
        count = _on_line(o, e, o.x[f], o.y[f], same, out, count)
        count = _on_line(o, e, o.x[f] + o.dx[f], o.y[f] + o.dy[f], same, out, count)
    return count


@kernel()
def cuts_of(
    o: Outlines, boxes: F64, first: I64, begin: I64, near: I64, shape_boxes: F64, same: float
) -> tuple[I64, F64]:
    """Return where every part is cut: (n + 1,) where each one's cuts begin, and they, in order, as shares of it."""
    count = len(o.x)
    starts = np.zeros(count + 1, np.int64)
    places = np.empty(64)
    total = 0
    out = np.empty(8)
    for e in range(count):
        x0, y0, x1, y1 = boxes[e]
        for k in range(begin[o.shape[e]], begin[o.shape[e] + 1]):
            j = near[k]
            if (
                shape_boxes[j, 0] > x1 + same
                or shape_boxes[j, 2] < x0 - same
                or shape_boxes[j, 1] > y1 + same
                or shape_boxes[j, 3] < y0 - same
            ):
                continue
            for f in range(first[j], first[j + 1]):
                if boxes[f, 0] > x1 + same or boxes[f, 2] < x0 - same:
                    continue
                if boxes[f, 1] > y1 + same or boxes[f, 3] < y0 - same:
                    continue
                found = _crossings(o, e, f, same, out)
                if total + found > places.size:
                    more = np.empty(2 * (total + found))
                    more[:total] = places[:total]
                    places = more
                places[total : total + found] = out[:found]
                total += found
        places[starts[e] : total] = np.sort(places[starts[e] : total])
        starts[e + 1] = total
    return starts, places[:total]


def between(cuts: I64, places: F64) -> tuple[I64, F64, F64]:
    """Return the pieces between the cuts: whose part, from where to where."""
    parts = len(cuts) - 1
    owner = np.repeat(np.arange(parts), np.diff(cuts))
    owners = np.concatenate([np.arange(parts), owner, np.arange(parts)])
    ends = np.concatenate([np.zeros(parts), places, np.ones(parts)])
    order = np.lexsort((ends, owners))
    owners, ends = owners[order], ends[order]
    low, high = ends[:-1], ends[1:]
    real = (owners[:-1] == owners[1:]) & (high > low)
    return owners[:-1][real], low[real], high[real]
