"""Nodes over what outlines leave of a patch, line by line: between crossings there is picture, then there is none."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import legvander

from camsim.arrays import F64, I64
from camsim.quadrature import gauss_legendre

NEXT_TO = 1e-9  # of a patch: an outline this near to a side may be on it
ENOUGH = 4.0  # times as many nodes as hold the same light, from which they are gathered
AT_ONCE = 1 << 16  # of them


def crossing(a: F64, b: F64, y: float | F64) -> F64:
    """Return where lines through a and b cross a horizontal, or each its own."""
    along = b[:, 1] - a[:, 1]
    x: F64 = a[:, 0] + (y - a[:, 1]) / np.where(along == 0.0, 1.0, along) * (b[:, 0] - a[:, 0])
    return x


def _nodes_for(order: int, length: F64) -> I64:
    """Return how many nodes take a way across a patch as well as ``order`` nodes take its side."""
    count: I64 = np.ceil(order * length).astype(np.int64) + np.where(length < 1.0, 3, 0)
    return count


def in_patch(a: F64, b: F64, order: int) -> tuple[F64, F64]:
    """Return nodes (m, 2) and weights over what lies within outlines, a to b, of the square 0 … 1."""
    a, b = _beside(a, b)
    # Between these heights the crossings with the sides and with one another come in one order.
    safe = np.where(a[:, 0] == b[:, 0], 1.0, b[:, 0] - a[:, 0])
    heights = [a[:, 1], b[:, 1]]
    for side in (0.0, 1.0):
        part = (side - a[:, 0]) / safe
        heights.append((a[:, 1] + part * (b[:, 1] - a[:, 1]))[(part > 0.0) & (part < 1.0)])
    breaks = np.unique(np.concatenate([[0.0, 1.0], *heights]))
    breaks = breaks[(breaks >= 0.0) & (breaks <= 1.0)]
    wide = np.diff(breaks) >= NEXT_TO**2
    top, bottom = breaks[:-1][wide], breaks[1:][wide]
    # Every outline with every band that it crosses, in order from the left.
    middle = 0.5 * (top + bottom)
    begin, end = (np.searchsorted(middle, pick(a[:, 1], b[:, 1])) for pick in (np.minimum, np.maximum))
    owner = np.repeat(np.arange(len(a)), end - begin)
    band = np.arange(owner.size) + np.repeat(begin - np.cumsum(end - begin) + (end - begin), end - begin)
    sort = np.lexsort((crossing(a[owner], b[owner], middle[band]), band))
    owner, band = owner[sort], band[sort]
    over, under = (np.clip(crossing(a[owner], b[owner], y[band]), 0.0, 1.0) for y in (top, bottom))
    # From the top to the bottom nodes slide along with the outline: that is the way over which the light changes.
    slide = np.zeros(top.size)
    np.maximum.at(slide, band, np.abs(under - over))
    # There is picture between the first and the second, the third and the fourth …
    rank = np.arange(band.size) - np.searchsorted(band, band)
    left = np.flatnonzero((rank[:-1] % 2 == 0) & (band[1:] == band[:-1]))
    longest = np.maximum(over[left + 1] - over[left], under[left + 1] - under[left])
    left, longest = left[longest > 0.0], longest[longest > 0.0]
    down = _nodes_for(order, np.hypot(bottom - top, slide))[band[left]]
    across = _nodes_for(order, longest)
    places, weights = [np.empty((0, 2))], [np.empty(0)]
    for rows, cols in np.unique(np.stack([down, across], axis=1), axis=0).tolist():
        some = left[(down == rows) & (across == cols)]
        (ty, wy), (tx, wx) = (_rule(count) for count in (rows, cols))
        low, high = top[band[some], None], bottom[band[some], None]
        begins, ends = (over[k, None] + ty * (under[k, None] - over[k, None]) for k in (some, some + 1))
        length = ends - begins
        x = begins[..., None] + length[..., None] * tx
        y = np.broadcast_to((low + ty * (high - low))[..., None], x.shape)
        places.append(np.stack([x, y], axis=-1).reshape(-1, 2))
        weights.append((((high - low) * wy * length)[..., None] * wx).ravel())
    return np.concatenate(places), np.concatenate(weights)


def gathered_from(order: int) -> float:
    """Return the number of nodes from which ``gathered`` makes them fewer."""
    return ENOUGH * (2 * order) ** 2


def count_gathered(count: int, order: int) -> float:
    """Return about how many nodes ``gathered`` leaves of so many."""
    most = gathered_from(order)
    return count if count <= most else most / ENOUGH


def gathered(nodes: F64, light: F64, order: int) -> tuple[F64, F64]:
    """Return fewer nodes (m, 2) on the square 0 … 1 with light (planes, m) that does the same, or those given.

    An outline of thousands of sides has that many bands. What the light (planes, n) at nodes is summed against is as
    smooth as Gauss rules of an order follow, and so the polynomial through twice as many places along either side: its
    Legendre coefficients are the places' sums, whose weights are the light's own moments.
    """
    if len(nodes) <= gathered_from(order):
        return nodes, light
    degree = 2 * order - 1
    moments = np.zeros((len(light), degree + 1, degree + 1))
    for first in range(0, len(nodes), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        along, down = (legvander(2.0 * nodes[some, axis] - 1.0, degree) for axis in (0, 1))
        for plane, own in zip(moments, light[:, some], strict=True):
            plane += (along * own[:, None]).T @ down
    x, w = _rule(2 * order)
    series = legvander(2.0 * x - 1.0, degree) * (2.0 * np.arange(degree + 1) + 1.0) * w[:, None]
    weights = np.einsum("ia,pab,jb->pij", series, moments, series, optimize=True)
    return np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2), weights.reshape(len(light), -1)


def _beside(a: F64, b: F64) -> tuple[F64, F64]:
    """Return outlines of which what lies wholly on one side of the patch is upright there.

    Only how often a line crosses it counts, evenly or oddly: where one outline of a chain goes on for another nothing
    ends.
    """
    left, right = np.maximum(a[:, 0], b[:, 0]) <= 0.0, np.minimum(a[:, 0], b[:, 0]) >= 1.0
    starts, ends = [a[~left & ~right]], [b[~left & ~right]]
    for there, x in ((left, 0.0), (right, 1.0)):
        height, times = np.unique(np.clip(np.concatenate([a[there, 1], b[there, 1]]), 0.0, 1.0), return_counts=True)
        turns = height[times % 2 == 1].reshape(-1, 2)
        for own, y in ((starts, turns[:, 0]), (ends, turns[:, 1])):
            own.append(np.stack([np.full(len(turns), x), y], axis=1))
    return np.concatenate(starts), np.concatenate(ends)


def _rule(count: int) -> tuple[F64, F64]:
    """Return Gauss's rule on 0 … 1."""
    x, w = gauss_legendre(count)
    return 0.5 * (1.0 + x), 0.5 * w
