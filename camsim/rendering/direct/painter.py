"""The painter's rule at a place: the last of all shapes that cover it is visible. No polygon is clipped."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel, shared
from camsim.rendering.direct.cuts import lies_on
from camsim.rendering.direct.records import Outlines, Owners

# In units of the distance below which places coincide. The visible shapes are sampled at BESIDE on either side of a
# part. Parts within ALONG of it count as coincident: one represents all, and the samples are taken at BEYOND.
BESIDE, ALONG, BEYOND = 4.0, 6.0, 9.0
PIECES_AT_ONCE = 64  # fewer are not worth a thread


class Rows(NamedTuple):
    """Parts (n,) of each fill, sorted by their lower bounds, so that few are tested for a place.

    part    : indices of the parts; those of a fill begin at ``owners.part``
    low     : lower bound of each;  highest: upper bound of each and of those of its fill before it
    """

    part: I64
    low: F64
    highest: F64

    @classmethod
    def of(cls, owners: Owners, boxes: F64, same: F64) -> Rows:
        """Sort parts; boxes: (n, 4) of each part; same: (n,) distance below which places coincide."""
        fill = np.repeat(np.arange(len(owners.part) - 1), np.diff(owners.part))
        low, high = boxes[:, 1] - 2.0 * BEYOND * same, boxes[:, 3] + 2.0 * BEYOND * same
        part = np.lexsort((low, fill))
        highest = high[part]
        for one in np.split(highest, owners.part[1:-1]):
            np.maximum.accumulate(one, out=one)
        return cls(part, low[part], highest)


@kernel()
def _after(rows: Rows, begin: int, end: int, y: float) -> int:
    """Return the first of the sorted parts from ``begin`` to ``end`` that begins beyond y."""
    while begin < end:
        middle = (begin + end) // 2
        if rows.low[middle] <= y:
            begin = middle + 1
        else:
            end = middle
    return begin


@kernel()
def _winds(o: Outlines, rows: Rows, owners: Owners, fill: int, x: float, y: float) -> int:
    """Return the winding number of a fill's outlines about a place."""
    turns, begin = 0, owners.part[fill]
    for k in range(_after(rows, begin, owners.part[fill + 1], y) - 1, begin - 1, -1):
        if rows.highest[k] < y:
            break
        f = rows.part[k]
        x0, y0, x1, y1 = owners.ends[f]
        side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
        if o.turn_rad[f] != 0.0 and math.hypot(x - o.x[f], y - o.y[f]) < o.dx[f]:
            whole = abs(o.turn_rad[f]) >= math.tau * (1.0 - 1e-15)
            # Between the chord and its arc. A place on the chord is right of it unless the test below counts it as
            # left; a level chord counts as if the place were above it.
            right = side < 0.0 or (side == 0.0 and (y1 > y0 or (y1 == y0 and x1 < x0)))
            if whole or right == (o.turn_rad[f] > 0.0):
                turns += 1 if o.turn_rad[f] > 0.0 else -1
            if whole:
                continue
        above, below = y0 <= y, y1 <= y
        if above != below:
            if above and side > 0.0:
                turns += 1
            elif below and side < 0.0:
                turns -= 1
    return turns


@kernel()
def _covers(o: Outlines, rows: Rows, owners: Owners, primitive: int, x: float, y: float) -> bool:
    """Return whether a primitive covers a place, which takes at least one fill of every layer."""
    for layer in range(owners.layer[primitive], owners.layer[primitive + 1]):
        filled = False
        for fill in range(owners.fill[layer], owners.fill[layer + 1]):
            turns = _winds(o, rows, owners, fill, x, y)
            if turns % 2 == 1 if owners.even_odd[fill] else turns != 0:
                filled = True
                break
        if not filled:
            return False
    return True


class Near(NamedTuple):
    """Neighbours of each primitive in painter's order, itself included.

    begin, other : first entry of each primitive in ``other``, and the indices of the neighbours
    boxes        : (primitives, 4) bounding boxes
    """

    begin: I64
    other: I64
    boxes: F64


@kernel(forceinline=True)
def _within(box: F64, x: float, y: float, same: float) -> bool:
    """Return whether a place lies within ``same`` of a box (4,)."""
    inside: bool = box[0] - same <= x <= box[2] + same and box[1] - same <= y <= box[3] + same
    return inside


@kernel()
def _seen(o: Outlines, rows: Rows, owners: Owners, near: Near, own: int, x: float, y: float) -> int:
    """Return the last primitive near ``own`` that covers a place, or −1."""
    for k in range(near.begin[own + 1] - 1, near.begin[own] - 1, -1):
        j = near.other[k]
        if _within(near.boxes[j], x, y, 0.0) and _covers(o, rows, owners, j, x, y):
            return int(j)
    return -1


@kernel()
def _clipped(o: Outlines, rows: Rows, owners: Owners, j: int, place: tuple[float, float, float, float, float]) -> bool:
    """Return whether a clip removes a primitive on both sides of a place on its outline."""
    x, y, _, to_x, to_y = place
    if owners.layer[j + 1] - owners.layer[j] < 2 or _covers(o, rows, owners, j, x + to_x, y + to_y):
        return False
    return not _covers(o, rows, owners, j, x - to_x, y - to_y)


@kernel()
def _others(
    o: Outlines,
    rows: Rows,
    owners: Owners,
    near: Near,
    own: int,
    e: int,
    place: tuple[float, float, float, float, float],
    same: F64,
) -> tuple[int, bool, float]:
    """Return the number of other parts that coincide with part ``e`` at a place, whether to skip ``e``, and a distance.

    Part ``e`` is skipped if an earlier part represents it, or if a clip removes its primitive there. The distance is
    that below which places coincide, for the coarsest of these parts.

    place : x, y, largest distance of coincident parts, and the vector to a place beyond them
    same  : distance below which places coincide, of each part
    """
    x, y, most = place[:3]
    if not _within(near.boxes[own], x, y, most) or _clipped(o, rows, owners, own, place):
        return 0, True, same[e]
    count, earlier, coarsest = 0, False, same[e]
    for k in range(near.begin[own], near.begin[own + 1]):
        j = near.other[k]
        if not _within(near.boxes[j], x, y, most):
            continue
        here, before = 0, False
        for fill in range(owners.fill[owners.layer[j]], owners.fill[owners.layer[j + 1]]):
            begin = owners.part[fill]
            for p in range(_after(rows, begin, owners.part[fill + 1], y) - 1, begin - 1, -1):
                if rows.highest[p] < y:
                    break
                f = rows.part[p]
                if f != e and lies_on(o, f, x, y, ALONG * max(same[e], same[f])):
                    here += 1
                    before |= f < e
                    coarsest = max(coarsest, same[f])
        if here > 0 and (j == own or not _clipped(o, rows, owners, j, place)):
            count += here
            earlier |= before
    return count, earlier, coarsest


def sides_of(
    o: Outlines, rows: Rows, owners: Owners, near: Near, piece: tuple[I64, F64, F64], whose: I64, of: I64, same: F64
) -> tuple[I64, I64]:
    """Return the spectra to the left and right of every piece; equal where another piece represents it.

    piece : part (n,), start and end (n,);  whose, same: each part's primitive and distance below which places coincide
    of    : (primitives,) spectrum of each
    """
    left, right = np.zeros((2, len(piece[0])), np.int64)
    most = float(same.max(initial=0.0))

    def work(begin: int, end: int) -> None:
        _sides_of(begin, end, o, rows, owners, near, piece, (whose, of, same, most), (left, right))

    shared(len(left), work, least=PIECES_AT_ONCE)
    return left, right


@kernel()
def _sides_of(
    begin: int,
    end: int,
    o: Outlines,
    rows: Rows,
    owners: Owners,
    near: Near,
    piece: tuple[I64, F64, F64],
    parts: tuple[I64, I64, F64, float],
    sides: tuple[I64, I64],
) -> None:
    """Find the spectra of pieces begin … end; parts: whose, of, same, and the largest of ``same``."""
    (owner, low, high), (whose, of, same, most), (left, right) = piece, parts, sides
    for p in range(begin, end):
        e = owner[p]
        fewest = 1 << 60
        # Try several places: another outline may touch the piece at one, whereas a coincident one is found at all.
        for part in (0.5, 0.382, 0.7):
            t = low[p] + part * (high[p] - low[p])
            if o.turn_rad[e] == 0.0:
                x, y = o.x[e] + t * o.dx[e], o.y[e] + t * o.dy[e]
                length = math.hypot(o.dx[e], o.dy[e])
                tx, ty = o.dx[e] / length, o.dy[e] / length
            else:
                angle = o.from_rad[e] + t * o.turn_rad[e]
                way = 1.0 if o.turn_rad[e] > 0.0 else -1.0
                x, y = o.x[e] + o.dx[e] * math.cos(angle), o.y[e] + o.dx[e] * math.sin(angle)
                tx, ty = -way * math.sin(angle), way * math.cos(angle)
            to_x, to_y = -BEYOND * same[e] * ty, BEYOND * same[e] * tx
            place = x, y, ALONG * most, to_x, to_y
            count, earlier, coarsest = _others(o, rows, owners, near, whose[e], e, place, same)
            if count >= fewest:
                continue
            fewest = count
            left[p] = right[p] = 0
            beside = BEYOND * coarsest if count else BESIDE * same[e]
            to_x, to_y = -beside * ty, beside * tx
            if not earlier:
                one = _seen(o, rows, owners, near, whose[e], x + to_x, y + to_y)
                two = _seen(o, rows, owners, near, whose[e], x - to_x, y - to_y)
                left[p] = of[one] if one >= 0 else 0
                right[p] = of[two] if two >= 0 else 0
            if count == 0:
                break


@kernel()
def covered(o: Outlines, rows: Rows, owners: Owners, boxes: F64, at: F64, after: I64, found: np.ndarray) -> None:
    """Mark the places (n, 2) that primitives from number ``after`` (n,) on cover; boxes: of the primitives."""
    for k in range(len(at)):
        for j in range(after[k], len(boxes)):
            if _within(boxes[j], at[k, 0], at[k, 1], 0.0) and _covers(o, rows, owners, j, at[k, 0], at[k, 1]):
                found[k] = True
                break
