"""Curved outlines as polygons: as many sides as bends and tolerance ask for, each with its curve's area.

A side s of a curve of radius R lies no farther than s²/12R from it when its ends are moved outwards by as much, so that
areas stay. What limits s is said in lengths (``SideLimits``); here sides are laid along the curves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.errors import InvalidValueError
from camsim.scene.curves import ARC, STRAIGHT, Curves, cross

MOST_TURN = 2.0 * math.pi / 64.0
"""Of a side, radians."""

TURN = 0.25  # radians over which a bend is taken for the same
GROWTH = 1.3  # of sides from an end on
SMOOTH = 1e-7  # sine of the angle between curves that go on in one another
TOGETHER = 20_000  # curves that are cut at a time
HALVINGS = 40
MOST_SIDES = 20_000_000  # of all curves
FINEST = 1e-4  # of a curve's length: the first side at a corner is no shorter

Longest = Callable[[F64, F64, F64], F64]


class SideLimits(NamedTuple):
    """How long a side may be where a curve's radius is R.

    segment_um : at most
    wobble_um  : root-mean-square distance between side and curve: s²/(R·√720), the parabola s²/8R less its mean
    cut_um2    : area between them over a part of a side, which no other part makes up for where another shape cuts
                 the outline: s³/(72·√3·R); and what a side leaves at a corner, whose place is kept: s³/24R
    longer     : lengths (n,) that will do whatever those limits say, by places (n, 2), radii (n,) and the lengths (n,)
                 of curve about each place
    """

    segment_um: float = math.inf
    wobble_um: float = math.inf
    cut_um2: float = math.inf
    longer: Longest | None = None

    def side_um(self, radius_um: F64, cut: np.ndarray | bool) -> F64:
        """Return the longest sides (n,) but for ``longer``; ``cut``: whether another outline may cut there."""
        side = np.minimum(self.segment_um, np.sqrt(self.wobble_um * radius_um * math.sqrt(720.0)))
        if math.isfinite(self.cut_um2):
            cut_side = np.cbrt(self.cut_um2 * radius_um * 72.0 * math.sqrt(3.0))
            side = np.where(cut, np.minimum(side, cut_side), side)
        return np.minimum(side, MOST_TURN * radius_um)

    def corner_um(self, radius_um: F64) -> F64:
        """Return the longest first sides (n,) from a corner."""
        if not math.isfinite(self.cut_um2):
            return np.full_like(radius_um, np.inf)
        return np.cbrt(24.0 * self.cut_um2 * radius_um)


class Stretches(NamedTuple):
    """Parts of curves so short that they bend alike all along.

    owner : (n,) whose;  t0, t1: from where to where of its parameter
    place, radius, length : (n, 2), (n,), (n,) its middle, its smallest radius, how long it is; µm
    """

    owner: I64
    t0: F64
    t1: F64
    place: F64
    radius: F64
    length: F64

    def some(self, which: I64 | np.ndarray) -> Stretches:
        """Return picked ones."""
        owner, t0, t1, place, radius, length = self
        return Stretches(owner[which], t0[which], t1[which], place[which], radius[which], length[which])


Apart = Callable[[F64, F64], F64]


def stretches(curves: Curves, apart: Apart | None = None) -> Stretches:
    """Cut curves that are not straight until each part bends alike, and is no longer than ``apart`` says of its place
    and length."""
    count = len(curves.kind)
    initial = np.where(curves.kind == ARC, np.ceil(np.abs(curves.turn_rad) / TURN), 4).astype(np.int64)
    owner = np.repeat(np.arange(count), initial)
    step = np.arange(owner.size) - np.repeat(np.cumsum(initial) - initial, initial)
    t0, t1 = step / initial[owner], (step + 1) / initial[owner]
    done: list[Stretches] = []
    for turn in range(HALVINGS):
        found, bends = _measured(curves, owner, t0, t1)
        long = bends > TURN
        if apart is not None:
            long |= found.length > apart(found.place, found.length)
        if turn == HALVINGS - 1:
            long[:] = False
        done.append(found.some(~long))
        if not long.any():
            break
        owner, t0, t1 = np.repeat(owner[long], 2), np.repeat(t0[long], 2), np.repeat(t1[long], 2)
        middle = 0.5 * (t0 + t1)
        t1[::2], t0[1::2] = middle[::2], middle[1::2]
    joined = Stretches(*(np.concatenate([part[column] for part in done]) for column in range(len(Stretches._fields))))
    return joined.some(np.lexsort((joined.t0, joined.owner)))


def _measured(curves: Curves, owner: I64, t0: F64, t1: F64) -> tuple[Stretches, F64]:
    """Return stretches and how far each turns."""
    own = curves.some(owner)
    speeds, radii, ways = [], [], []
    for t in (t0, 0.5 * (t0 + t1), t1):
        along, bend = own.slopes(t)
        speed = np.hypot(along[:, 0], along[:, 1])
        turning = np.abs(cross(along, bend))
        straight = turning <= 1e-300 + 1e-15 * speed * np.hypot(bend[:, 0], bend[:, 1])
        radii.append(np.where(straight, np.inf, speed**3 / np.where(straight, 1.0, turning)))
        speeds.append(speed)
        ways.append(along)
    length = (t1 - t0) * (speeds[0] + 4.0 * speeds[1] + speeds[2]) / 6.0
    bends = _angle(ways[0], ways[1]) + _angle(ways[1], ways[2])
    # A cusp's radius is 0 in one point; what a stretch turns says enough of it.
    radius = np.maximum(np.minimum.reduce(radii), length / TURN * 0.1)
    return Stretches(owner, t0, t1, own.at(0.5 * (t0 + t1)), radius, length), bends


def _angle(a: F64, b: F64) -> F64:
    angle: F64 = np.abs(np.arctan2(cross(a, b), np.einsum("ij,ij->i", a, b)))
    return angle


class Polygons(NamedTuple):
    """Corners (n, 2) of polygons, one after the other, µm, and where each begins (loops + 1,)."""

    corners: F64
    first: I64

    @property
    def each(self) -> list[F64]:
        """The corners of each."""
        return np.split(self.corners, self.first[1:-1])


def polygons(curves: Curves, limits: SideLimits, cut: np.ndarray, apart: Apart | None = None) -> Polygons:
    """Return the loops as polygons; ``cut`` (n,) says of each piece whether another outline may cut it."""
    if not np.any(curves.kind != STRAIGHT):
        return Polygons(curves.points[:, 0], curves.first)
    following = _following(curves.first)
    smooth = _smooth(curves, following)
    through = np.zeros(len(curves.kind), bool)  # whether the piece's start is no corner
    through[following] = smooth
    sides, places = np.ones(len(curves.kind), np.int64), []
    bent = np.flatnonzero(curves.kind != STRAIGHT)
    for some in np.array_split(bent, math.ceil(len(bent) / TOGETHER)):
        corners = ~np.stack([through[some], smooth[some]], axis=1)
        count, t = _laid(curves.some(some), limits, cut[some], corners, apart)
        sides[some] = count
        places.append(t)
    owner = np.repeat(np.arange(len(sides)), sides)
    begin = np.cumsum(sides) - sides
    t0 = np.zeros(owner.size)
    t0[(curves.kind != STRAIGHT)[owner]] = np.concatenate(places)
    last = np.ones(owner.size, bool)
    last[:-1] = owner[1:] != owner[:-1]
    t1 = np.where(last, 1.0, np.roll(t0, -1))
    own = curves.some(owner)
    corners = own.at(t0)
    corners[begin] = curves.points[:, 0]
    first = np.concatenate([begin, [owner.size]])[curves.first]
    free = np.ones(owner.size, bool)
    free[begin] = through
    return Polygons(_with_areas(corners, own.areas(t0, t1), free, first), first)


def _following(first: I64) -> I64:
    """Return which one follows each in its loop."""
    following = np.arange(1, first[-1] + 1)
    following[first[1:] - 1] = first[:-1]
    return following


def _smooth(curves: Curves, following: I64) -> np.ndarray:
    """Return whether each curve goes on in the next without a corner; where one of them is straight none does."""
    count = len(curves.kind)
    ends, starts = curves.slopes(np.ones(count))[0], curves.slopes(np.zeros(count))[0][following]
    sizes = np.hypot(ends[:, 0], ends[:, 1]) * np.hypot(starts[:, 0], starts[:, 1])
    bent = curves.kind != STRAIGHT
    on: np.ndarray = np.einsum("ij,ij->i", ends, starts) > 0.0
    smooth: np.ndarray = bent & bent[following] & on & (np.abs(cross(ends, starts)) <= SMOOTH * sizes)
    return smooth


def _laid(
    curves: Curves, limits: SideLimits, cut: np.ndarray, corners: np.ndarray, apart: Apart | None
) -> tuple[I64, F64]:
    """Return how many sides each curve gets, and where they begin, curve after curve.

    corners : (n, 2) whether its start and its end are corners, whose places are kept: sides grow from there on
    """
    found = stretches(curves, apart)
    side = limits.side_um(found.radius, cut[found.owner])
    if limits.longer is not None:
        longer = limits.longer(found.place, found.radius, found.length)
        side = np.minimum(np.maximum(side, longer), MOST_TURN * found.radius)
    found, side = _graded(found, side, limits, corners)
    each = found.length / side
    count = len(curves.kind)
    total = np.bincount(found.owner, each, count)
    # A curve between two corners has a side in its middle that can be moved.
    sides = np.maximum(np.ceil(total - 1e-9), np.where(corners.all(axis=1), 2, 1))
    if sides.sum() > MOST_SIDES:
        raise InvalidValueError(
            f"curves of the scene would take {sides.sum():.3g} sides at this tolerance; the most is {MOST_SIDES:g}: "
            "give a coarser one, or draw less of them"
        )
    sides = sides.astype(np.int64)
    # As a share of its own total, and curve after curve: both rise all along.
    share = each / np.where(total > 0.0, total, 1.0)[found.owner]
    until = np.cumsum(share)
    starts = np.concatenate([[0.0], until[:-1]])
    first = np.searchsorted(found.owner, np.arange(count))
    offset = starts[first]
    x = np.minimum(starts - offset[found.owner], 1.0) + found.owner
    owner = np.repeat(np.arange(count), sides)
    wanted = (np.arange(owner.size) - np.repeat(np.cumsum(sides) - sides, sides)) / sides[owner]
    t = np.interp(wanted + owner, np.append(x, count), np.append(found.t0 + found.owner, count)) - owner
    return sides, np.clip(t, 0.0, 1.0)


def _graded(found: Stretches, side: F64, limits: SideLimits, corners: np.ndarray) -> tuple[Stretches, F64]:
    """Return stretches, cut again near corners, and their sides, which grow from what a corner asks for."""
    if not math.isfinite(limits.cut_um2) or not corners.any():
        return found, side
    for _ in range(HALVINGS):
        from_start, from_end, total = _distances(found)
        allowed = np.full_like(side, np.inf)
        for column, distance in enumerate((from_start, from_end)):
            nearest = np.maximum(limits.corner_um(found.radius), FINEST * total)
            grown = nearest + (1.0 - 1.0 / GROWTH) * distance
            allowed = np.where(corners[found.owner, column], np.minimum(allowed, grown), allowed)
        # Where sides grow by half over one stretch it is cut in two.
        long = (allowed < side) & (found.length > np.maximum(2.0 * np.minimum(from_start, from_end), allowed))
        if not long.any():
            break
        found, side = _halved(found, side, long)
    return found, np.minimum(side, allowed)


def _distances(found: Stretches) -> tuple[F64, F64, F64]:
    """Return how far each stretch is from its curve's start and from its end, and the curve's whole length (n,)."""
    whole = np.bincount(found.owner, found.length).astype(float)[found.owner]
    until = np.cumsum(found.length)
    first = np.searchsorted(found.owner, found.owner)
    start = until - found.length
    from_start = start - start[first]
    return from_start, np.maximum(whole - from_start - found.length, 0.0), whole


def _halved(found: Stretches, side: F64, long: np.ndarray) -> tuple[Stretches, F64]:
    twice = np.repeat(np.arange(len(side)), np.where(long, 2, 1))
    first = np.searchsorted(twice, np.flatnonzero(long))
    halves = found.some(twice)
    middle = 0.5 * (found.t0 + found.t1)[long]
    halves.t1[first], halves.t0[first + 1] = middle, middle
    halves.length[first] *= 0.5
    halves.length[first + 1] *= 0.5
    return halves, side[twice]


def _with_areas(corners: F64, areas: F64, free: np.ndarray, first: I64) -> F64:
    """Return corners moved so that sides have their curves' areas: each but for higher powers, each loop to rounding.

    areas : (n,) between the curve and the side that begins at each corner;  free: (n,) corners that may move
    """
    following = _following(first)
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
        # No farther than a side is long: hairpins have areas that no corner can make up for.
        most = np.sqrt(np.minimum(_squares(corners[following] - corners), _squares(corners - corners[before])) / size)
        pace = np.where(free, np.clip(2.0 * needed / size, -most, most), 0.0)
        moved = moved + pace[:, None] * np.stack([chord[:, 1], -chord[:, 0]], axis=1)
    whole = np.add.reduceat(areas, first[:-1])
    for _ in range(2):
        ratio = whole / np.where(whole == 0.0, 1.0, np.add.reduceat(_gained(corners, moved, following), first[:-1]))
        ratio = np.where((whole != 0.0) & (np.abs(ratio - 1.0) < 0.1), ratio, 1.0)
        moved = corners + np.repeat(ratio, np.diff(first))[:, None] * (moved - corners)
    return moved


def _gained(corners: F64, moved: F64, following: I64) -> F64:
    """Return the areas (n,) of the quadrilaterals corner, its new place, the next one's new place, the next corner."""
    here, there = moved - corners, (moved - corners)[following]
    base = corners[following] - corners
    areas: F64 = 0.5 * (cross(here, base + there) - cross(base, there))
    return areas


def _squares(vectors: F64) -> F64:
    squares: F64 = np.einsum("ij,ij->i", vectors, vectors)
    return squares
