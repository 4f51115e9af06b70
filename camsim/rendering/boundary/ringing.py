"""Cutoff radii of ringing for a scene's edges: beyond them its contribution is within its share of the tolerance.

There is one for an edge's end among many and one for whole lines; ``coherence.py`` computes how a spectrum's ringing
decays. Where edges meet in step, as round outlines do about their centre, both radii take all of them.
"""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import kinds_of
from camsim.rendering.boundary.coherence import Waves
from camsim.rendering.boundary.falling import falls_to
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.footprint import BEYOND, Footprint
from camsim.rendering.grid import Grid
from camsim.rendering.rings import Rings

FEW = 4  # corners, or lines, for which the shares were set
MEETING = 16.0  # largest strength of eight ends in one place, in right-angled corners
SMOOTH = 0.5  # radians of a turn below which two sides are parts of one curve


def reach_of_ringing(waves: Waves, edges: Edges, grid: Grid, budget: ErrorBudget) -> tuple[float, float]:
    """Return the cutoff radii of ringing of ends, and of lines that are at least as long as that, pitches.

    Both are at least the distance from which on the far form holds apart from ringing.
    """
    pattern, smooth = waves.pattern, smooth_from(waves, budget)
    ends, lines = budget.allowed("ends"), budget.allowed("lines")
    in_step = lines + budget.allowed("in step")
    end = max(smooth, waves.negligible_distance(ends, front="end", least=smooth))
    corners = crowding(edges, 4.0 * end)
    if corners > FEW:
        end = max(smooth, waves.negligible_distance(ends * math.sqrt(FEW / corners), front="end", least=smooth))
    if pattern.rings and smooth_corners(edges, end):
        # A smooth outline perpendicular to the line of sight acts as a line, however short its sides.
        end = max(end, waves.negligible_distance(lines, front="line", least=end))
    if pattern.rings and (short := edges.length < end).any():
        end = max(end, _meeting(waves, edges.some(short), grid, end, in_step))
    count = int(np.count_nonzero(edges.length >= end))
    line = max(end, waves.negligible_distance(lines * math.sqrt(FEW / max(count, FEW)), front="line", least=end))
    if pattern.rings and count:
        line = max(line, _meeting(waves, edges, grid, line, in_step))
    return end, line


def _meeting(waves: Waves, edges: Edges, grid: Grid, least: float, allowed: float) -> float:
    """Return the distance beyond which edges that meet in step anywhere add at most ``allowed``, pitches."""
    longest, highest = float(waves.blur.max()), max(u for u, _, _ in waves.pattern.rings) / float(waves.blur.min())
    rings = Rings.of(edges, grid, edges.farthest(grid), np.ones(len(edges)), longest, highest)
    distance, share = rings.distances, np.abs(rings.shares)
    some = distance >= least
    # Those farther out count less, since ringing falls as 1/r² or more slowly.
    power = min(n for _, _, n in waves.pattern.rings) - 0.5
    falls = distance[some] ** -power
    in_step = np.cumsum((share[:, some] * falls)[:, ::-1], axis=1)[:, ::-1] / falls
    most, last = float(in_step.max(initial=0.0)), np.flatnonzero(share[:, some].any(axis=0))
    if most == 0.0:
        return least
    within = float(distance[some][last[-1]]) + rings.step
    return waves.negligible_distance(allowed / most, front="focus", least=least, within=max(within, least))


def smooth_from(waves: Waves, budget: ErrorBudget) -> float:
    """Return the distance, pitches, beyond which the far form neglects nothing but ringing."""
    pattern, footprint, longest = waves.pattern, waves.footprint, float(waves.blur.max())
    # A tail that vanishes must do so over the whole footprint; powers of the distance are averaged by its moments.
    faded = 0.0 if pattern.rings else footprint.extent
    return max(
        pattern.quiet(budget.allowed("powers")) * longest + faded,
        _moment_distance(pattern.powers[0] * longest, footprint, budget.allowed("moments")),
    )


def smooth_corners(edges: Edges, short: float) -> bool:
    """Return whether there are corners that turn by less than SMOOTH between edges shorter than ``short``."""
    goes_on = (edges.end[:-1] == edges.start[1:]).all(axis=1)
    straight = np.sum(edges.along[:-1] * edges.along[1:], axis=1) > math.cos(SMOOTH)
    return bool((goes_on & straight & (np.maximum(edges.length[:-1], edges.length[1:]) < short)).any())


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
