"""Where an outline's rings meet: a round outline is everywhere equally far from its centre, and its rings add up there.

A pattern oscillates as b/ρ^m about its smooth powers of 1/ρ (of an Airy pattern b = 1/π³, m = 2). A corner, or a line,
leaves a share of that which falls by another √ρ, since the phase runs away along an edge; along a circle about the
photosite it does not, and an arc that fills the angle α leaves α/2π of it whole. So do the sides of a polygon that all
touch one circle, each over the length √(λN·R) along which its phase stands still.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.edges import Edges
from camsim.rendering.grid import Grid

NEARLY_PARALLEL = 1e-11  # sine of the angle between two edges that touch no circle together
MOST_PAIRS = 1e7  # of circles and edges: of more, circles that are alike are one, and edges are looked for nearby
LONG = 0.5  # radii of half an edge that is looked at from everywhere
SAME = 0.05  # radii by which foci differ that are taken for one: a quarter of their zones
ZONE = 0.2  # radii about the centre, in which the arc's far side is heard more than a line is: (1 + ζ)^{−5/2}/√ζ of it


class Foci(NamedTuple):
    """Circles that edges touch: centres (n, 2) and radii (n,), pitches, and the share (n,) of a turn that they fill."""

    centre: F64
    radius: F64
    share: F64

    def some(self, which: np.ndarray) -> Foci:
        """Return those of them that ``which`` (n,) picks."""
        return Foci(self.centre[which], self.radius[which], self.share[which])


NO_FOCI = Foci(np.empty((0, 2)), np.empty(0), np.empty(0))


def circles(edges: Edges, *, grid: Grid, nearest: float) -> tuple[F64, F64]:
    """Return centres (n, 2) and radii (n,) of the circles of radius ``nearest`` or more that edges touch in a row.

    edges : in chains; of the circles those whose centre the grid sees

    Every three edges in a row touch one circle. Where the direction turns by α and β at the middle one's ends, its
    length is ρ·(tan α/2 + tan β/2). Of a round outline each of them brings it up again.
    """
    first, middle, last = threes(edges)
    normal, length = _normals(edges)
    alpha, beta = _half_tangent(normal[first], normal[middle]), _half_tangent(normal[middle], normal[last])
    turns = np.minimum(np.abs(alpha), np.abs(beta)) > 0.5 * NEARLY_PARALLEL
    both = alpha + beta
    regular = turns & (np.abs(both) > NEARLY_PARALLEL)
    middle, alpha, both = middle[regular], alpha[regular], both[regular]
    signed = length[middle] / both
    seen = np.abs(signed) >= nearest
    middle, alpha, signed = middle[seen], alpha[seen], signed[seen]
    n = normal[middle]
    along = np.stack([n[:, 1], -n[:, 0]], axis=1)
    centre = edges.start[middle] + signed[:, None] * (n + alpha[:, None] * along)
    radius = np.abs(signed)
    seen = _outside(centre, grid) <= ZONE * radius
    return centre[seen], radius[seen]


def _half_tangent(before: F64, after: F64) -> F64:
    """Return the tangents (n,) of half the angles by which normals turn from one edge to the next."""
    sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    cosine = np.sum(before * after, axis=1)
    tangent: F64 = sine / np.maximum(1.0 + cosine, np.finfo(float).tiny)
    return tangent


def foci(centre: F64, radius: F64, edges: Edges, blur: float) -> Foci:
    """Return circles with the shares of a turn that edges fill; ``blur``: the pattern's shortest length, pitches."""
    if radius.size * len(edges) > MOST_PAIRS:
        # A smooth outline's circles are alike, and one of each kind does: none is left out.
        step = 0.25 * SAME * np.exp2(np.floor(np.log2(radius)))
        kind = np.floor(np.column_stack([centre, radius]) / step[:, None])
        some = np.sort(np.unique(np.column_stack([kind, step]), axis=0, return_index=True)[1])
        centre, radius = centre[some], radius[some]
    return Foci(centre, radius, _shares(centre, radius, edges, blur))


def distinct(found: Foci) -> Foci:
    """Return the strongest of the foci that have much of their zones in common."""
    left = np.argsort(-found.share, kind="stable")
    kept = []
    while left.size:
        best = left[0]
        kept.append(best)
        apart = np.abs(found.centre[left] - found.centre[best]).max(axis=1)
        apart = np.maximum(apart, np.abs(found.radius[left] - found.radius[best]))
        left = left[apart > SAME * found.radius[best]]
    return found.some(np.array(kept, np.int64))


def touching(found: Foci, edges: Edges) -> tuple[I64, I64]:
    """Return the edges of each focus: where each one's begin (n + 1,), and they, focus by focus, some of several."""
    start, (normal, length) = edges.start, _normals(edges)
    along = (edges.end - start) / length[:, None]
    picked, first = [], [0]
    # What is 1.1 radii across, and a tenth of one beyond an edge's end, lies within 1.2 radii of the edge.
    for centre, radius, here in _about(found.centre, found.radius, 1.2 * found.radius, edges):
        gap = np.sum(normal[here] * (centre - start[here]), axis=1)
        foot = np.sum(along[here] * (centre - start[here]), axis=1)
        beside = np.maximum(-foot, foot - length[here]) <= 2.0 * SAME * radius
        picked.append(here[beside & (np.abs(np.abs(gap) - radius) <= 2.0 * SAME * radius)])
        first.append(first[-1] + picked[-1].size)
    return np.array(first), np.concatenate([*picked, np.empty(0, np.int64)])


def _normals(edges: Edges) -> tuple[F64, F64]:
    """Return unit normals (n, 2) and lengths (n,)."""
    along, length = edges.end - edges.start, edges.length
    return np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None], length


def threes(edges: Edges) -> tuple[I64, I64, I64]:
    """Return edges (n,) that follow one another, by threes."""
    points, begins, ends = edges.corners
    leaves = np.full(len(points), -1)
    arrives = np.full(len(points), -1)
    leaves[begins], arrives[ends] = np.arange(len(edges)), np.arange(len(edges))
    before, after = arrives[begins], leaves[ends]
    middle = np.flatnonzero((before >= 0) & (after >= 0))
    return before[middle], middle, after[middle]


def _outside(points: F64, grid: Grid) -> F64:
    """Return how far points (n, 2) lie outside the grid's outermost photosites."""
    low = np.array(grid.first_centre)
    high = low + np.array([grid.cols - 1, grid.rows - 1])
    gap = np.maximum(np.maximum(low - points, points - high), 0.0)
    distance: F64 = np.hypot(gap[:, 0], gap[:, 1])
    return distance


def _shares(centre: F64, radius: F64, edges: Edges, blur: float) -> F64:
    """Return the share of a turn that those edges fill which are a radius from a centre, but for a quarter wave."""
    start, length = edges.start, edges.length
    along = (edges.end - start) / length[:, None]
    shares = []
    for c, r, here in _about(centre, radius, radius + 0.25 * blur, edges):
        foot = np.clip(np.sum(along[here] * (c - start[here]), axis=1), 0.0, length[here])
        distance = np.hypot(*(start[here] + foot[:, None] * along[here] - c).T)
        in_step = here[np.abs(distance - r) <= 0.25 * blur]
        shares.append(float(np.minimum(length[in_step], math.sqrt(blur * r)).sum()) / r / (2.0 * math.pi))
    return np.minimum(shares, 1.0)


def _about(centre: F64, radius: F64, reach: F64, edges: Edges) -> Iterator[tuple[F64, float, I64]]:
    """Yield circles, each with the edges (in their order) that may come as near to its centre as a reach."""
    every = np.arange(len(edges))
    if radius.size * len(edges) <= MOST_PAIRS:
        yield from ((c, r, every) for c, r in zip(centre, radius.tolist(), strict=True))
        return
    from scipy.spatial import cKDTree  # crowds of outlines alone need it

    middle, half = 0.5 * (edges.start + edges.end), 0.5 * edges.length
    short = half <= LONG * float(radius.min())
    shorts = every[short]
    tree, long, longest = cKDTree(middle[short]), every[~short], float(half[short].max(initial=0.0))
    for c, r, within in zip(centre, radius.tolist(), (reach + longest).tolist(), strict=True):
        yield c, r, np.sort(np.concatenate([shorts[tree.query_ball_point(c, within)], long]))
