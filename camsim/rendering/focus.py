"""Foci of ringing: all of a round outline is at one distance from its centre, where its ringing adds up in phase.

A PSF oscillates as b/ρ^m about its smooth powers of 1/ρ (Airy: b = 1/π³, m = 2). A corner or a line contributes only a
part of that, which falls by another √ρ, since the phase varies along an edge. Along a circle about the photosite it
does not vary, and an arc of angle α contributes α/2π of the full amplitude. The same holds for the sides of a polygon
tangent to one circle, each over the length √(λN·R) of stationary phase.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel, shared
from camsim.rendering.edge_boxes import GROUP, EdgeBoxes, groups_about
from camsim.rendering.edges import Edges

CIRCLES_AT_ONCE = 16
ROW, OCTAVE = 1 << 28, 1 << 56  # cells per row and per octave: a cell's number counts row after row
SAME = 0.05  # radii within which foci count as one: a quarter of their zones
ZONE = 0.2  # radius of the zone, over the circle's, where an arc's far side exceeds a line: (1 + ζ)^{−5/2}/√ζ of it


class Foci(NamedTuple):
    """Circles tangent to edges: centres (n, 2) and radii (n,), pitches, and the shares (n,) of a turn that edges fill.

    A share is weighted by the ringing that the footprint passes, relative to the strongest direction.
    """

    centre: F64
    radius: F64
    share: F64

    def some(self, which: np.ndarray) -> Foci:
        """Return the circles that ``which`` selects."""
        return Foci(self.centre[which], self.radius[which], self.share[which])


NO_FOCI = Foci(np.empty((0, 2)), np.empty(0), np.empty(0))


def foci(centre: F64, radius: F64, edges: Edges, blur: float, passed: F64) -> Foci:
    """Return circles with the shares of a turn that edges fill.

    blur   : the shortest λN, pitches
    passed : (edges,) amplitude of each edge's ringing relative to the strongest direction, which bounds its share
    """
    shares, tree = np.zeros(radius.size), edges.boxes

    def work(begin: int, end: int) -> None:
        _shares(begin, end, centre, radius, tree, blur, passed, np.empty(len(tree.group), np.int64), shares)

    shared(radius.size, work, least=CIRCLES_AT_ONCE)
    return Foci(centre, radius, shares)


@kernel()
def _shares(
    begin: int,
    end: int,
    centre: F64,
    radius: F64,
    tree: EdgeBoxes,
    blur: float,
    passed: F64,
    found: I64,
    shares: F64,
) -> None:
    """Set the share of a turn of the edges whose distance from a centre is the radius, to within a quarter wave."""
    for k in range(begin, end):
        (x, y), r, filled = centre[k], radius[k], 0.0
        off = 0.25 * blur
        for g in found[: groups_about(tree, x, y, r - off, r + off, found)]:
            for e in range(GROUP * g, min(GROUP * (g + 1), tree.length.size)):
                dx, dy = tree.start[e, 0] - x, tree.start[e, 1] - y
                tx, ty, length = tree.along[e, 0], tree.along[e, 1], tree.length[e]
                foot = min(max(-(tx * dx + ty * dy), 0.0), length)
                if abs(math.hypot(dx + foot * tx, dy + foot * ty) - r) <= off:
                    filled += passed[e] * min(length, math.sqrt(blur * r))
        shares[k] = min(filled / r / (2.0 * math.pi), 1.0)


def distinct(found: Foci) -> Foci:
    """Return the foci without those whose zones mostly overlap that of a stronger one."""
    if not found.radius.size:
        return found
    # Overlapping foci lie within one cell of the focus's octave or of a neighbouring one.
    octave = np.frexp(found.radius)[1].astype(np.int64)
    cell = np.floor(found.centre / np.ldexp(SAME, octave)[:, None]).astype(np.int64)
    low = np.append(cell.min(axis=0), octave.min())
    key = (octave - low[2]) * OCTAVE + (cell[:, 1] - low[1]) * ROW + cell[:, 0] - low[0]
    by_key = np.argsort(key, kind="stable")
    strongest = np.argsort(-found.share, kind="stable")
    kept = np.empty(strongest.size, np.int64)
    count = _distinct(found.centre, found.radius, strongest, low, key[by_key], by_key, kept)
    return found.some(kept[:count])


@kernel(allocates=True)
def _distinct(centre: F64, radius: F64, strongest: I64, low: I64, keys: I64, by_key: I64, kept: I64) -> int:
    """Write the foci that overlap no stronger one; return how many.

    low : lowest cell along x, along y, and lowest octave;  keys, by_key: sorted keys, and their foci
    """
    gone, count = np.zeros(radius.size, np.bool_), 0
    for best in strongest:
        if gone[best]:
            continue
        kept[count] = best
        count += 1
        (x, y), r = centre[best], radius[best]
        reach = SAME * r
        for octave in range(math.frexp(r - reach)[1], math.frexp(r + reach)[1] + 1):
            size = math.ldexp(SAME, octave)
            first, last = math.floor((x - reach) / size) - low[0], math.floor((x + reach) / size) - low[0]
            for row in range(math.floor((y - reach) / size), math.floor((y + reach) / size) + 1):
                if octave < low[2] or row < low[1] or last < 0:
                    continue
                in_row = (octave - low[2]) * OCTAVE + (row - low[1]) * ROW
                k = np.searchsorted(keys, in_row + max(first, 0))
                while k < keys.size and keys[k] <= in_row + last:
                    other = by_key[k]
                    k += 1
                    apart = max(abs(centre[other, 0] - x), abs(centre[other, 1] - y), abs(radius[other] - r))
                    if apart <= reach:
                        gone[other] = True
    return count


def touching(found: Foci, edges: Edges) -> tuple[I64, I64]:
    """Return the edges of each focus: offsets (n + 1,) and edges, which may belong to several foci."""
    if not len(edges) or not found.radius.size:
        return np.zeros(1 + found.radius.size, np.int64), np.empty(0, np.int64)
    counts, tree = np.zeros(found.radius.size, np.int64), edges.boxes
    blocks: dict[int, I64] = {}

    def work(begin: int, end: int) -> None:
        memory = np.empty(len(tree.group), np.int64)
        blocks[begin] = _touching(begin, end, found.centre, found.radius, tree, memory, counts)

    shared(counts.size, work, least=CIRCLES_AT_ONCE)
    picked = np.concatenate([blocks[begin] for begin in sorted(blocks)])
    return np.concatenate([[0], np.cumsum(counts)]), picked


@kernel(allocates=True)
def _touching(begin: int, end: int, centre: F64, radius: F64, tree: EdgeBoxes, found: I64, counts: I64) -> I64:
    """Return the edges of foci begin … end, and set the number of each."""
    picked, until = np.empty(256, np.int64), 0
    for k in range(begin, end):
        (x, y), r, before = centre[k], radius[k], until
        slack = 2.0 * SAME * r
        # An edge whose line is up to 1.1 radii away, and which ends up to 0.1 radii short, lies within 1.2 radii.
        for g in found[: groups_about(tree, x, y, r - slack, r + 2.0 * slack, found)]:
            if until + GROUP > picked.size:
                more = np.empty(2 * picked.size, np.int64)
                more[:until] = picked[:until]
                picked = more
            for e in range(GROUP * g, min(GROUP * (g + 1), tree.length.size)):
                dx, dy = tree.start[e, 0] - x, tree.start[e, 1] - y
                tx, ty, length = tree.along[e, 0], tree.along[e, 1], tree.length[e]
                gap, foot = abs(dx * ty - dy * tx), -(tx * dx + ty * dy)
                if abs(gap - r) <= slack and max(-foot, foot - length) <= slack:
                    picked[until] = e
                    until += 1
        counts[k] = until - before
    return picked[:until].copy()


def normals(edges: Edges) -> F64:
    """Return the unit normals (n, 2) to the left of edges."""
    return np.stack([-edges.along[:, 1], edges.along[:, 0]], axis=1)
