"""Cutoff radii of ringing for a scene's edges: beyond them its contribution is within its share of the tolerance.

There is one for an edge's end among many, one for whole lines, and foci of round outlines. ``coherence.py`` computes
how a spectrum's ringing decays, ``focus.py`` where it adds up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, kinds_of
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.circles import circles, in_step
from camsim.rendering.coherence import Waves
from camsim.rendering.edges import Edges
from camsim.rendering.falling import falls_to
from camsim.rendering.focus import NO_FOCI, ZONE, Foci, distinct, foci, normals
from camsim.rendering.footprint import BEYOND, Footprint
from camsim.rendering.grid import Grid

FEW = 4  # corners, or lines, for which the shares were set
MEETING = 16.0  # largest strength of eight ends in one place, in right-angled corners
SMOOTH = 0.5  # radians of a turn below which two sides are parts of one curve
FEW_CIRCLES = 16  # circles up to which the shares of a turn cost less than a cutoff radius


class RingingReach(NamedTuple):
    """Cutoff radii beyond which ringing is within its shares of the tolerance, pitches.

    end, line : of ends, and of lines that are at least as long as that
    foci      : round outlines beyond these radii whose ringing adds up in the frame to more than is allowed
    """

    end: float
    line: float
    foci: Foci


def counted(waves: Waves, edges: Edges, grid: Grid, budget: ErrorBudget) -> RingingReach:
    """Return the cutoff radii of ringing, at least the distance from which on the far form holds apart from it."""
    pattern, smooth = waves.pattern, smooth_from(waves, budget)
    ends, lines = budget.allowed("ends"), budget.allowed("lines")
    end = max(smooth, waves.negligible_distance(ends, front="end", least=smooth))
    corners = crowding(edges, 4.0 * end)
    if corners > FEW:
        end = max(smooth, waves.negligible_distance(ends * math.sqrt(FEW / corners), front="end", least=smooth))
    if pattern.rings and smooth_corners(edges, end):
        # A smooth outline perpendicular to the line of sight acts as a line, however short its sides.
        end = max(end, waves.negligible_distance(lines, front="line", least=end))
    strength = _strong_foci(waves, edges, grid, end, lines + budget.allowed("foci"))
    if strength.radius.size:
        # Zones add ringing from ``end`` on, by a formula valid from ``holds`` on, if the pattern has one.
        holds = pattern.oscillations_from_blurs * float(waves.blur.max()) + waves.footprint.extent
        end = max(end, min(followed(strength), holds) if pattern.oscillations else followed(strength))
        strength = strength.some(_far_sides(strength) > end)
    count = int(np.count_nonzero(edges.length >= end))
    line = max(end, waves.negligible_distance(lines * math.sqrt(FEW / max(count, FEW)), front="line", least=end))
    return RingingReach(end, line, strength)


def smooth_from(waves: Waves, budget: ErrorBudget) -> float:
    """Return the distance from which on the far form is exact except for ringing, pitches."""
    pattern, footprint, longest = waves.pattern, waves.footprint, float(waves.blur.max())
    # A tail that vanishes must do so over the whole footprint; powers of the distance are averaged by its moments.
    faded = 0.0 if pattern.rings else footprint.extent
    return max(
        pattern.quiet(budget.allowed("powers")) * longest + faded,
        _moment_distance(pattern.powers[0] * longest, footprint, budget.allowed("moments")),
    )


def followed(found: Foci) -> float:
    """Return the largest distance of an edge whose ringing must be counted for foci, pitches."""
    return float(_far_sides(found).max(initial=0.0))


def _far_sides(found: Foci) -> F64:
    """Return the largest distances (n,) of outlines from the photosites in the zones about their centres, pitches."""
    return (1.0 + ZONE) * found.radius


def _strong_foci(waves: Waves, edges: Edges, grid: Grid, negligible_end: float, allowed: float) -> Foci:
    """Return the round outlines beyond ``negligible_end`` whose ringing in the frame exceeds ``allowed``."""
    if not waves.pattern.rings or not len(edges):
        return NO_FOCI
    blur = float(waves.blur.min())
    centre, radius = circles(edges, grid=grid, nearest=negligible_end / (1.0 + ZONE), blur=blur)
    if not radius.size:
        return NO_FOCI
    beyond = 1.01 * float(radius.max())  # larger than any circle
    if radius.size > FEW_CIRCLES:
        nearest, most = float(radius.min()), in_step(centre, radius, np.ones(radius.size), blur)[0]
        strength = radius < waves.negligible_distance(
            allowed / float(most.max()), front="focus", least=nearest, within=beyond
        )
        centre, radius = centre[strength], radius[strength]
        if not radius.size:
            return NO_FOCI
    found = foci(centre, radius, edges, blur, waves.passed(normals(edges)))
    share, whose = in_step(found.centre, found.radius, found.share, blur)
    # Round up to hundredths, or tenths of more than one turn, for few distinct values.
    share = np.where(share > 1.0, np.ceil(10.0 * share) / 10.0, np.ceil(100.0 * share) / 100.0)
    until = np.zeros_like(found.radius)
    for part in np.unique(share[share > 0.0]):
        one = share == part
        until[one] = waves.negligible_distance(
            allowed / float(part), front="focus", least=float(found.radius[one].min()), within=beyond
        )
    # Among concentric circles, all no larger than a significant one count.
    farthest = np.zeros(whose.max(initial=-1) + 1)
    strength = found.radius < until
    np.maximum.at(farthest, whose[strength], found.radius[strength])
    return distinct(found.some(found.radius <= farthest[whose]))


def smooth_corners(edges: Edges, short: float, widest: float = math.inf) -> bool:
    """Return whether there are corners that turn by less than SMOOTH between edges shorter than ``short``.

    widest : largest radius of curvature
    """
    before, after, _ = edges.threes
    length = edges.length
    a, b = edges.along[before], edges.along[after]
    straight = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] > math.cos(SMOOTH)
    turn = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    curved = turn * widest > 0.5 * (length[before] + length[after]) if widest < math.inf else straight
    return bool((straight & curved & (np.maximum(length[before], length[after]) < short)).any())


def crowding(edges: Edges, window: float) -> float:
    """Return the largest sum of corner strengths in any square of side ``window``; a right angle has strength 1.

    A corner's strength is half the squared jump of the unit direction, so a smooth outline cut into many edges counts
    for little. Where four ends meet, as on a checkerboard, these jumps cancel but the ringing adds up, since each line
    continues with its sides exchanged. Up to eight may have the same sign; among more, neighbours have either sign.
    """
    if not len(edges):
        return 0.0
    along = edges.along
    points, begins, ends = edges.corners
    corner, turn = np.concatenate([begins, ends]), np.concatenate([along, -along])
    jump = [np.bincount(corner, turn[:, axis], len(points)) for axis in (0, 1)]
    col, row = np.floor((points - edges.box[0]) / window).T
    square = row * (col.max() + 1.0) + col
    crowded = square.max() <= float(len(points))  # else only squares that are not empty get numbers
    square = square.astype(np.int64) if crowded else kinds_of(square)[1]
    strength = np.minimum(0.5 * (jump[0] ** 2 + jump[1] ** 2), 1.0)  # 1 for a right angle
    pairs = 0.5 * np.bincount(corner, minlength=len(points))
    strength = np.where(pairs >= 2.0, np.minimum(pairs**2, np.maximum(MEETING, pairs)), strength)
    return float(np.bincount(square, weights=strength).max(initial=0.0))


def _moment_distance(c1: float, footprint: Footprint, allowed: float) -> float:
    """Return the distance beyond which the moments that the far form neglects contribute less than ``allowed``.

    Their error of the angle is |⟨ζⁿ⟩|/(2πnRⁿ), n = 8, 10 …; one may vanish where the next does not, and near the
    footprint they decrease slowly.
    """
    sixth: float = (3.0 * c1 * footprint.m66 / (2.0 * math.pi * allowed)) ** (1.0 / 7.0)
    sizes = [size / (2.0 * math.pi * n) for n, size in zip(BEYOND, footprint.beyond, strict=True)]
    return max(falls_to(allowed, sizes, BEYOND), sixth)
