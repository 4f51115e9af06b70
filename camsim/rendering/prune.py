"""Edges that need not be rendered: without contrast in any channel, or too far outside the window to matter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, distinct, kinds_of, same_rows
from camsim.core.kernels import kernel
from camsim.optics.pattern import Pattern
from camsim.rendering.edges import Edges
from camsim.rendering.grid import Grid


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LeftOut:
    """Edges of the scene that a job leaves out.

    sides, hidden : number of sides of each primitive before covering, and mask of those entirely under a later one
    edges         : those with equal sides first, then those far outside
    equal, far    : numbers of these two kinds
    bound         : bound of what all those far outside add at any photosite, relative to full scale
    """

    sides: I64
    hidden: np.ndarray
    edges: Edges
    equal: int
    far: int
    bound: float

    @property
    def outline_edges(self) -> int:
        """Number of sides of all shapes."""
        return int(self.sides.sum())


def equal_sides(edges: Edges, density: F64) -> np.ndarray:
    """Return a mask of the edges with equal signals on both sides in every channel and wavelength."""
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
    """Return a mask of the edges to drop, and a bound of what they would add up to at any photosite.

    density    : (spectra, channels, j)
    longest    : λN at the longest wavelength, pitches;  extent: that of the footprint, pitches

    Connected edges are the outline of a bounded region. A step of contrast c within an outline of diameter D at
    distance d receives at most c·(α/2π)·(1 − E(d)) of a rotationally symmetric PSF, with E its encircled energy and
    α ≤ π the angle that it subtends, 2·asin(D/2d). If the PSF is signed, every passage of a ray through the outline
    counts, at most half the number of its edges. The smallest bounds are dropped first, until their sum would exceed
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
    # An outline that comes near anywhere stays; in a dense scene most edges are connected.
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
    """Return bounds (outlines,) of their light at any photosite; ``frame``: its corners, widened by the footprint."""
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
    one, kind = np.divmod(distinct(outline * len(sides) + pair), len(sides))
    step = np.abs(density[sides[:, 0]] - density[sides[:, 1]]).sum(axis=2).max(axis=1)
    contrast = np.bincount(one, weights=step[kind], minlength=count)
    bound: F64 = contrast * angle / (2.0 * np.pi) * lost
    return bound


def joined_outlines(edges: Edges) -> tuple[I64, int]:
    """Return the outline (n,) of each edge and the number of outlines; edges that share an end are connected."""
    points, begins, ends = edges.corners
    label = np.empty(len(points), np.int64)
    count = _label(begins, ends, label)
    return label[begins], count


@kernel(allocates=True)
def _label(begins: I64, ends: I64, label: I64) -> int:
    """Write the connected component of each point, by union–find over edges; return the number of components."""
    points = len(label)
    parent = np.arange(points)  # an earlier point of the same component, or itself
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
