"""The painter's rule at a place: the last of all shapes that cover it is visible. No polygon is clipped."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel, shared
from camsim.rendering.direct.cuts import Near, lies_on, place_at
from camsim.rendering.direct.records import Outlines, Owners

# In units of the distance below which places coincide. The visible shapes are sampled at OFFSET on either side of a
# part. Parts within COINCIDENT of it count as coincident: one represents all, and the samples are taken at WIDE_OFFSET.
OFFSET, COINCIDENT, WIDE_OFFSET = 4.0, 6.0, 9.0
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
    def of(cls, owners: Owners, bounds: F64) -> Rows:
        """Sort parts; bounds: (n, 4) of each part."""
        fill = np.repeat(np.arange(len(owners.part) - 1), np.diff(owners.part))
        part = np.lexsort((bounds[:, 1], fill))
        highest = bounds[part, 3]
        for one in np.split(highest, owners.part[1:-1]):
            np.maximum.accumulate(one, out=one)
        return cls(part, bounds[part, 1], highest)


class Shapes(NamedTuple):
    """All shapes of a scene in painter's order, pitches.

    same   : (parts,) distance below which places coincide
    bounds : (parts, 4) bounds of each, with a margin: low x, low y, high x, high y
    boxes  : (primitives, 4) bounds of the region that each covers
    """

    parts: Outlines
    owners: Owners
    rows: Rows
    same: F64
    bounds: F64
    boxes: F64


@kernel(forceinline=True)
def _within(box: F64, x: float, y: float, same: float) -> bool:
    """Return whether a place lies within ``same`` of a box (4,)."""
    inside: bool = box[0] - same <= x <= box[2] + same and box[1] - same <= y <= box[3] + same
    return inside


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
def _winds(s: Shapes, fill: int, x: float, y: float) -> int:
    """Return the winding number of a fill's outlines about a place."""
    o, winding, begin = s.parts, 0, s.owners.part[fill]
    for k in range(_after(s.rows, begin, s.owners.part[fill + 1], y) - 1, begin - 1, -1):
        if s.rows.highest[k] < y:
            break
        f = s.rows.part[k]
        x0, y0, x1, y1 = s.owners.ends[f]
        side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
        round_ = o.turn_rad[f] != 0.0 and _within(s.bounds[f], x, y, 0.0)
        if round_ and math.hypot(x - o.x[f], y - o.y[f]) < o.dx[f]:
            whole = abs(o.turn_rad[f]) >= math.tau * (1.0 - 1e-15)
            # Between the chord and its arc. A place on the chord is right of it unless the test below counts it as
            # left; a level chord counts as if the place were above it.
            right = side < 0.0 or (side == 0.0 and (y1 > y0 or (y1 == y0 and x1 < x0)))
            if whole or right == (o.turn_rad[f] > 0.0):
                winding += 1 if o.turn_rad[f] > 0.0 else -1
            if whole:
                continue
        above, below = y0 <= y, y1 <= y
        if above != below:
            if above and side > 0.0:
                winding += 1
            elif below and side < 0.0:
                winding -= 1
    return winding


@kernel()
def _covers(s: Shapes, primitive: int, x: float, y: float) -> bool:
    """Return whether a primitive covers a place, which takes at least one fill of every layer."""
    for layer in range(s.owners.layer[primitive], s.owners.layer[primitive + 1]):
        filled = False
        for fill in range(s.owners.fill[layer], s.owners.fill[layer + 1]):
            winding = _winds(s, fill, x, y)
            if winding % 2 == 1 if s.owners.even_odd[fill] else winding != 0:
                filled = True
                break
        if not filled:
            return False
    return True


@kernel()
def _visible(
    s: Shapes, near: Near, primitive: int, place: tuple[float, float, float, float], alone: bool
) -> tuple[int, int]:
    """Return the last neighbours of a primitive that cover the places left and right of its outline, or −1.

    place : x, y on the outline, and the vector to the left;  alone: whether no other outline passes there
    """
    (x, y, to_x, to_y), left, right = place, -1, -1
    for k in range(near.begin[primitive + 1] - 1, near.begin[primitive] - 1, -1):
        j = near.other[k]
        if not _within(s.boxes[j], x, y, abs(to_x) + abs(to_y)):
            continue
        one = _covers(s, j, x + to_x, y + to_y)
        two = one if alone and j != primitive else _covers(s, j, x - to_x, y - to_y)
        left, right = int(j) if one and left < 0 else left, int(j) if two and right < 0 else right
        if left >= 0 and right >= 0:
            break
    return left, right


@kernel()
def _clipped(s: Shapes, primitive: int, place: tuple[float, float, float, float, float]) -> bool:
    """Return whether a clip removes a primitive on both sides of a place on its outline."""
    x, y, _, to_x, to_y = place
    if s.owners.layer[primitive + 1] - s.owners.layer[primitive] < 2 or _covers(s, primitive, x + to_x, y + to_y):
        return False
    return not _covers(s, primitive, x - to_x, y - to_y)


@kernel()
def _others(
    s: Shapes, touching: Near, whose: I64, e: int, place: tuple[float, float, float, float, float]
) -> tuple[int, bool, float]:
    """Return the number of other parts that coincide with part ``e`` at a place, whether to skip ``e``, and a distance.

    Part ``e`` is skipped if an earlier part represents it, or if a clip removes its primitive there. The distance is
    that below which places coincide, for the coarsest of these parts.

    place : x, y, largest distance of coincident parts, and the vector to a place beyond them
    """
    x, y, most = place[:3]
    if not _within(s.boxes[whose[e]], x, y, most) or _clipped(s, whose[e], place):
        return 0, True, s.same[e]
    count, earlier, coarsest = 0, False, s.same[e]
    for k in range(touching.begin[e], touching.begin[e + 1]):
        f = touching.other[k]
        if f == e or not _within(s.bounds[f], x, y, 0.0) or not _within(s.boxes[whose[f]], x, y, most):
            continue
        if lies_on(s.parts, f, x, y, COINCIDENT * max(s.same[e], s.same[f])):
            coarsest = max(coarsest, s.same[f])
            if whose[f] == whose[e] or not _clipped(s, whose[f], place):
                count += 1
                earlier |= f < e
    return count, earlier, coarsest


def sides_of(s: Shapes, near: Near, touching: Near, piece: tuple[I64, F64, F64], of: I64) -> tuple[I64, I64]:
    """Return the spectra to the left and right of every piece; equal where another piece represents it.

    near, touching : of primitives, and of parts
    piece : part (n,), start and end (n,);  of: (primitives,) spectrum of each
    """
    left, right = np.zeros((2, len(piece[0])), np.int64)
    whose, most = s.owners.primitive, float(s.same.max(initial=0.0))

    def work(begin: int, end: int) -> None:
        _sides_of(begin, end, s, near, touching, piece, (whose, of, most), (left, right))

    shared(len(left), work, least=PIECES_AT_ONCE)
    return left, right


@kernel()
def _sides_of(
    begin: int,
    end: int,
    s: Shapes,
    near: Near,
    touching: Near,
    piece: tuple[I64, F64, F64],
    parts: tuple[I64, I64, float],
    sides: tuple[I64, I64],
) -> None:
    """Find the spectra of pieces begin … end; parts: primitive of each, spectra of these, and the largest ``same``."""
    (owner, low, high), (whose, of, most), (left, right) = piece, parts, sides
    for p in range(begin, end):
        e = owner[p]
        same, fewest = s.same[e], 1 << 60
        # Try several places: another outline may touch the piece at one, whereas a coincident one is found at all.
        for part in (0.5, 0.382, 0.7):
            x, y, dx, dy = place_at(s.parts, e, low[p] + part * (high[p] - low[p]))
            length = math.hypot(dx, dy)
            nx, ny = -dy / length, dx / length
            place = x, y, COINCIDENT * most, WIDE_OFFSET * same * nx, WIDE_OFFSET * same * ny
            count, earlier, coarsest = _others(s, touching, whose, e, place)
            if count >= fewest:
                continue
            fewest = count
            left[p] = right[p] = 0
            offset = WIDE_OFFSET * coarsest if count else OFFSET * same
            if not earlier:
                one, two = _visible(s, near, whose[e], (x, y, offset * nx, offset * ny), count == 0)
                left[p] = of[one] if one >= 0 else 0
                right[p] = of[two] if two >= 0 else 0
            if count == 0:
                break


@kernel()
def covered(s: Shapes, at: F64, after: I64, found: np.ndarray) -> None:
    """Mark the places (n, 2) that primitives from number ``after`` (n,) on cover."""
    for k in range(len(at)):
        for j in range(after[k], len(s.boxes)):
            if _within(s.boxes[j], at[k, 0], at[k, 1], 0.0) and _covers(s, j, at[k, 0], at[k, 1]):
                found[k] = True
                break
