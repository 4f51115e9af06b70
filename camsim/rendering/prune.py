"""Edges that need not be rendered: nobody sees their contrast, or they are too far outside the window to matter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, kinds_of, same_rows
from camsim.core.kernels import kernel
from camsim.optics.pattern import Pattern
from camsim.rendering.edges import Edges
from camsim.rendering.grid import Grid


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LeftOut:
    """Edges of the scene that a job leaves out.

    sides, hidden : of each primitive before one covers another, and which lie wholly under a later one
    edges         : those with equal sides first, then those far outside
    equal, far    : how many of each;  bound: what the far ones add to any photosite, at the most, of full scale
    """

    sides: I64
    hidden: np.ndarray
    edges: Edges
    equal: int
    far: int
    bound: float

    @property
    def outline_edges(self) -> int:
        """Sides of all shapes."""
        return int(self.sides.sum())


def equal_sides(edges: Edges, density: F64) -> np.ndarray:
    """Return which edges have sides that every channel sees alike at every wavelength: they contribute nothing."""
    same = same_rows(density.reshape(len(density), -1) + 0.0)[1]
    equal: np.ndarray = same[edges.left] == same[edges.right]
    return equal


def far_outlines(
    edges: Edges,
    *,
    density: F64,
    pattern: Pattern,
    longest: float,
    extent: float,
    grid: Grid,
    allowed: float,
) -> tuple[np.ndarray, float]:
    """Return which edges to drop and a bound on what all of them together add to any photosite.

    density    : (spectra, channels, j)
    longest    : the pattern's own length at the longest wavelength;  extent: how far the footprint reaches

    Edges that hang together are the outline of something finite: a step of contrast c within an outline of diameter D
    at distance d takes no more than c·(α/2π)·(1 − E(d)) of a round pattern, E its encircled energy and α ≤ π the angle
    that it fills: 2·asin(D/2d). Where the pattern is signed, every time that a ray enters and leaves the outline
    counts, at most half as often as it has edges. The smallest are dropped first, until their sum would pass
    ``allowed``.
    """
    drop = np.zeros(len(edges), bool)
    first = np.array(grid.first_centre)
    last = first + np.array([grid.cols - 1, grid.rows - 1])
    low, high = np.minimum(edges.start, edges.end), np.maximum(edges.start, edges.end)
    within = (low <= last + extent) & (high >= first - extent)
    near = within[:, 0] & within[:, 1]
    if near.all():
        return drop, 0.0
    outline, count = joined_outlines(edges)
    # What comes near anywhere stays, and in a crowd most of it hangs together.
    stays = np.zeros(count, bool)
    stays[outline[near]] = True
    away = np.flatnonzero(~stays[outline])
    if not away.size:
        return drop, 0.0
    _, one = kinds_of(outline[away])
    bound = _bounds(edges.some(away), one, density, pattern, longest, (first - extent, last + extent))
    order = np.argsort(bound, kind="stable")
    total = np.cumsum(bound[order])
    smallest = np.zeros(bound.size, bool)
    smallest[order[total <= allowed]] = True
    drop[away] = smallest[one]
    return drop, float(total[np.count_nonzero(smallest) - 1]) if smallest.any() else 0.0


def _bounds(edges: Edges, outline: I64, density: F64, pattern: Pattern, longest: float, frame: tuple[F64, F64]) -> F64:
    """Return a bound on what each outline adds to any photosite; ``frame``: its corners, widened by the footprint."""
    count, of_point, points = int(outline.max()) + 1, np.tile(outline, 2), edges.points
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, of_point, points)
    np.maximum.at(high, of_point, points)
    gap = np.maximum(np.maximum(frame[0] - high, low - frame[1]), 0.0)
    distance = np.hypot(gap[:, 0], gap[:, 1])
    radius = 0.5 * np.hypot(*(high - low).T)
    angle = 2.0 * np.arcsin(radius / np.maximum(distance, radius))
    lost = np.where(distance > 0.0, pattern.beyond(distance / longest), 1.0)
    if pattern.signed:
        lost = lost * np.maximum(0.5 * np.bincount(outline, minlength=count), 1.0)
    # A side's contrast to the outside is no more than the sum over the kinds of edges that lie between.
    sides, pair = edges.pairs()
    one, kind = np.divmod(np.unique(outline * len(sides) + pair), len(sides))
    step = np.abs(density[sides[:, 0]] - density[sides[:, 1]]).sum(axis=2).max(axis=1)
    contrast = np.bincount(one, weights=step[kind], minlength=count)
    bound: F64 = contrast * angle / (2.0 * np.pi) * lost
    return bound


def joined_outlines(edges: Edges) -> tuple[I64, int]:
    """Return the number of the outline that each edge belongs to: edges that share an end belong together."""
    points, begins, ends = edges.corners
    label = np.empty(len(points), np.int64)
    count = _label(begins, ends, label)
    return label[begins], count


@kernel(allocates=True)
def _label(begins: I64, ends: I64, label: I64) -> int:
    """Write the outline that each point belongs to, by the edges between points; return how many there are."""
    points = len(label)
    parent = np.arange(points)  # of each point an earlier one that it hangs together with, or itself
    for e in range(len(begins)):
        a, b = begins[e], ends[e]
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        while parent[b] != b:
            parent[b] = parent[parent[b]]
            b = parent[b]
        parent[max(a, b)] = min(a, b)
    count = 0
    for point in range(points):
        if parent[point] == point:
            label[point] = count
            count += 1
        else:
            label[point] = label[parent[point]]
    return count
