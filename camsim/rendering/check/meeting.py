"""Where rings of many outlines meet in step: places of a frame that the check looks at, and how far it hears there."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64, kinds_of
from camsim.rendering.check.records import Outlines
from camsim.rendering.check.whereabouts import Whereabouts

ABOUT = 0.3  # of a round outline's radius: as far from its middle its rings still meet
FALLS = 1.5  # at least this power of the distance is what swings lost with
ALIKE = 16  # parts at the most from one to the same of a pattern's next member
SAME = 1e-6  # of a length: what two that are the same differ by
MEMBERS = 3  # triples that agree on a middle, at least
CELL = 1e-3  # pitches, within which middles agree
MOST_PARTS, MOST_PLACES = 50_000, 32  # of a pattern looked for; of places that are looked at


def meeting_places(o: Outlines, corners: F64, *, beyond: float = 0.0) -> F64:
    """Return the middles (n, 2) in a frame of round parts and of patterns about a place, those of most of a turn first.

    corners : (4,) low x, low y, high x, high y of the outermost photosites
    beyond  : only of what lies farther than that from its middle
    """
    bent = np.flatnonzero((o.turn_rad != 0.0) & (o.dx > beyond))
    middle, turn = [o.x[bent] + 1j * o.y[bent]], [np.abs(o.turn_rad[bent])]
    straight = np.flatnonzero(o.turn_rad == 0.0)[:MOST_PARTS]
    about, radius = _about_a_place(o.some(straight))
    middle.append(about[radius > beyond])
    turn.append(np.full(middle[1].size, math.tau / max(1, middle[1].size)))
    found, index = kinds_of(np.round(np.concatenate(middle), 9))
    turns = np.bincount(index, np.concatenate(turn), found.size)
    places = found.view(np.float64).reshape(-1, 2)
    seen = np.all((places >= corners[:2] - 0.5) & (places <= corners[2:] + 0.5), axis=1)
    best: F64 = places[seen][np.argsort(-turns[seen], kind="stable")]
    return best


def _about_a_place(o: Outlines) -> tuple[F64, F64]:
    """Return the middles (n,) of circles on which the middles of equal parts lie, as evenly, and their radii (n,)."""
    middle, length = o.x + 0.5 * o.dx + 1j * (o.y + 0.5 * o.dy), np.hypot(o.dx, o.dy)
    found = []
    for step in range(1, ALIKE + 1):
        a, b, c = middle[: -2 * step], middle[step:-step], middle[2 * step :]
        ways, sizes = (b - a, c - b), (length[: -2 * step], length[step:-step], length[2 * step :])
        first, second = np.abs(ways[0]), np.abs(ways[1])
        even = np.abs(first - second) <= SAME * first
        even &= (np.abs(sizes[0] - sizes[1]) <= SAME * sizes[0]) & (np.abs(sizes[2] - sizes[1]) <= SAME * sizes[0])
        half_turn = 0.5 * np.angle(ways[1] * ways[0].conj())
        even &= np.abs(half_turn) > SAME
        # The middle lies as far to the side of a chord as half of it is long, over the tangent of half the turn.
        ahead, turn = ways[0][even], half_turn[even]
        found.append(np.stack([a[even] + ahead * (0.5 + 0.5j / np.tan(turn)), np.abs(ahead) / np.sin(np.abs(turn))]))
    places, radius = np.concatenate(found, axis=1)
    cells, index = kinds_of(np.round(places / CELL))
    votes = np.bincount(index, minlength=cells.size)[index]
    agreed = votes >= MEMBERS
    first_of = np.unique(index[agreed], return_index=True)[1]
    return places[agreed][first_of], 0.5 * radius.real[agreed][first_of]


def heard_until(points: F64, where: Whereabouts, *, base: float, swing: float, blur: F64, allowed: float) -> F64:
    """Return how far E is taken from its table for points (n, 2): farther than ``base`` where rings meet in one.

    swing : how far E swings about its smooth powers near ``base``;  blur: (n,) at every wavelength
    """
    o, longest = where.outlines, float(blur.max())
    until: F64 = np.full(len(points), base)
    large, first = np.flatnonzero((o.turn_rad > 0.0) & (o.dx > base)), 0
    for places in where.some_of(points):
        own = until[first : first + len(places)]
        first += len(places)
        h, beside = where.feet(places)
        far = beside & (np.abs(h) > base)
        gap = np.hypot(o.x[large] - places[:, :1], o.y[large] - places[:, 1:])
        about = gap < ABOUT * o.dx[large]
        for k in np.flatnonzero((np.count_nonzero(far, axis=1) > 2) | about.any(axis=1)).tolist():
            straight, round_parts = np.abs(h[k, far[k]]), large[about[k]]
            length = np.minimum(where.length[far[k]], np.sqrt(longest * straight))
            distance = np.concatenate([straight, o.dx[round_parts]])
            share = np.concatenate([length / straight, o.turn_rad[round_parts]]) / math.tau
            loud = distance[_loud(distance, swing * (base / distance) ** FALLS * share, blur, allowed)]
            if loud.size:
                own[k] = loud.max() + float(gap[k, about[k]].max(initial=0.0)) + longest
    return until


def _loud(distance: F64, swings: F64, blur: F64, allowed: float) -> np.ndarray:
    """Return which outlines' rings are louder than allowed at a place, with all those that come from farther away.

    Whether they are in step depends on the wavelength: the shortest, the longest and one between them are asked.
    Half a wave apart they are so for an edge whose dark side is the other one.
    """
    order = np.argsort(-distance)
    loud = np.zeros(distance.size, np.bool_)
    for wave in np.unique(np.quantile(blur, (0.0, 0.5, 1.0))).tolist():
        together = np.abs(np.cumsum(swings[order] * np.exp(2j * math.tau / wave * distance[order])))
        loud[order] |= together > allowed
    return loud
