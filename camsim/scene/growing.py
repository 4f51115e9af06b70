"""Sides along parts of curves that no other outline cuts: short at their ends, and growing so smoothly that nothing
shows (``SideLimits.growing_um``).

Along a part there is a density of sides, one over their length. Its integral is known piece by piece as a polynomial,
and corners lie where it is a whole number.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from camsim.arrays import F64, I64
from camsim.quadrature import gauss_legendre
from camsim.scene.curves import Curves, circles_among, cross
from camsim.scene.side_limits import MOST_TURN, NOTHING, SideLimits, judge_sides
from camsim.scene.stretches import TURN, Stretches, distances, halved, running

HALVINGS = 60
TOGETHER, AT_ONCE = 4096, 65_536  # stretches, and corners: memory for few numbers beyond the corners themselves
NODES = 12  # along a piece no longer than it is from an end: 1e-9 of what grows with the distance
NEWTON = 5  # a density changes by a part of itself in a piece: to rounding
NEARLY = 1e-9  # of a side
CUSP = 0.1  # of a stretch's length over what it turns: a radius is no smaller


class _Rule(NamedTuple):
    """Gauss nodes (q,) from −1 to 1, their weights, and what gives coefficients of Legendre polynomials, and integrals
    from −1 to each node and derivatives there, (q, q), of a function known there."""

    x: F64
    w: F64
    coefficients: F64
    until: F64
    slopes: F64


@functools.cache
def _rule() -> _Rule:
    x, w = gauss_legendre(NODES)
    degree = np.arange(NODES)
    coefficients = (legendre.legvander(x, NODES - 1) * w[:, None] * (degree + 0.5)).T
    until = legendre.legvander(x, NODES) @ legendre.legint(coefficients, lbnd=-1.0)
    slopes = legendre.legvander(x, NODES - 2) @ legendre.legder(coefficients)
    return _Rule(x, w, coefficients, until, slopes)


def grown(curves: Curves, parts: Stretches, limits: SideLimits, longer: F64 | None) -> tuple[I64, F64]:
    """Return the corners within parts of curves: which of them each lies in, in order, and at which parameter.

    curves : by part;  parts: stretches, ``owner`` their part's number, each part from end to end
    longer : of each stretch, a length that will do whatever the limits say
    """
    first = np.append(np.searchsorted(parts.owner, np.arange(len(curves.kind))), len(parts.owner))
    owners, places = [np.empty(0, np.int64)], [np.empty(0)]
    begin = 0
    while begin < len(curves.kind):
        end = max(int(np.searchsorted(first, first[begin] + TOGETHER, side="right")) - 1, begin + 1)
        some = np.arange(first[begin], first[end])
        own = parts.some(some)
        density = _density(
            curves.some(np.arange(begin, end)),
            own._replace(owner=own.owner - begin),
            limits,
            None if longer is None else longer[some],
        )
        owner, t = _corners(density)
        owners.append(owner + begin)
        places.append(t)
        begin = end
    return np.concatenate(owners), np.concatenate(places)


class _Density(NamedTuple):
    """Sides of parts of curves, piece by piece: ``density`` (pieces, q) at Gauss nodes, sides for half a piece."""

    pieces: Stretches
    density: F64


def _density(curves: Curves, parts: Stretches, limits: SideLimits, longer: F64 | None) -> _Density:
    pieces, which = _pieces(parts, limits)
    rule, whose = _rule(), pieces.owner
    circles = circles_among(curves)[whose]
    half = 0.5 * (pieces.t1 - pieces.t0)
    t = pieces.t0[:, None] + half[:, None] * (1.0 + rule.x)
    along, bend = (way.reshape(*t.shape, 2) for way in curves.some(np.repeat(whose, NODES)).slopes(t.ravel()))
    speed = np.hypot(along[..., 0], along[..., 1])
    # A cusp's radius is 0 in one point; what a stretch turns says enough of it.
    sharpest = TURN / (CUSP * parts.length_um)[which, None]
    curvature = np.clip(cross(along, bend) / np.maximum(speed, NOTHING) ** 3, -sharpest, sharpest)
    speed *= half[:, None]
    changes, bends = _derivatives(curvature, speed, rule)
    changes[circles], bends[circles] = 0.0, 0.0
    before, total = running(whose, speed @ rule.w)
    from_start = before[:, None] + speed @ rule.until.T
    to_end = np.maximum(total[whose][:, None] - from_start, 0.0)
    side = limits.growing_um(curvature, changes, bends, from_start, to_end)
    if longer is not None:
        side = np.maximum(side, np.minimum(longer[which, None], MOST_TURN / np.maximum(np.abs(curvature), NOTHING)))
    return _Density(pieces, speed / side)


def _corners(found: _Density) -> tuple[I64, F64]:
    """Return in which part each corner lies, and at which parameter."""
    rule, whose = _rule(), found.pieces.owner
    number = found.density @ rule.w
    before, total = running(whose, number)
    judge_sides(float(total.sum()))
    inner = np.maximum(np.ceil(total - NEARLY).astype(np.int64) - 1, 0)
    owner = np.repeat(np.arange(inner.size), inner)
    nth = 1 + np.arange(owner.size) - np.repeat(np.cumsum(inner) - inner, inner)
    wanted = nth / (inner + 1)[owner] * total[owner]
    # Which piece each lies in: of its part, and these one after the other.
    offset = np.cumsum(total) - total
    piece = np.searchsorted(before + offset[whose], wanted + offset[owner], side="right") - 1
    first = np.searchsorted(whose, np.arange(inner.size))
    piece = np.clip(piece, first[owner], (np.append(first[1:], whose.size) - 1)[owner])
    wanted -= before[piece]
    coefficients = (found.density @ rule.coefficients.T).T
    until = legendre.legint(coefficients, lbnd=-1.0)
    places = np.clip(2.0 * wanted / np.maximum(number, NOTHING)[piece] - 1.0, -1.0, 1.0)
    for begin in range(0, places.size, AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        x, own, rising = places[some], until[:, piece[some]], coefficients[:, piece[some]]
        for _ in range(NEWTON):
            x -= (legendre.legval(x, own, tensor=False) - wanted[some]) / legendre.legval(x, rising, tensor=False)
            np.clip(x, -1.0, 1.0, out=x)
    half = 0.5 * (found.pieces.t1 - found.pieces.t0)
    return owner, found.pieces.t0[piece] + half[piece] * (1.0 + places)


def _derivatives(values: F64, speed: F64, rule: _Rule) -> tuple[F64, F64]:
    """Return first and second derivatives along the curve."""
    speed = np.maximum(speed, NOTHING)
    first: F64 = values @ rule.slopes.T / speed
    second: F64 = first @ rule.slopes.T / speed
    return first, second


def _pieces(parts: Stretches, limits: SideLimits) -> tuple[Stretches, I64]:
    """Return pieces of the stretches no longer than they are from the ends of their part, but for the shortest sides,
    and which stretch each is of."""
    found = parts
    which: I64 = np.arange(len(parts.owner))
    for _ in range(HALVINGS):
        from_start, from_end, _total = distances(found)
        long = found.length_um > np.maximum(np.minimum(from_start, from_end), limits.first_um(found.radius_um))
        if not long.any():
            break
        found, of = halved(found, long)
        which = which[of]
    return found, which
