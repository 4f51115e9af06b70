"""The check's outlines as straight sides: what its transforms and its pictures take."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64
from camsim.rendering.check.scenery import Pieces, followed
from camsim.rendering.edges import Edges
from camsim.scene.arcs import Fineness

GROWTH = 1.3  # of a part's sides from its ends on
OF_ARCS = 0.05  # of what sides may be wrong by: what Bézier curves are followed to by arcs


def polygons(pieces: Pieces, longest: float, allowed: float, *, textured: bool = False) -> Edges:
    """Return the pieces as straight edges: round ones as sides of the same area each, shorter than waves that pass.

    What stays of a circle's wobble is of second order: half its mean square, (s²/8R)²·4/45, times the slope of the line
    spread, at most 2π over a square wave.
    textured : edges of samples cut the sides anywhere. What is left of one then counts at once, its area, at most
               s³/(72·√3·R), times the pattern's peak, about 1/longest²; a tenth for each of those that lie near
    """
    pieces = followed(pieces, Fineness(longest, OF_ARCS * allowed))
    o = pieces.outlines
    starts, ends, owners = [], [], []
    straight = np.flatnonzero(o.turn_rad == 0.0)
    starts.append(np.stack([o.x, o.y], axis=1)[straight])
    ends.append(np.stack([o.x + o.dx, o.y + o.dy], axis=1)[straight])
    owners.append(straight)
    for e in np.flatnonzero(o.turn_rad > 0.0).tolist():
        big, whole = o.dx[e], o.turn_rad[e] >= math.tau * (1.0 - 1e-15)
        # A whole circle's sides are all alike and send nothing below their own frequency; a part's are not.
        side = min((0.7 if whole else 0.35) * longest, (229.0 * allowed * (big * longest) ** 2) ** 0.25)
        if textured:
            side = min(side, (12.0 * allowed * big * longest**2) ** (1.0 / 3.0))
        if whole:
            turns = np.full(max(96, math.ceil(math.tau * big / side)), 1.0)
        else:
            turns = _from_ends(0.5 * o.turn_rad[e] * big, big, side, longest, allowed)
        turns *= o.turn_rad[e] / turns.sum()
        angle = o.from_rad[e] + np.concatenate([[0.0], np.cumsum(turns)])
        radius = big * _corners(turns, whole)
        corners = np.stack([o.x[e] + radius * np.cos(angle), o.y[e] + radius * np.sin(angle)], axis=1)
        if whole:
            corners[-1] = corners[0]
        starts.append(corners[:-1])
        ends.append(corners[1:])
        owners.append(np.full(turns.size, e))
    owner = np.concatenate(owners)
    return Edges(
        start=np.concatenate(starts), end=np.concatenate(ends), left=pieces.left[owner], right=pieces.right[owner]
    )


def _from_ends(half: float, radius: float, side: float, longest: float, allowed: float) -> F64:
    """Return sides (2n,) of a part of a circle, the same from either end; ``half``: the length of half of it.

    Each has its arc's area, but the first lean on their arcs: s³/36R of area lies on the wrong side of their middles,
    and s⁴/96R of its moment wherever sides grow. On a square wave, and on its cube, that keeps below what is allowed.
    """
    side = min(side, (96.0 * allowed * radius * longest**3) ** 0.25)
    first = min(side, (36.0 * radius * allowed * longest**2) ** (1.0 / 3.0))
    growing = first * GROWTH ** np.arange(math.ceil(math.log(side / first) / math.log(GROWTH)) + 1)
    growing = growing[np.cumsum(growing) < half]
    more = max(1, math.ceil((half - growing.sum()) / side))
    sides = np.concatenate([growing, np.full(more, (half - growing.sum()) / more)])
    return np.concatenate([sides, sides[::-1]])


def _corners(turns: F64, whole: bool) -> F64:
    """Return how far corners (n + 1,) lie from the centre, of radius 1, where sides have their arcs' areas.

    rᵢ·rᵢ₊₁·sin θ = θ: all the same on a whole circle; a part's ends stay where other pieces meet them, and its middle
    is met from both.
    """
    stretch = turns / np.sin(turns)
    if whole:
        return np.full(turns.size + 1, math.sqrt(float(stretch[0])))
    radius = np.ones(turns.size + 1)
    for k in range(turns.size // 2):
        radius[k + 1] = stretch[k] / radius[k]
        radius[-k - 2] = stretch[-k - 1] / radius[-k - 1]
    return radius
