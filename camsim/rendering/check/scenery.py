"""What the check sees of a scene: pieces of outlines, straight or round, and what is to be seen on either side of each.

No polygon is clipped. Every outline is cut where another crosses it; in the middle of each piece the painter's rule is
asked twice, on its left and on its right: of all shapes that cover the place the last one is seen. A shape covers a
place when its outline winds about it; where the place lies on the shape's own outline, one side is inside and the other
is not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba as nb
import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel
from camsim.scene import Scene
from camsim.spectra.curve import Spectrum

SAME = 1e-10  # pitches, and as a share of the largest coordinate: places this near are one


class Outlines(NamedTuple):
    """Straight and round parts of outlines, all of a shape's side by side, insides to the left (cross product above 0).

    x, y, dx, dy : start and vector to the end of a straight part; of a round one its centre, and (radius, 0)
    from_rad, turn_rad : of a round part, the angle at which it begins and how far it goes; a turn of 0 is straight
    shape        : which shape it belongs to
    """

    x: F64
    y: F64
    dx: F64
    dy: F64
    from_rad: F64
    turn_rad: F64
    shape: I64


class Pieces(NamedTuple):
    """What is left of the outlines: parts with different spectra on their two sides."""

    outlines: Outlines
    left: I64
    right: I64


def outlines_of(scene: Scene, pitch_um: float) -> Outlines:
    """Return the outlines of all shapes, pitches; discs are circles."""
    rows: list[F64] = []
    for number, shape in enumerate(scene.shapes):
        if shape.circle_um is not None:
            x, y, radius = np.array(shape.circle_um) / pitch_um
            rows.append(np.array([[x, y, radius, 0.0, 0.0, math.tau, number]]))
            continue
        corners = np.asarray(shape.outline_um(math.inf), float) / pitch_um
        along = np.roll(corners, -1, axis=0) - corners
        from_first = corners - corners[0]
        if (
            np.sum(from_first[:, 0] * np.roll(from_first[:, 1], -1) - from_first[:, 1] * np.roll(from_first[:, 0], -1))
            < 0
        ):
            corners, along = corners + along, -along
        part = np.concatenate([corners, along, np.zeros((len(corners), 2))], axis=1)
        rows.append(np.column_stack([part, np.full(len(corners), number)])[np.any(along != 0.0, axis=1)])
    table = np.concatenate(rows) if rows else np.empty((0, 7))
    x, y, dx, dy, from_rad, turn_rad = (np.ascontiguousarray(column) for column in table.T[:6])
    return Outlines(x, y, dx, dy, from_rad, turn_rad, table[:, 6].astype(np.int64))


def pieces_of(scene: Scene, pitch_um: float) -> tuple[Pieces, tuple[Spectrum, ...]]:
    """Return the pieces of a scene, pitches, and its spectra: the background first."""
    spectra: dict[Spectrum, int] = {scene.background: 0}
    of_shape = np.array([spectra.setdefault(shape.reflectance, len(spectra)) for shape in scene.shapes], np.int64)
    outlines = outlines_of(scene, pitch_um)
    if not len(outlines.x):
        nothing = np.empty(0, np.int64)
        return Pieces(outlines, nothing, nothing), tuple(spectra)
    boxes = _boxes(outlines)
    first = np.searchsorted(outlines.shape, np.arange(len(scene.shapes) + 1))
    filled = np.flatnonzero(np.diff(first))
    shape_boxes = np.full((len(scene.shapes), 4), np.inf)
    shape_boxes[:, 2:] = -np.inf
    shape_boxes[filled, :2] = np.minimum.reduceat(boxes[:, :2], first[filled])
    shape_boxes[filled, 2:] = np.maximum.reduceat(boxes[:, 2:], first[filled])
    size = float(np.abs(np.concatenate([outlines.x, outlines.y])).max())
    same = SAME * max(1.0, size)
    begin, near = _neighbours(shape_boxes, same)
    cuts, places = _cuts(outlines, boxes, first, begin, near, shape_boxes, same)
    owner, low, high = _between(cuts, places)
    left, right = _sides(outlines, owner, low, high, first, begin, near, shape_boxes, of_shape, same)
    length = np.where(outlines.turn_rad == 0.0, np.hypot(outlines.dx, outlines.dy), outlines.dx * outlines.turn_rad)
    # A piece as short as rounding has no direction.
    seen = (left != right) & ((high - low) * length[owner] > 1e-3 * same)
    owner, low, high = owner[seen], low[seen], high[seen]
    whole = Outlines(*(column[owner] for column in outlines))
    straight = whole.turn_rad == 0.0
    cut = Outlines(
        x=whole.x + np.where(straight, low * whole.dx, 0.0),
        y=whole.y + np.where(straight, low * whole.dy, 0.0),
        dx=np.where(straight, (high - low) * whole.dx, whole.dx),
        dy=np.where(straight, (high - low) * whole.dy, 0.0),
        from_rad=whole.from_rad + low * whole.turn_rad,
        turn_rad=(high - low) * whole.turn_rad,
        shape=whole.shape,
    )
    return Pieces(cut, left[seen], right[seen]), tuple(spectra)


def _boxes(o: Outlines) -> F64:
    """Return (n, 4) low x, low y, high x, high y; of a round part its whole circle's."""
    straight = o.turn_rad == 0.0
    x2, y2 = np.where(straight, o.x + o.dx, o.x), np.where(straight, o.y + o.dy, o.y)
    more = np.where(straight, 0.0, o.dx)
    return np.stack(
        [
            np.minimum(o.x, x2) - more,
            np.minimum(o.y, y2) - more,
            np.maximum(o.x, x2) + more,
            np.maximum(o.y, y2) + more,
        ],
        axis=1,
    )


def _neighbours(boxes: F64, same: float) -> tuple[I64, I64]:
    """Return for each shape the others whose boxes touch its own, in painter's order: where they begin, and they."""
    count = len(boxes)
    order = np.argsort(boxes[:, 0], kind="stable")
    lows = boxes[order, 0]
    pairs: list[tuple[I64, I64]] = []
    for place, i in enumerate(order.tolist()):
        stop = int(np.searchsorted(lows, boxes[i, 2] + same, side="right"))
        other = order[place + 1 : stop]
        other = other[(boxes[other, 1] <= boxes[i, 3] + same) & (boxes[other, 3] >= boxes[i, 1] - same)]
        pairs.append((np.full(other.size, i), other))
    one = np.concatenate([pair[0] for pair in pairs])
    two = np.concatenate([pair[1] for pair in pairs])
    a, b = np.concatenate([one, two]), np.concatenate([two, one])
    sort = np.lexsort((b, a))
    return np.searchsorted(a[sort], np.arange(count + 1)), b[sort]


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
def _cuts(o: Outlines, boxes: F64, first: I64, begin: I64, near: I64, shape_boxes: F64, same: float) -> tuple[I64, F64]:
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


def _between(cuts: I64, places: F64) -> tuple[I64, F64, F64]:
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
def _sides(
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
