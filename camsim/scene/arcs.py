"""Curves approximated by biarcs, used by the check of curved outlines and to stroke lines.

A biarc with the end directions of the curve deviates by about h³·|κ′|/324, to one side in its first half and to the
other in its second. So the areas nearly cancel; the difference is measured, and where it is too large, the joint of
the arcs is moved so that the areas cancel.

Places are complex numbers here.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

import numpy as np

from camsim.core.arrays import C128, F64, I64, picked
from camsim.scene.curves import ARC, CUBIC, Curves

HALVINGS = 40
BESIDE = 0.02  # of an arc's length
LOOKED_AT, MIDDLE = (0.15, 0.3, 0.5, 0.7, 0.85), 2  # parameters of a piece where distance is measured; 0.5 among them
MOST_BEND = 0.5  # of a piece, radians
OF_CUT = 12.0  # times the allowed: half of a biarc has an area error of a third of its length times its deviation
ROUNDING = 1e-15  # of the largest coordinate: error of places; that of areas is this times their length
LONGER, MUCH_LONGER, SECANTS = 1.1, 2.0, 3  # times, for the sake of areas: what is tried first, the most, and how often
STRAIGHT_SINE = 5e-8  # half the turn below which an arc is numerically straight
NOWHERE = 1e100  # distance, pitches: far from any arc, and still finite
FAR_PART = 0.5  # of the allowed error, for all distant parts
TOO_FLAT = 1600.0  # times the allowed: parts whose radius is too large for such accuracy are drawn as lines,
STRAIGHT = 80.0  # and these need only this accuracy: a tenth of the tolerance, at the limit of rounding


class Away(Protocol):
    """Accuracy required of distant curves, which decreases with distance."""

    def reached_by(self, curves: Curves) -> bool:
        """Return whether any of the curves leaves the region near the frame."""
        ...

    def much_of(self, curves: Curves) -> float:
        """Return the amount of distant curves, among which the allowed error is shared."""
        ...

    def enough(self, begin: C128, finish: C128, allowed: float) -> F64:
        """Return the largest allowed deviation of curves between places (n,); 0 where the curves are near."""
        ...


class Fineness(NamedTuple):
    """Accuracy of the approximation of curves; pitches.

    longest : shortest period that the optics transmit
    allowed : allowed error of a photosite, relative to full scale
    away    : accuracy of distant parts; None if the decay of the PSF is unknown
    """

    longest: float = 1.0
    allowed: float = 1e-9
    away: Away | None = None

    @property
    def most_off(self) -> float:
        """Largest deviation of an arc from its curve."""
        return self.longest * math.sqrt(self.allowed / math.pi)


class Arcs(NamedTuple):
    """Straight or round parts (n,), in order along their curves.

    owner : index of the curve;  start, end: complex;  bend_rad: how far the direction turns along it (0: straight)
    """

    owner: I64
    start: C128
    end: C128
    bend_rad: F64


def arcs_of(curves: Curves, fine: Fineness, *, cut: bool = False, least: float = 0.0) -> Arcs:
    """Approximate curves that are neither straight nor circles.

    cut   : whether other curves may cross these; then each half of a biarc must match its area, for a few pairs
    least : length in pitches; parts that turn back within less, as in a cusp, where no biarc fits, become lines
    """
    owner = np.repeat(np.arange(len(curves.kind)), 4)
    t0 = np.tile(np.arange(4) / 4.0, len(curves.kind))
    t1 = t0 + 0.25
    extent = np.abs(curves.points).max(axis=(1, 2), initial=0.0)
    away = fine.away if fine.away is not None and fine.away.reached_by(curves) else None
    of_far = 0.0 if away is None else FAR_PART * fine.allowed / away.much_of(curves)

    def close(some: _Stretches, pairs: Arcs) -> tuple[np.ndarray, np.ndarray, I64]:
        """Return which biarcs are good, which would be but for their area, and how many parts the others need."""
        off, bend, length, gained = _fit(some, pairs)
        rounding = ROUNDING * extent[some.owner]
        good = (off <= fine.most_off) & (length <= 0.35 * fine.longest)
        good &= off * length**2 <= fine.allowed * fine.longest**3
        if cut:
            good &= off * length <= OF_CUT * fine.allowed * fine.longest**2
        fits = good & (bend <= MOST_BEND)
        good &= gained <= np.maximum(0.25 * fine.allowed * fine.longest**2 * (some.t1 - some.t0), rounding * length)
        # Total absolute area between them.
        good |= off <= 0.5 * fine.allowed * fine.longest
        if away is not None:
            enough = away.enough(some.begin, some.finish, of_far)
            good |= (enough > 0.0) & (off <= np.maximum(enough, rounding))
        straight = ~pairs.bend_rad.any(axis=1)
        good |= straight & flat(some) & (off <= STRAIGHT * fine.allowed * fine.longest)
        good &= ROUNDING * _radius(pairs) <= known(some)
        # Half of it deviates by an eighth.
        return good & (bend <= MOST_BEND), fits, np.where(off > 4.0 * fine.allowed * fine.longest, 4, 2)

    def known(some: _Stretches) -> F64:
        """Return the accuracy that rounding must leave."""
        least: F64 = np.maximum(TOO_FLAT * fine.allowed * fine.longest, 4.0 * ROUNDING * extent[some.owner])
        return least

    def flat(some: _Stretches) -> np.ndarray:
        """Return which stretches turn so little that the radius of an arc is too large for that."""
        turn = np.abs(np.angle(some.into * some.out.conj()))
        return np.asarray(ROUNDING * np.abs(some.finish - some.begin) > known(some) * turn)

    done: list[tuple[Any, ...]] = []
    for turn in range(HALVINGS):
        stretches = _stretches(curves, owner, t0, t1)
        pairs = _pairs(stretches, np.ones(len(owner)))
        good, fits, parts = close(stretches, pairs)
        # Biarcs with a wrong area get another joint; nearly straight parts and cusps become lines.
        cusps = _room(stretches) <= least
        for others_of, poor in ((_of_one_area, fits), (_lines, flat(stretches) | cusps)):
            poor = np.flatnonzero(poor & ~good)
            if not poor.size:
                continue
            some = picked(stretches, poor)
            others = others_of(some)
            better = close(some, others)[0] | (cusps[poor] if others_of is _lines else False)
            for column, other in zip(pairs[1:], others[1:], strict=True):
                column[poor[better]] = other[better]
            good[poor] = better
        if turn == HALVINGS - 1:
            good[:] = True
        done.append((t0[good], *picked(pairs, good)))
        if good.all():
            break
        each = np.repeat(np.flatnonzero(~good), parts[~good])
        number, owner, step = np.arange(each.size) - np.searchsorted(each, each), owner[each], ((t1 - t0) / parts)[each]
        t0, t1 = t0[each] + number * step, t0[each] + (number + 1) * step
    begins, owners, *pairs_of = map(np.concatenate, zip(*done, strict=True))
    order = np.lexsort((begins, owners))
    # Pairs are stored as first arcs and second arcs: (n, 2).
    arcs = Arcs(np.repeat(owners[order], 2), *(column[order].ravel() for column in pairs_of))
    return picked(arcs, arcs.start != arcs.end)


def _areas(pairs: Arcs) -> F64:
    """Return the areas (n,) between biarcs and their chords; see Curves.areas."""
    chord = pairs.end - pairs.start
    bend = pairs.bend_rad
    small = np.abs(bend) < 1e-2
    safe = np.where(small, 1.0, bend)
    # (β − sin β)/(8 sin² β/2) of the chord's square.
    part = np.where(
        small, bend / 12.0 * (1.0 + bend**2 / 30.0), (safe - np.sin(safe)) / (8.0 * np.sin(0.5 * safe) ** 2)
    )
    triangle = 0.5 * (chord[:, 0].conj() * chord[:, 1]).imag
    areas: F64 = (np.abs(chord) ** 2 * part).sum(axis=1) + triangle
    return areas


def _places(curves: Curves, owner: I64, t: F64) -> tuple[C128, C128]:
    """Return points (n, m) and directions of curves (n,) at parameters (n, m)."""
    p = curves.points[owner, :, :1] + 1j * curves.points[owner, :, 1:]
    a, b, c, d = np.moveaxis(p, 1, 0)
    kind, turn = curves.kind[owner][:, None], curves.turn_rad[owner][:, None]
    s = 1.0 - t
    ab, bc, cd, ss, st, tt = b - a, c - b, d - c, s * s, s * t, t * t
    cubic, is_round = kind == CUBIC, kind == ARC
    place = np.where(cubic, s * ss * a + 3.0 * s * st * b + 3.0 * t * st * c + t * tt * d, s * a + t * d)
    way = np.where(cubic, ss * ab + 2.0 * st * bc + tt * cd, d - a)
    if is_round.any():
        cos, sin = np.cos(turn * t), np.sin(turn * t)
        place = np.where(is_round, (a - b) + b * cos + c * sin, place)
        way = np.where(is_round, turn * (c * cos - b * sin), way)
    # If control points coincide, the direction is that of the next ones.
    none = (np.abs(way) <= 1e-14 * (np.abs(ab) + np.abs(bc) + np.abs(cd))) & cubic
    if none.any():
        way = np.where(none, np.where(t < 0.5, np.where(c != a, c - a, d - a), np.where(d != b, d - b, d - a)), way)
    size = np.abs(way)
    return place, way / np.where(size > 0.0, size, 1.0)


class _Stretches(NamedTuple):
    """Parts of curves from t0 to t1: end points, directions there, places at ``LOOKED_AT``, areas over their chords."""

    owner: I64
    t0: F64
    t1: F64
    begin: C128
    out: C128
    finish: C128
    into: C128
    along: C128
    areas: F64


def _stretches(curves: Curves, owner: I64, t0: F64, t1: F64) -> _Stretches:
    """Cut stretches out of curves; ends of a curve keep their exact coordinates."""
    place, way = _places(curves, owner, t0[:, None] + np.array([0.0, *LOOKED_AT, 1.0]) * (t1 - t0)[:, None])
    one = curves.points[owner]
    begin = np.where(t0 == 0.0, one[:, 0, 0] + 1j * one[:, 0, 1], place[:, 0])
    finish = np.where(t1 == 1.0, one[:, 3, 0] + 1j * one[:, 3, 1], place[:, -1])
    areas = curves.some(owner).areas(t0, t1)
    return _Stretches(owner, t0, t1, begin, way[:, 0], finish, way[:, -1], place[:, 1:-1], areas)


def _pairs(stretches: _Stretches, longer: F64) -> Arcs:
    """Return biarcs (n, 2); ``longer``: length of the first tangents relative to the case of four equal ones.

    The distance between the ends of the tangents d and e equals d + e.
    """
    begin, out, finish, into = stretches[3:7]
    chord = finish - begin
    size = np.abs(chord)
    along = (chord * (out + into).conj()).real
    apart = 2.0 * (1.0 - (out * into.conj()).real)
    root = np.sqrt(along * along + apart * size * size)
    # The smaller of the two lengths of equal tangents, in the form without cancellation.
    d = longer * (size * size / np.where(along + root > 0.0, along + root, 1.0))
    under = (chord * into.conj()).real + 0.5 * d * apart
    e = (0.5 * size * size - d * (chord * out.conj()).real) / np.where(under > 0.0, under, 1.0)
    e = np.where(longer == 1.0, d, e)
    usable = (along + root > 0.0) & (size > 0.0) & ((longer == 1.0) | (under > 0.0)) & (d > 0.0) & (e > 0.0)
    middle = (e * (begin + d * out) + d * (finish - e * into)) / np.where(usable, d + e, 1.0)
    middle = np.where(usable, middle, 0.5 * (begin + finish))
    first, second = middle - begin, finish - middle
    bends = np.stack([2.0 * np.angle(first * out.conj()), 2.0 * np.angle(into * second.conj())], axis=1)
    bends = np.where(usable[:, None], bends, 0.0)
    start, end = np.stack([begin, middle], axis=1), np.stack([middle, finish], axis=1)
    bends = np.where(np.abs(np.sin(0.5 * bends)) < STRAIGHT_SINE, 0.0, bends)
    return Arcs(stretches.owner, start, end, bends)


def _lines(stretches: _Stretches) -> Arcs:
    """Return pairs of straight lines between the ends of stretches, via the middle of their curves."""
    begin, middle, finish = stretches.begin, stretches.along[:, MIDDLE], stretches.finish
    start, end = np.stack([begin, middle], axis=1), np.stack([middle, finish], axis=1)
    return Arcs(stretches.owner, start, end, np.zeros((len(begin), 2)))


def _room(stretches: _Stretches) -> F64:
    """Return the largest distance of sampled points of stretches from their starts."""
    places = np.concatenate([stretches.along, stretches.finish[:, None]], axis=1)
    room: F64 = np.abs(places - stretches.begin[:, None]).max(axis=1)
    return room


def _of_one_area(stretches: _Stretches) -> Arcs:
    """Return biarcs with the areas of their curves, by a few secant steps."""
    last, now = np.ones(len(stretches.owner)), np.full(len(stretches.owner), LONGER)
    before = _areas(_pairs(stretches, last)) - stretches.areas
    for _ in range(SECANTS):
        gained = _areas(_pairs(stretches, now)) - stretches.areas
        step = gained * (now - last) / np.where(gained != before, gained - before, np.inf)
        last, before, now = now, gained, np.clip(now - step, 1.0 / MUCH_LONGER, MUCH_LONGER)
    return _pairs(stretches, now)


def _radius(pairs: Arcs) -> F64:
    """Return the larger radius (n,) of each pair; 0 if straight."""
    chord, sine = np.abs(pairs.end - pairs.start), np.sin(0.5 * np.abs(pairs.bend_rad))
    radius: F64 = np.where(sine > 0.0, 0.5 * chord / np.where(sine > 0.0, sine, 1.0), 0.0).max(axis=1)
    return radius


def _fit(stretches: _Stretches, pairs: Arcs) -> tuple[F64, F64, F64, F64]:
    """Return deviation, turn, length and area error of biarcs."""
    columns = ((pairs.start[:, k, None], pairs.end[:, k, None], pairs.bend_rad[:, k, None]) for k in (0, 1))
    off = np.minimum(*(_distance(stretches.along, *each) for each in columns)).max(axis=1)
    off = np.minimum(off, NOWHERE)
    bend = np.abs(np.angle(stretches.into * stretches.out.conj())) + np.abs(pairs.bend_rad).max(axis=1)
    return off, bend, np.abs(stretches.finish - stretches.begin), np.abs(_areas(pairs) - stretches.areas)


def _distance(place: C128, start: C128, end: C128, bend: F64) -> F64:
    """Return the distances of points from arcs; infinity outside their span."""
    chord = end - start
    size = np.where(np.abs(chord) > 0.0, np.abs(chord), 1.0)
    local = (place - start) * chord.conj() / size
    x, y = local.real, local.imag
    # Of the circle through 0 and (size, 0): its equation over the length of its slope.
    off = np.abs((x * x + y * y - size * x) / size * np.sin(0.5 * bend) - y * np.cos(0.5 * bend))
    return np.where((x > -BESIDE * size) & (x < (1.0 + BESIDE) * size), off, np.inf)
