"""Where an outline's rings meet: a round outline is everywhere equally far from its centre, and its rings add up there.

A pattern oscillates as b/ρ^m about its smooth powers of 1/ρ (of an Airy pattern b = 1/π³, m = 2). A corner, or a line,
leaves a share of that which falls by another √ρ, since the phase runs away along an edge; along a circle about the
photosite it does not, and an arc that fills the angle α leaves α/2π of it whole. So do the sides of a polygon that all
touch one circle, each over the length √(λN·R) along which its phase stands still.
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
ROW, OCTAVE = 1 << 28, 1 << 56  # cells that a row may have, and an octave: a cell's number counts row after row
SAME = 0.05  # radii by which foci differ that are taken for one: a quarter of their zones
ZONE = 0.2  # radii about the centre, in which the arc's far side is heard more than a line is: (1 + ζ)^{−5/2}/√ζ of it


class Foci(NamedTuple):
    """Circles that edges touch: centres (n, 2) and radii (n,), pitches, and the share (n,) of a turn that they fill, as
    loud as it is where the footprint passes most."""

    centre: F64
    radius: F64
    share: F64

    def some(self, which: np.ndarray) -> Foci:
        """Return those of them that ``which`` (n,) picks."""
        return Foci(self.centre[which], self.radius[which], self.share[which])


NO_FOCI = Foci(np.empty((0, 2)), np.empty(0), np.empty(0))


def foci(centre: F64, radius: F64, edges: Edges, blur: float, passed: F64) -> Foci:
    """Return circles with the shares of a turn that edges fill.

    blur   : the pattern's shortest length, pitches
    passed : (edges,) how loud each one's rings are, as a share of the loudest direction's: it fills no more than that
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
    """Fill in the share of a turn that those edges fill which are a radius from a centre, but for a quarter wave."""
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
    """Return the strongest of the foci that have much of their zones in common."""
    if not found.radius.size:
        return found
    # A focus has others in common with it that are no farther than a cell of its octave's, or of the next one's.
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
    """Write those that no stronger one has in common with it; return how many.

    low : of cells along x, along y, and of octaves;  keys, by_key: sorted, and whose they are
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
    """Return the edges of each focus: where each one's begin (n + 1,), and they, focus by focus, some of several."""
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
    """Return the edges of some foci, and count each one's."""
    picked, until = np.empty(256, np.int64), 0
    for k in range(begin, end):
        (x, y), r, before = centre[k], radius[k], until
        slack = 2.0 * SAME * r
        # What is 1.1 radii across, and a tenth of one beyond an edge's end, lies within 1.2 radii of the edge.
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
    """Return unit normals (n, 2)."""
    return np.stack([-edges.along[:, 1], edges.along[:, 0]], axis=1)
