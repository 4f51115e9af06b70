"""Discs over discs: the visible parts of each rim, and the regions behind them, in closed form.

Another disc covers one interval of a rim. A point of a rim is visible if no later disc covers it; the last earlier disc
that covers it is the region behind. So intervals are counted along each rim, without polygons.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.scene.curves import circles_among
from camsim.scene.outlines import Outlines
from camsim.scene.side_limits import SideLimits, validate_sides

TANGENT = 1e-9  # relative: circles so close to tangency are left to the polygon code
HIDDEN = -2  # in place of the region behind
TOGETHER = 4_000_000  # intervals processed at a time


class Rims(NamedTuple):
    """Visible parts of rims, each from a start angle, in the positive direction.

    disc, behind : (n,) index of the disc, and of the region behind it, 0 for the background
    centre_um, radius_um : (n, 2) centre and (n,) radius of the disc
    from_rad, turn_rad   : (n,) start angle, and how far the part turns; 2π is a whole rim
    start_um, end_um     : (n, 2) ends of the part, bit-identical to those of adjacent parts
    """

    disc: I64
    behind: I64
    centre_um: F64
    radius_um: F64
    from_rad: F64
    turn_rad: F64
    start_um: F64
    end_um: F64

    @property
    def whole(self) -> np.ndarray:
        """Mask (n,) of parts that are whole rims."""
        return np.asarray(self.turn_rad == math.tau)


class _Meetings(NamedTuple):
    """Points where rims enter and leave other discs.

    whose, other     : (n,) disc of the rim, and the other disc
    begin, end       : (n,) angles between which it is inside the other, in the positive direction
    begin_um, end_um : (n, 2) the points there
    """

    whose: I64
    other: I64
    begin: F64
    end: F64
    begin_um: F64
    end_um: F64


class Discs(NamedTuple):
    """Mask of primitives that are discs (n,), centres (n, 2) and radii (n,), 0 for others."""

    sound: np.ndarray
    centre_um: F64
    radius_um: F64

    @classmethod
    def of(cls, outlines: Outlines) -> Discs:
        """Return the discs among primitives."""
        curves, owner, count = outlines.curves, outlines.owner, len(outlines.simple)
        lone = outlines.simple[owner] & (np.bincount(owner, minlength=count) == 1)[owner]
        piece = np.flatnonzero(lone & (np.abs(curves.turn_rad) == math.tau) & circles_among(curves))
        found = cls(np.zeros(count, bool), np.zeros((count, 2)), np.zeros(count))
        found.sound[owner[piece]] = True
        found.centre_um[owner[piece]] = curves.points[piece, 0] - curves.points[piece, 1]
        found.radius_um[owner[piece]] = np.hypot(*curves.points[piece, 1].T)
        return found

    def covered(self, first: I64, second: I64) -> np.ndarray:
        """Return a mask of the pairs of discs whose first is fully within the second."""
        gap = np.hypot(*(self.centre_um[second] - self.centre_um[first]).T)
        slack = TANGENT * (np.abs(self.centre_um).max(axis=1, initial=0.0) + self.radius_um)
        within: np.ndarray = self.sound[first] & self.sound[second]
        within &= gap + self.radius_um[first] < self.radius_um[second] - np.maximum(slack[first], slack[second])
        return within

    def among_discs(self, first: I64, second: I64) -> np.ndarray:
        """Return a mask of discs that meet only discs; ``first``, ``second``: pairs of primitives that may meet."""
        sound, centre, radius = self.sound.copy(), self.centre_um, self.radius_um
        gap = np.hypot(*(centre[second] - centre[first]).T)
        size = np.abs(centre).max(axis=1, initial=0.0) + radius
        slack = TANGENT * np.maximum(size[first], size[second])
        one, two = radius[first], radius[second]
        tangent = np.minimum(np.abs(gap - one - two), np.abs(gap - np.abs(one - two))) <= slack
        # A disc that meets another shape is cut as a polygon, and so is any disc that meets it.
        while (bad := (sound[first] | sound[second]) & (tangent | ~sound[first] | ~sound[second])).any():
            sound[first[bad]] = sound[second[bad]] = False
        return sound


def rims_of(centre: F64, radius: F64, region: I64, pairs: tuple[I64, I64]) -> Rims:
    """Return the visible parts of the rims of discs in painter's order.

    region : (n,) region of each disc; parts with the same region on both sides are omitted
    pairs  : discs that may meet, the earlier one first
    """
    met, inner, outer = _meetings(centre, radius, *pairs)
    later = met.other > met.whose
    # Every rim is cut at the angle π, where it begins, and at both ends of every interval; how many later discs cover
    # discs changes there.
    count = np.bincount(met.whose[later & (met.begin > met.end)], minlength=len(radius))
    count += np.bincount(inner[outer > inner], minlength=len(radius))
    whose = np.concatenate([np.arange(len(radius)), met.whose, met.whose])
    angle = np.concatenate([np.full(len(radius), -math.pi), met.begin, met.end])
    change = np.concatenate([count, later.astype(np.int64), -later.astype(np.int64)])
    place = np.concatenate([centre - radius[:, None] * [1.0, 0.0], met.begin_um, met.end_um])
    order = np.lexsort((angle, whose))
    whose, angle, place = whose[order], angle[order], place[order]
    covered = np.cumsum(change[order])
    first = np.searchsorted(whose, np.arange(len(radius)))
    covered -= (covered - change[order])[first][whose]
    until = np.append(angle[1:], math.pi)
    until[_last(whose, len(radius))] = math.pi
    behind = np.full(len(whose), HIDDEN)
    seen = np.flatnonzero((covered == 0) & (until > angle))
    covers = _Covers.of(met, inner, outer, len(radius))
    behind[seen] = np.append(region, 0)[covers.last(whose[seen], 0.5 * (angle + until)[seen])]
    behind[behind == region[whose]] = HIDDEN
    proper = until > angle
    return _joined(whose[proper], angle[proper], behind[proper], place[proper], centre, radius)


def sides_of(rims: Rims, limits: SideLimits) -> tuple[I64, F64, F64]:
    """Return the sides of open parts: owners (n,), and starts and ends (n, 2).

    Sides of one length lie on a circle a little larger than theirs: two radii and a side of it have the sector's area,
    r²·φ/2 = R²·sin(φ)/2. At the ends of a part, a radial step connects the two circles without changing the area of a
    sector. So the only error at the ends is that second moments of the deviations, s⁵/720r each, no longer cancel. They
    leave s⁴/720r times the slope of the PSF, for each of the two ends.
    """
    sides = rims.radius_um * rims.turn_rad / limits.end_um(rims.radius_um)
    validate_sides(float(sides.sum()))
    count = np.maximum(np.ceil(sides - 1e-9), 1.0).astype(np.int64)
    each = rims.turn_rad / count
    out = rims.radius_um * np.sqrt(each / np.sin(each))
    # Each part from its start over corners on the larger circle to its end.
    corners = count + 3
    part = np.repeat(np.arange(len(count)), corners)
    last = np.cumsum(corners) - 1
    first = last - corners + 1
    angle = rims.from_rad[part] + (np.arange(len(part)) - first[part] - 1) * each[part]
    places = rims.centre_um[part] + out[part][:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    places[first], places[last] = rims.start_um, rims.end_um
    begins = np.ones(len(part), bool)
    begins[last] = False
    begin = np.flatnonzero(begins)
    return part[begin], places[begin], places[begin + 1]


def _joined(whose: I64, angle: F64, behind: I64, place: F64, centre: F64, radius: F64) -> Rims:
    """Return adjacent parts merged if the region behind is the same, also across the start of a rim."""
    first = np.searchsorted(whose, np.arange(len(radius)))
    before = np.arange(-1, len(whose) - 1)
    before[first] = _last(whose, len(radius))
    begins = behind[before] != behind
    closed = np.bincount(whose, begins, len(radius)) == 0
    begins[first[closed]] = True
    start = np.flatnonzero(begins)
    disc = whose[start]
    run = np.searchsorted(disc, np.arange(len(radius)))
    following = np.arange(1, len(start) + 1)
    following[_last(disc, len(radius))] = run
    turn = (angle[start[following]] - angle[start]) % math.tau
    turn[closed[disc]] = math.tau
    displayed = behind[start] != HIDDEN
    start, end, turn = start[displayed], start[following][displayed], turn[displayed]
    disc = whose[start]
    return Rims(disc, behind[start], centre[disc], radius[disc], angle[start], turn, place[start], place[end])


def _last(whose: I64, count: int) -> I64:
    """Return the index of each rim's last part."""
    return np.searchsorted(whose, np.arange(count), side="right") - 1


def _meetings(centre: F64, radius: F64, first: I64, second: I64) -> tuple[_Meetings, I64, I64]:
    """Return crossings of the rims of pairs, and pairs of nested discs."""
    gap = centre[second] - centre[first]
    distance = np.hypot(gap[:, 0], gap[:, 1])
    one, two = radius[first], radius[second]
    within, around = distance <= two - one, distance <= one - two
    inner = np.concatenate([first[within], second[around]])
    outer = np.concatenate([second[within], first[around]])
    cross = (distance < one + two) & ~within & ~around
    first, second, gap = first[cross], second[cross], gap[cross]
    distance, one, two = distance[cross], one[cross], two[cross]
    # Coordinates of both crossings along and across the line of centres.
    along = 0.5 * (distance + (one - two) * (one + two) / distance)
    off = np.sqrt(np.maximum((one - along) * (one + along), 0.0))
    way = gap / distance[:, None]
    side = off[:, None] * np.stack([-way[:, 1], way[:, 0]], axis=1)
    foot = centre[first] + along[:, None] * way
    low, high = foot - side, foot + side
    whose, other = np.concatenate([first, second]), np.concatenate([second, first])
    begin_um, end_um = np.concatenate([low, high]), np.concatenate([high, low])
    begin, end = (np.arctan2(*(at - centre[whose]).T[::-1]) for at in (begin_um, end_um))
    return _Meetings(whose, other, begin, end, begin_um, end_um), inner, outer


class _Covers(NamedTuple):
    """Intervals of rims covered by earlier discs: offsets per rim, disc, start and extent."""

    first: I64
    other: I64
    begin: F64
    size: F64

    @classmethod
    def of(cls, met: _Meetings, inner: I64, outer: I64, count: int) -> _Covers:
        """Return the intervals from crossings."""
        earlier, within = met.other < met.whose, outer < inner
        whose = np.concatenate([met.whose[earlier], inner[within]])
        other = np.concatenate([met.other[earlier], outer[within]])
        whole = np.full(np.count_nonzero(within), math.tau)
        begin = np.concatenate([met.begin[earlier], np.zeros_like(whole)])
        size = np.concatenate([((met.end - met.begin) % math.tau)[earlier], 2.0 * whole])
        order = np.argsort(whose, kind="stable")
        return cls(np.searchsorted(whose[order], np.arange(count + 1)), other[order], begin[order], size[order])

    def last(self, whose: I64, angle: F64) -> I64:
        """Return the last disc that covers a point on each rim (n,), −1 for none."""
        counts = np.diff(self.first)[whose]
        found = np.full(len(whose), -1)
        ends = np.append(np.flatnonzero(np.diff(np.cumsum(counts) // TOGETHER)) + 1, len(whose))
        for low, high in itertools.pairwise([0, *ends.tolist()]):
            part = np.repeat(np.arange(low, high), counts[low:high])
            before = np.cumsum(counts[low:high]) - counts[low:high]
            k = self.first[whose[part]] + np.arange(len(part)) - np.repeat(before, counts[low:high])
            lies = (angle[part] - self.begin[k]) % math.tau < self.size[k]
            np.maximum.at(found, part[lies], self.other[k[lies]])
        return found
