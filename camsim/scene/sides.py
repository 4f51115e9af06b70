"""Curved outlines as polygons: sides by curvature and tolerance, each with its curve's area.

A side s of a curve of radius R deviates by at most s²/12R if its ends are moved outwards by that much, which preserves
areas. ``SideLimits`` has the limits of s; this module lays sides along the curves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.scene.curves import STRAIGHT, Curves, circles_among, cross
from camsim.scene.side_limits import SideLimits, validate_sides
from camsim.scene.stretches import Stretches, followers, gradual, stretches

SMOOTH = 1e-7  # sine of the largest angle between smoothly joined curves
GRID_BITS = 46  # of the largest coordinate of a curve
NEARLY = 1e-9  # of a curve's parameter: a corner so near an end coincides with it


class Polygons(NamedTuple):
    """Concatenated corners (n, 2) of polygons, µm, and offsets (loops + 1,)."""

    corners_um: F64
    first: I64

    @property
    def each(self) -> list[F64]:
        """The corners (n, 2) of each polygon."""
        return np.split(self.corners_um, self.first[1:-1])

    def some(self, loops: np.ndarray) -> Polygons:
        """Return the selected ones."""
        counts = np.diff(self.first)
        return Polygons(self.corners_um[np.repeat(loops, counts)], np.append(0, np.cumsum(counts[loops])))

    def some_of(self, kind: I64) -> Polygons:
        """Return polygons by index (n,), possibly repeated."""
        counts = np.diff(self.first)[kind]
        first = np.concatenate([[0], np.cumsum(counts)])
        return Polygons(self.corners_um[np.arange(first[-1]) + np.repeat(self.first[kind] - first[:-1], counts)], first)

    def sides_um(self, outer: np.ndarray) -> tuple[F64, F64]:
        """Return the starts and ends (n, 2) of all sides.

        Polygons that are ``outer`` (loops,) run so that their inside is where the cross product is positive; holes run
        the other way.
        """
        loop = np.repeat(np.arange(len(outer)), np.diff(self.first))
        following = followers(self.first)
        base = self.corners_um - self.corners_um[self.first[:-1]][loop]
        back = (np.add.reduceat(cross(base, base[following]), self.first[:-1]) > 0.0) != outer
        number = np.arange(len(loop))
        start = self.corners_um[np.where(back[loop], (self.first[:-1] + self.first[1:] - 1)[loop] - number, number)]
        return start, start[following]


def polygons(curves: Curves, limits: SideLimits, cut: np.ndarray | None = None) -> Polygons:
    """Return the loops as polygons; ``cut``: (loops,) mask of those that another outline may cut, None for none."""
    if not np.any(curves.kind != STRAIGHT):
        return Polygons(curves.points[:, 0], curves.first)
    following = followers(curves.first)
    smooth = _smooth(curves, following)
    through = np.zeros(len(curves.kind), bool)  # whether the piece's start is not a corner
    through[following] = smooth
    sides = np.ones(len(curves.kind), np.int64)
    bent = np.flatnonzero(curves.kind != STRAIGHT)
    corners = ~np.stack([through[bent], smooth[bent]], axis=1)
    # Side lengths of an outline change at corners, and where its radius does.
    uneven = np.full(len(curves.first) - 1, limits.textured) if cut is None else cut | limits.textured
    uneven[curves.loop[bent[corners.any(axis=1) | ~circles_among(curves.some(bent))]]] = True
    sides[bent], t = _laid(curves.some(bent), limits, uneven[curves.loop[bent]], corners)
    owner = np.repeat(np.arange(len(sides)), sides)
    begin = np.cumsum(sides) - sides
    t0 = np.zeros(owner.size)
    t0[(curves.kind != STRAIGHT)[owner]] = t
    last = np.ones(owner.size, bool)
    last[:-1] = owner[1:] != owner[:-1]
    t1 = np.where(last, 1.0, np.roll(t0, -1))
    one = curves.some(owner)
    corners = one.at(t0)
    corners[begin] = curves.points[:, 0]
    first = np.concatenate([begin, [owner.size]])[curves.first]
    free = np.ones(owner.size, bool)
    free[begin] = through
    moved = _with_areas(corners, one.areas(t0, t1), free, first)
    # Shared corners of curves differ by rounding; on a grid they are equal.
    largest = float(np.abs(moved[(curves.kind != STRAIGHT)[owner]]).max())
    grid = math.ldexp(1.0, math.frexp(largest)[1] - GRID_BITS)
    begins_straight = np.zeros(owner.size, bool)
    begins_straight[begin] = ~through
    return Polygons(np.where(begins_straight[:, None], moved, np.round(moved / grid) * grid), first)


def _smooth(curves: Curves, following: I64) -> np.ndarray:
    """Return whether each curve joins the next smoothly; false if one of them is straight."""
    count = len(curves.kind)
    ends, starts = curves.slopes(np.ones(count))[0], curves.slopes(np.zeros(count))[0][following]
    sizes = np.hypot(ends[:, 0], ends[:, 1]) * np.hypot(starts[:, 0], starts[:, 1])
    bent = curves.kind != STRAIGHT
    on: np.ndarray = np.einsum("ij,ij->i", ends, starts) > 0.0
    smooth: np.ndarray = bent & bent[following] & on & (np.abs(cross(ends, starts)) <= SMOOTH * sizes)
    return smooth


def _laid(curves: Curves, limits: SideLimits, uneven: np.ndarray, corners: np.ndarray) -> tuple[I64, F64]:
    """Return the number of sides of each curve, and their starts, curve after curve.

    uneven  : curves of outlines with corners, with a varying radius, or that may be cut
    corners : (n, 2) whether a curve's start and end are corners, which are kept in place
    """
    round_ones = circles_among(curves)
    others = np.flatnonzero(~round_ones)
    found = stretches(curves.some(others))
    side = limits.side_um(found.radius_um, uneven[others][found.owner])
    side = np.maximum(np.minimum(side, limits.segment_um), gradual(side, found))
    validate_sides(float(np.sum(found.length_um / side)))
    inner, t = _even_steps(found, side, len(others))
    circles = np.flatnonzero(round_ones)
    along, steps = _whole_steps(curves.some(circles), limits, uneven[circles])
    owner = np.concatenate([np.arange(len(corners)), others[inner], circles[along]])
    t = np.concatenate([np.zeros(len(corners)), t, steps])
    # A curve between two corners has a side in its middle that can be moved.
    single = np.flatnonzero((np.bincount(owner, minlength=len(corners)) == 1) & corners.all(axis=1))
    owner, t = np.concatenate([owner, single]), np.concatenate([t, np.full(single.size, 0.5)])
    order = np.lexsort((t, owner))
    return np.bincount(owner, minlength=len(corners)), t[order]


def _whole_steps(curves: Curves, limits: SideLimits, uneven: np.ndarray) -> tuple[I64, F64]:
    """Return owners and parameters of the corners within parts of circles.

    Their directions are multiples of a turn divided by a round number: arcs of one circle shared by different shapes
    get the same corners, without gaps between them.
    """
    u, v = curves.points[:, 1], curves.points[:, 2]
    begin, way = np.arctan2(u[:, 1], u[:, 0]), np.sign(cross(u, v)) * curves.turn_rad
    radius = np.hypot(u[:, 0], u[:, 1])
    wanted = math.tau * radius / limits.side_um(radius, uneven)
    validate_sides(float(np.sum(wanted)))
    eighth = 2.0 ** (np.floor(np.log2(wanted)) - 3.0)
    step = math.tau / (eighth * np.ceil(wanted / eighth - NEARLY))
    ends = np.stack([begin, begin + way]) / step
    low, high = np.floor(ends.min(axis=0)) + 1.0, np.floor(ends.max(axis=0))
    counts = np.maximum(high - low + 1.0, 0.0).astype(np.int64)
    whose = np.repeat(np.arange(counts.size), counts)
    number = low[whose] + np.arange(whose.size) - np.repeat(np.cumsum(counts) - counts, counts)
    t = (number * step[whose] - begin[whose]) / way[whose]
    inner = (t > NEARLY) & (t < 1.0 - NEARLY)
    return whose[inner], t[inner]


def _even_steps(found: Stretches, side: F64, count: int) -> tuple[I64, F64]:
    """Return owners (of ``count``) and parameters of corners on other curves, spaced by the sides that parts need."""
    each = found.length_um / side
    total = np.bincount(found.owner, each, count)
    sides = np.ceil(total - 1e-9).astype(np.int64)
    # Cumulative, as a share of each curve's total plus its index: monotone over all curves.
    share = each / np.where(total > 0.0, total, 1.0)[found.owner]
    starts = np.concatenate([[0.0], np.cumsum(share)[:-1]])
    ends = np.append(found.owner[1:] != found.owner[:-1], True)[: len(share)]
    x = np.minimum(starts - starts[np.searchsorted(found.owner, found.owner)], 1.0) + found.owner
    after = np.flatnonzero(ends) + 1
    x = np.insert(x, after, (found.owner + 1.0)[ends])
    at = np.insert(found.t0 + found.owner, after, (found.t1 + found.owner)[ends])
    inner = np.maximum(sides - 1, 0)
    owner = np.repeat(np.arange(count), inner)
    wanted = (1 + np.arange(owner.size) - np.repeat(np.cumsum(inner) - inner, inner)) / sides[owner]
    t = np.interp(wanted + owner, x, at) - owner if x.size else wanted
    return owner, np.clip(t, 0.0, 1.0)


def _with_areas(corners: F64, areas: F64, free: np.ndarray, first: I64) -> F64:
    """Return corners moved so that sides have their curves' areas: each to leading order, each loop to rounding.

    areas : (n,) between the curve and the side that begins at each corner;  free: (n,) corners that may move
    """
    following = followers(first)
    before = np.empty_like(following)
    before[following] = np.arange(len(following))
    share = np.where(free[following], np.where(free, 0.5, 0.0), np.where(free, 1.0, 0.0))
    moved = corners
    for _ in range(2):
        missing = areas - _gained(corners, moved, following)
        needed = share * missing + ((1.0 - share) * missing)[before] * free
        chord = moved[following] - moved[before]
        size = _squares(chord)
        size = np.where(size > 0.0, size, np.inf)
        # At most a side's length: no corner can compensate the area of a hairpin.
        most = np.sqrt(np.minimum(_squares(corners[following] - corners), _squares(corners - corners[before])) / size)
        pace = np.where(free, np.clip(2.0 * needed / size, -most, most), 0.0)
        moved = moved + pace[:, None] * np.stack([chord[:, 1], -chord[:, 0]], axis=1)
    whole = np.add.reduceat(areas, first[:-1])
    for _ in range(2):
        gained = np.add.reduceat(_gained(corners, moved, following), first[:-1])
        ratio = whole / np.where(gained == 0.0, np.inf, gained)  # without a gain, only rounding may be missing
        ratio = np.where((whole != 0.0) & (np.abs(ratio - 1.0) < 0.1), ratio, 1.0)
        moved = corners + np.repeat(ratio, np.diff(first))[:, None] * (moved - corners)
    return moved


def _gained(corners: F64, moved: F64, following: I64) -> F64:
    """Return the areas (n,) of the quadrilaterals corner, moved corner, next moved corner, next corner."""
    here, there = moved - corners, (moved - corners)[following]
    base = corners[following] - corners
    return 0.5 * (cross(here, base + there) - cross(base, there))


def _squares(vectors: F64) -> F64:
    squares: F64 = np.einsum("ij,ij->i", vectors, vectors)
    return squares
