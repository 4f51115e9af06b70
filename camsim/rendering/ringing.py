"""How far the rings of a scene's edges are heard: what both engines leave out beyond that adds to their shares of it.

Of an edge's end in a crowd, of whole lines, and where round outlines send theirs to one place; ``quiet.py`` has how a
spectrum's rings fall silent, ``focus.py`` where they meet.
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

FEW = 4  # corners, or lines, that the shares were set for
MEETING = 16.0  # right angles that eight ends in one place are as loud as, at most
SMOOTH = 0.5  # radians of a turn below which two sides are parts of one curve
FEW_CIRCLES = 16  # of which to ask what parts of a turn edges fill takes less than how far rings are heard


class RingingReach(NamedTuple):
    """Distances from which on rings are within their shares, pitches.

    end, line : of ends, and of lines that are at least as long as that
    foci      : round outlines whose rings meet in the frame, louder than is allowed, although they are farther
    """

    end: float
    line: float
    foci: Foci


def counted(waves: Waves, edges: Edges, grid: Grid, budget: ErrorBudget) -> RingingReach:
    """Return how far rings are heard, and no less than from where on the far form holds but for them."""
    pattern, smooth = waves.pattern, smooth_from(waves, budget)
    ends, lines = budget.allowed("ends"), budget.allowed("lines")
    end = max(smooth, waves.negligible_distance(ends, front="end", least=smooth))
    corners = crowding(edges, 4.0 * end)
    if corners > FEW:
        end = max(smooth, waves.negligible_distance(ends * math.sqrt(FEW / corners), front="end", least=smooth))
    if pattern.rings and smooth_corners(edges, end):
        # Where a smooth outline is met square on it is a line, however short its sides.
        end = max(end, waves.negligible_distance(lines, front="line", least=end))
    strength = _strong_foci(waves, edges, grid, end, lines + budget.allowed("foci"))
    if strength.radius.size:
        # Zones add rings from ``end`` on, and those hold from ``holds`` on: beyond, if the pattern has any.
        holds = pattern.oscillations_from_blurs * float(waves.blur.max()) + waves.footprint.extent
        end = max(end, min(followed(strength), holds) if pattern.oscillations else followed(strength))
        strength = strength.some(_far_sides(strength) > end)
    count = int(np.count_nonzero(edges.length >= end))
    line = max(end, waves.negligible_distance(lines * math.sqrt(FEW / max(count, FEW)), front="line", least=end))
    return RingingReach(end, line, strength)


def smooth_from(waves: Waves, budget: ErrorBudget) -> float:
    """Return from where on the far form leaves nothing but rings."""
    pattern, footprint, longest = waves.pattern, waves.footprint, float(waves.blur.max())
    # What has died away has done so everywhere on the footprint; powers of the distance average out, as moments say.
    faded = 0.0 if pattern.rings else footprint.extent
    return max(
        pattern.quiet(budget.allowed("powers")) * longest + faded,
        _moment_distance(pattern.powers[0] * longest, footprint, budget.allowed("moments")),
    )


def followed(found: Foci) -> float:
    """Return how far rings are heard that meet in foci."""
    return float(_far_sides(found).max(initial=0.0))


def _far_sides(found: Foci) -> F64:
    """Return how far outlines (n,) are from the photosites about their centres that hear their rings, at most."""
    return (1.0 + ZONE) * found.radius


def _strong_foci(waves: Waves, edges: Edges, grid: Grid, negligible_end: float, allowed: float) -> Foci:
    """Return the round outlines whose rings from beyond ``quiet_end`` meet in the frame, louder than is allowed."""
    if not waves.pattern.rings or not len(edges):
        return NO_FOCI
    blur = float(waves.blur.min())
    centre, radius = circles(edges, grid=grid, nearest=negligible_end / (1.0 + ZONE), blur=blur)
    if not radius.size:
        return NO_FOCI
    beyond = 1.01 * float(radius.max())  # no circle asks
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
    # In hundredths, of more than one turn in tenths: few questions.
    share = np.where(share > 1.0, np.ceil(10.0 * share) / 10.0, np.ceil(100.0 * share) / 100.0)
    until = np.zeros_like(found.radius)
    for part in np.unique(share[share > 0.0]):
        one = share == part
        until[one] = waves.negligible_distance(
            allowed / float(part), front="focus", least=float(found.radius[one].min()), within=beyond
        )
    # Of circles about one centre all are heard that are no larger than a loud one.
    farthest = np.zeros(whose.max(initial=-1) + 1)
    strength = found.radius < until
    np.maximum.at(farthest, whose[strength], found.radius[strength])
    return distinct(found.some(found.radius <= farthest[whose]))


def smooth_corners(edges: Edges, short: float, widest: float = math.inf) -> bool:
    """Whether there are corners that turn by less than SMOOTH between edges that are no longer than ``short``.

    widest : the largest radius of the curves that they are parts of
    """
    before, after, _ = edges.threes
    length = edges.length
    a, b = edges.along[before], edges.along[after]
    straight = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] > math.cos(SMOOTH)
    turn = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    curved = turn * widest > 0.5 * (length[before] + length[after]) if widest < math.inf else straight
    return bool((straight & curved & (np.maximum(length[before], length[after]) < short)).any())


def crowding(edges: Edges, window: float) -> float:
    """Largest number of corners in any square of side ``window``, each counted by the square of how much it turns.

    A corner's strength is the jump of the unit direction, so a smooth outline cut into many edges counts for little.
    Where four ends meet, as of a checkerboard's fields, these jumps cancel and their rings add up: a line goes on there
    with its sides exchanged. Up to eight may all be of one sign; of more, neighbours are of either.
    """
    if not len(edges):
        return 0.0
    along = edges.along
    points, begins, ends = edges.corners
    corner, turn = np.concatenate([begins, ends]), np.concatenate([along, -along])
    jump = [np.bincount(corner, turn[:, axis], len(points)) for axis in (0, 1)]
    col, row = np.floor((points - edges.box[0]) / window).T
    square = row * (col.max() + 1.0) + col
    crowded = square.max() <= float(len(points))  # or most squares are empty, and those that are not are numbered
    square = square.astype(np.int64) if crowded else kinds_of(square)[1]
    strength = np.minimum(0.5 * (jump[0] ** 2 + jump[1] ** 2), 1.0)  # a right angle counts as one
    pairs = 0.5 * np.bincount(corner, minlength=len(points))
    strength = np.where(pairs >= 2.0, np.minimum(pairs**2, np.maximum(MEETING, pairs)), strength)
    return float(np.bincount(square, weights=strength).max(initial=0.0))


def _moment_distance(c1: float, footprint: Footprint, allowed: float) -> float:
    """Distance beyond which the footprint's moments past those of the far form stay below ``allowed``.

    Of the angle they leave |⟨ζⁿ⟩|/(2πnRⁿ), n = 8, 10 …; one of them may be 0 where the next is not, and near the
    footprint they fall slowly.
    """
    sixth: float = (3.0 * c1 * footprint.m66 / (2.0 * math.pi * allowed)) ** (1.0 / 7.0)
    sizes = [size / (2.0 * math.pi * n) for n, size in zip(BEYOND, footprint.beyond, strict=True)]
    return max(falls_to(allowed, sizes, BEYOND), sixth)
