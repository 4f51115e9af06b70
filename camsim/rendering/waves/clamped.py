"""Edges clamped to a box: parts outside it are replaced by the pieces of its sides that close the outlines."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel
from camsim.rendering.edges import Edges

ROOM = 1000  # initial allocation for pieces in a box, plus one for every eight edges of the scene

ROUNDING = 1e-15  # of the largest jump: smaller steps are rounding
SAME = 1e-12  # of the farthest corner, or pitches: places along the sides this close are equal. Where two arcs meet,
# their last bits differ, which would leave thousands of tiny pieces along the sides


def clamped(
    edges: Edges, low: tuple[float, float], high: tuple[float, float], origin: tuple[float, float] = (0.0, 0.0)
) -> Edges:
    """Clamp every point to a box, with edges cut where they cross its sides; coordinates are relative to an origin.

    A closed outline clamped axis by axis is the outline of its intersection with the box: pieces along the sides cancel
    or close it. Successive pieces along a side with the same spectra on both sides are merged. A box without area
    yields no edges: it occurs when the whole scene lies beyond the support along one axis.

    >>> a = np.array([[-1.0, 0.0], [3.0, 0.0], [0.0, 2.0]])  # a triangle that sticks out to the right and the left
    >>> b = np.roll(a, -1, axis=0)
    >>> inside = clamped(Edges(start=a, end=b, left=np.array([1, 2, 3]), right=np.zeros(3, int)), (0, 0), (1, 2))
    >>> (x0, y0), (x1, y1) = inside.start.T, inside.end.T
    >>> float(0.5 * np.sum(x0 * y1 - x1 * y0))  # the trapezium within
    1.6666666666666665
    >>> sorted(inside.left.tolist())  # the second runs down to the right side and along it
    [1, 2, 2, 3]
    """
    if low[0] >= high[0] or low[1] >= high[1]:
        return edges.some(np.empty(0, np.int64))
    box, room = np.array([*low, *high], float), ROOM + len(edges) // 8
    while True:
        ends, of = np.empty((room, 4)), np.empty(room, np.int64)
        count, most = _clamp(edges.start, edges.end, edges.left, edges.right, origin, box, ends, of)
        if most <= room:
            break
        room = most
    of = of[:count]
    return Edges(
        start=np.ascontiguousarray(ends[:count, :2]),
        end=np.ascontiguousarray(ends[:count, 2:]),
        left=edges.left[of],
        right=edges.right[of],
    )


@kernel()
def _side(x0: float, y0: float, x1: float, y1: float, box: F64) -> int:
    """Return the side of the box that a piece lies along, or -1."""
    if x0 == x1 and (x0 == box[0] or x0 == box[2]):
        return 0 if x0 == box[0] else 2
    if y0 == y1 and (y0 == box[1] or y0 == box[3]):
        return 1 if y0 == box[1] else 3
    return -1


@kernel()
def _mark_apart(start: F64, end: F64, box: F64, apart: np.ndarray) -> None:
    """Mark the edges that lie along no side of the box."""
    for e in range(len(start)):
        apart[e] = _side(start[e, 0], start[e, 1], end[e, 0], end[e, 1], box) < 0


@kernel(allocates=True)
def _clamp(
    start: F64, end: F64, left: I64, right: I64, origin: tuple[float, float], box: F64, ends: F64, of: I64
) -> tuple[int, int]:
    """Write pieces (n, 4) and the edges they belong to, up to the arrays' size; return their number and its maximum.

    box : (4,) low x and y, high x and y
    """
    count, most, last = 0, 0, -1  # the side that the last piece lies along
    x, y = np.empty(6), np.empty(6)
    share = np.empty(4)
    for e in range(len(start)):
        ax, ay = start[e, 0] - origin[0], start[e, 1] - origin[1]
        bx, by = end[e, 0] - origin[0], end[e, 1] - origin[1]
        corners = 0
        x[0], y[0] = ax, ay
        # An edge that lies beyond one side becomes a single piece of that side.
        beyond = max(ax, bx) <= box[0] or min(ax, bx) >= box[2] or max(ay, by) <= box[1] or min(ay, by) >= box[3]
        if not beyond:
            for axis in range(4):
                a = (ax if axis % 2 == 0 else ay) - box[axis]
                b = (bx if axis % 2 == 0 else by) - box[axis]
                if (a > 0.0) != (b > 0.0):
                    t = a / (a - b)
                    place = corners
                    while place > 0 and share[place - 1] > t:
                        share[place] = share[place - 1]
                        x[place + 1], y[place + 1] = x[place], y[place]
                        place -= 1
                    share[place] = t
                    x[place + 1] = box[axis] if axis % 2 == 0 else ax + t * (bx - ax)
                    y[place + 1] = box[axis] if axis % 2 == 1 else ay + t * (by - ay)
                    corners += 1
        x[corners + 1], y[corners + 1] = bx, by
        for k in range(corners + 2):
            x[k], y[k] = min(max(x[k], box[0]), box[2]), min(max(y[k], box[1]), box[3])
        for k in range(corners + 1):
            if x[k] == x[k + 1] and y[k] == y[k + 1]:
                continue
            side = _side(x[k], y[k], x[k + 1], y[k + 1], box)
            if side >= 0 and side == last and count <= len(of):
                before, one = ends[count - 1], of[count - 1]
                if before[2] == x[k] and before[3] == y[k] and left[one] == left[e] and right[one] == right[e]:
                    before[2], before[3] = x[k + 1], y[k + 1]
                    if before[0] == before[2] and before[1] == before[3]:
                        count, last = count - 1, -1
                    continue
            if count < len(of):
                ends[count, 0], ends[count, 1], ends[count, 2], ends[count, 3] = x[k], y[k], x[k + 1], y[k + 1]
                of[count] = e
            count, last = count + 1, side
            most = max(most, count)
    return count, most


def netted(
    start: F64, end: F64, jump: F64, low: tuple[float, float], high: tuple[float, float]
) -> tuple[F64, F64, F64]:
    """Return edges with overlapping pieces along the sides of their box combined into their net jumps.

    jump : (n, spectra) excess of each spectrum on an edge's left over its right

    Many edges leave thousands of overlapping pieces, whose quadrature nodes would be wasted: only the net jump along
    the side matters.

    >>> a, b = np.array([[0.0, 0.0], [0.0, 2.0], [0.0, 3.0]]), np.array([[0.0, 2.0], [0.0, 1.0], [1.0, 3.0]])
    >>> start, end, jump = netted(a, b, np.ones((3, 1)), (0.0, 0.0), (5.0, 5.0))
    >>> [(p.tolist(), q.tolist(), float(j)) for p, q, j in zip(start, end, jump[:, 0])]
    [([0.0, 3.0], [1.0, 3.0], 1.0), ([0.0, 0.0], [0.0, 1.0], 1.0)]
    """
    least = ROUNDING * float(np.abs(jump).max(initial=0.0))
    same = SAME * max(1.0, float(np.abs([low, high]).max()))
    apart = np.empty(len(start), bool)
    _mark_apart(start, end, np.array([*low, *high], float), apart)
    if apart.all():
        return start, end, jump
    starts, ends, jumps = [start[apart]], [end[apart]], [jump[apart]]
    start, end, jump = start[~apart], end[~apart], jump[~apart]
    for axis in (0, 1):
        for bound in (low[axis], high[axis]):
            along = (start[:, axis] == bound) & (end[:, axis] == bound)
            places = np.concatenate([start[along, 1 - axis], end[along, 1 - axis]])
            order = np.argsort(places, kind="stable")
            places = places[order]
            steps = np.concatenate([jump[along], -jump[along]])[order]
            first = np.flatnonzero(np.diff(places, prepend=-np.inf) > same)
            step = np.add.reduceat(steps, first) if first.size else steps
            changes = np.flatnonzero(np.abs(step).max(axis=1, initial=0.0) > least)
            net = np.cumsum(step, axis=0)[changes][:-1]
            places = places[first[changes]]
            some = np.abs(net).max(axis=1, initial=0.0) > least * len(steps)
            pieces = np.full((2, np.count_nonzero(some), 2), bound)
            pieces[0, :, 1 - axis], pieces[1, :, 1 - axis] = places[:-1][some], places[1:][some]
            starts, ends, jumps = [*starts, pieces[0]], [*ends, pieces[1]], [*jumps, net[some]]
    return np.concatenate(starts), np.concatenate(ends), np.concatenate(jumps)
