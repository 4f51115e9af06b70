"""Arcs that are far away, of which a few long sides give what many short ones do: in pieces of one octave of distance.

A side s of an arc of radius R leaves no more than s³/12R of area between them. Of all sides together that gives least
for their number where s = F·(R/light)^⅓.
"""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.check.from_afar import FromAfar
from camsim.scene.arcs import FAR_PART, Fineness

MOST_TURN = 0.25  # radians of a side
NEARER = 2.0  # times its radius and distance: a side's square, which then comes nearer by a quarter of that
NOTHING = 1e-300
LONGER = 1.0  # shortest waves: sides have to be longer than this for an arc to be cut


def far_apart(arcs: F64, fine: Fineness) -> tuple[F64, I64]:
    """Return arcs with those that are long and far away in pieces, and which each was.

    arcs    : (n, 5) centre (x, y), radius, begin and turn of each
    returns : (m, 6), the last how long its sides are, 0: as short as near
    """
    whole = np.column_stack([arcs, np.zeros(len(arcs))]), np.arange(len(arcs))
    away = fine.away
    if not isinstance(away, FromAfar) or not len(arcs):
        return whole
    pieces, owner = _cut(arcs, away)
    x, y, radius, begin, turn = pieces.T
    middle = x + 1j * y + radius * np.exp(1j * (begin + 0.5 * turn))
    alone = np.bincount(owner)[owner] == 1
    distance = away.distance(middle, np.where(alone, 0.5 * turn * radius, 0.0))
    # A circle about the frame, or a long part of one, is nowhere nearer than its rim.
    distance = np.maximum(distance, np.abs(np.abs(x + 1j * y - away.centre) - radius) - away.radius)
    light = away.light_from(distance)
    far = np.isfinite(light)
    shape = np.cbrt(radius[far] / light[far])
    much = float(np.sum(turn[far] * radius[far] / shape))
    if much == 0.0:
        return whole
    sides = np.zeros(len(pieces))
    sides[far] = math.sqrt(12.0 * FAR_PART * fine.allowed / much) * shape
    sides = np.minimum(sides, np.minimum(MOST_TURN * radius, np.sqrt(NEARER * radius * np.maximum(distance, 0.0))))
    sides[sides < LONGER * fine.longest] = 0.0
    used = np.bincount(owner, sides)[owner] > 0.0
    rest = np.ones(len(arcs), bool)
    rest[owner[used]] = False
    return (
        np.concatenate([whole[0][rest], np.column_stack([pieces, sides])[used]]),
        np.concatenate([np.flatnonzero(rest), owner[used]]),
    )


def _cut(arcs: F64, away: FromAfar) -> tuple[F64, I64]:
    """Return arcs in pieces (m, 5) where they pass from one octave of distance into another, and whose each is."""
    x, y, radius, begin, turn = arcs.T
    half = 0.5 * turn * radius
    middle = np.abs(x + 1j * y + radius * np.exp(1j * (begin + 0.5 * turn)) - away.centre)
    # What is all near, or small beside its distance, is in one octave or two.
    long = (middle + half > away.radius + away.near) & (middle - away.radius - half < 2.0 * half)
    owner = np.flatnonzero(long)
    at = _crossings(arcs[owner], away)
    cuts = np.isfinite(at)
    pieces_each = np.ones(len(arcs), np.int64)
    pieces_each[owner] += cuts.sum(axis=1)
    owner = np.repeat(np.arange(len(arcs)), pieces_each)
    first = np.append(True, np.diff(owner) != 0)[: len(owner)]
    last = np.append(first[1:], True)
    low, high = np.zeros(len(owner)), turn[owner]
    low[~first], high[~last] = at[cuts], at[cuts]
    pieces = arcs[owner]
    pieces[:, 3], pieces[:, 4] = begin[owner] + low, high - low
    return pieces, owner


def _crossings(arcs: F64, away: FromAfar) -> F64:
    """Return how far arcs (n, 5) have turned where they pass from one octave of distance into another (n, most),
    infinite for none.

    Of the triangle of both centres and where two circles cross, 2 sin² φ/2 = 1 − cos φ.
    """
    x, y, radius, begin, turn = arcs.T
    to = away.centre - x - 1j * y
    gap = np.abs(to)
    octaves = away.radius + away.near * 2.0 ** np.arange(len(away.light))
    below, above = octaves - (radius - gap)[:, None], octaves + (radius - gap)[:, None]
    crosses = (below > 0.0) & (above > 0.0) & (octaves < (radius + gap)[:, None])
    sine = np.sqrt(np.where(crosses, below * above, 0.0) / np.maximum(4.0 * radius * gap, NOTHING)[:, None])
    off, towards = 2.0 * np.arcsin(np.minimum(sine, 1.0)), np.angle(to)[:, None]
    at = (np.concatenate([towards - off, towards + off], axis=1) - begin[:, None]) % math.tau
    within = np.concatenate([crosses, crosses], axis=1) & (at > 0.0) & (at < turn[:, None])
    return np.sort(np.where(within, at, np.inf), axis=1)
