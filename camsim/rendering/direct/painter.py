"""The painter's rule, asked at a place: of all shapes that cover it the last one is seen. No polygon is clipped."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel, shared
from camsim.rendering.direct.cuts import lies_on
from camsim.rendering.direct.records import Outlines, Owners

# Times as far as places that are one: what is seen is asked beside a part, on either side; where others run along it as
# near as the second of these, one stands for all, and beyond them.
BESIDE, ALONG, BEYOND = 4.0, 6.0, 9.0
PARTS_A_ROW = 4  # times as many as parts, at the most, are rows' parts
PIECES_AT_ONCE = 64


class Rows(NamedTuple):
    """Parts of each fill by rows, as high as few of them begin in, so that few are asked about a place.

    begin, high : (fills + 1,) where each fill's rows begin, and (fills,) what lies above all of it
    low         : (rows,) where each begins
    first, part : where each row's parts begin, and they
    """

    begin: I64
    high: F64
    low: F64
    first: I64
    part: I64

    @classmethod
    def of(cls, owners: Owners, boxes: F64, same: F64) -> Rows:
        """Sort parts into rows; boxes (n, 4) about each part, and (n,) how near places are one."""
        parts = np.diff(owners.part)
        fill = np.repeat(np.arange(len(parts)), parts)
        low_y, high_y = boxes[:, 1] - 2.0 * BEYOND * same, boxes[:, 3] + 2.0 * BEYOND * same
        high = np.full(len(parts), -np.inf)
        np.maximum.at(high, fill, high_y)
        sorted_y = low_y[np.lexsort((low_y, fill))]
        count = np.maximum(parts, 1)
        while True:
            begin = np.concatenate([[0], np.cumsum(count)])
            owner = np.repeat(np.arange(len(count)), count)
            number = np.arange(begin[-1]) - begin[owner]
            rank = np.minimum(owners.part[owner] + number * parts[owner] // count[owner], len(fill) - 1)
            low = np.where(parts[owner] > 0, sorted_y[rank], np.inf)
            one, two = _rows_of(begin, low, fill, low_y), _rows_of(begin, low, fill, high_y)
            times = two - one + 1
            # Tall parts lie in many rows: then there are fewer.
            much = np.bincount(fill, times, len(parts)) / (PARTS_A_ROW * np.maximum(parts, 1))
            if (much <= 1.0).all():  # as in one row they are
                break
            count = np.maximum(np.where(much > 1.0, count / np.maximum(2.0, much), count), 1).astype(np.int64)
        part = np.repeat(np.arange(len(fill)), times)
        row = one[part] + np.arange(part.size) - np.repeat(np.cumsum(times) - times, times)
        order = np.argsort(row, kind="stable")
        return cls(begin, high, low, np.searchsorted(row[order], np.arange(begin[-1] + 1)), part[order])


@kernel()
def _row_at(low: F64, begin: int, end: int, y: float) -> int:
    """Return the last of rows that begins no higher than a place, the first where none does."""
    while end - begin > 1:
        middle = (begin + end) // 2
        if low[middle] <= y:
            begin = middle
        else:
            end = middle
    return begin


@kernel(allocates=True)
def _rows_of(begin: I64, low: F64, fill: I64, y: F64) -> I64:
    """Return the row that each place lies in, of its fill's."""
    rows = np.empty(len(fill), np.int64)
    for k in range(len(fill)):
        rows[k] = _row_at(low, begin[fill[k]], begin[fill[k] + 1], y[k])
    return rows


@kernel()
def _row(rows: Rows, fill: int, y: float) -> int:
    """Return the row of a fill that a place lies in, −1 for none."""
    begin, end = rows.begin[fill], rows.begin[fill + 1]
    if y < rows.low[begin] or y > rows.high[fill]:
        return -1
    return _row_at(rows.low, begin, end, y)


@kernel()
def _winds(o: Outlines, rows: Rows, owners: Owners, fill: int, x: float, y: float) -> int:
    """Return how often a fill's outlines wind about a place."""
    turns = 0
    row = _row(rows, fill, y)
    if row < 0:
        return 0
    for k in range(rows.first[row], rows.first[row + 1]):
        f = rows.part[k]
        x0, y0, x1, y1 = owners.ends[f]
        side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
        if o.turn_rad[f] != 0.0 and math.hypot(x - o.x[f], y - o.y[f]) < o.dx[f]:
            whole = abs(o.turn_rad[f]) >= math.tau * (1.0 - 1e-15)
            # Between the chord and its arc; a place on the chord lies right of it where it does not count as left of it
            # below: on a level one as if it were above.
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
    """Return whether a primitive covers a place: some fill of every layer does."""
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
    """Which primitives lie near each one, itself among them, in painter's order: where they begin, and they."""

    begin: I64
    other: I64
    boxes: F64


@kernel(forceinline=True)
def _within(box: F64, x: float, y: float, same: float) -> bool:
    """Return whether a place lies in a box (4,) or as near."""
    inside: bool = box[0] - same <= x <= box[2] + same and box[1] - same <= y <= box[3] + same
    return inside


@kernel()
def _seen(o: Outlines, rows: Rows, owners: Owners, near: Near, own: int, x: float, y: float) -> int:
    """Return the last primitive that covers a place, −1 for none."""
    for k in range(near.begin[own + 1] - 1, near.begin[own] - 1, -1):
        j = near.other[k]
        if _within(near.boxes[j], x, y, 0.0) and _covers(o, rows, owners, j, x, y):
            return int(j)
    return -1


@kernel()
def _clipped(o: Outlines, rows: Rows, owners: Owners, j: int, place: tuple[float, float, float, float, float]) -> bool:
    """Return whether a primitive of several layers covers neither side of a place, though its outline runs there."""
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
    """Return how many other parts run along part ``e`` at a place, whether an earlier one stands for it, or none has
    to (there it belongs to what clips its primitive, of which nothing is there), and how near places are one of all.

    place : x, y, how near parts of any size run along one another, and from there to a place beyond them
    same  : how near places are one, of each part
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
            row = _row(rows, fill, y)
            if row < 0:
                continue
            for p in range(rows.first[row], rows.first[row + 1]):
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
    """Return the spectra to the left and right of every piece; the same twice where another piece stands for it.

    piece : whose part (n,), from where and to where (n,);  whose, same: each part's primitive and how near is the same
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
    """Find the spectra of some pieces; parts: whose, of, same, and the most of these."""
    (owner, low, high), (whose, of, same, most), (left, right) = piece, parts, sides
    for p in range(begin, end):
        e = owner[p]
        fewest = 1 << 60
        # Where another outline just touches a piece its sides are asked elsewhere; what runs along does so everywhere.
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
    """Find which places (n, 2) a primitive covers that is numbered ``after`` (n,), or later; boxes: about each."""
    for k in range(len(at)):
        for j in range(after[k], len(boxes)):
            if _within(boxes[j], at[k, 0], at[k, 1], 0.0) and _covers(o, rows, owners, j, at[k, 0], at[k, 1]):
                found[k] = True
                break
