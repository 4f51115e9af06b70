"""Parts of curves that bend alike all along, and which of them another outline may cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene.curves import ARC, STRAIGHT, Curves, cross

TURN = 0.25  # radians over which a bend is taken for the same
HALVINGS = 40
RISE = 0.25  # of a stretch's length, by which sides may be longer than those beside it
ROUNDS = 5  # of cutting stretches in two that others come near
HIGH = 0.05  # of a stretch's length: it rises less above its chord
SHARP = 2.0 * TURN + 0.1  # radians between two that begin in one corner: there they may turn into each other's way


class Stretches(NamedTuple):
    """Parts of curves so short that they bend alike all along.

    owner : (n,) whose;  t0, t1: from where to where of its parameter
    place_um, radius_um, length_um : (n, 2), (n,), (n,) its middle, its smallest radius, how long it is
    """

    owner: I64
    t0: F64
    t1: F64
    place_um: F64
    radius_um: F64
    length_um: F64

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
            long |= found.length_um > apart(found.place_um, found.length_um)
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


def distances(found: Stretches) -> tuple[F64, F64, F64]:
    """Return how far each stretch is from its curve's start and from its end, and the curve's whole length (n,)."""
    from_start, each = running(found.owner, found.length_um)
    whole = each[found.owner]
    return from_start, np.maximum(whole - from_start - found.length_um, 0.0), whole


def running(owner: I64, amount: F64) -> tuple[F64, F64]:
    """Return the sum of what comes before each (n,) with the same owner, and of all of each owner's."""
    total: F64 = np.bincount(owner, amount).astype(float)
    start = np.cumsum(amount) - amount
    return start - start[np.searchsorted(owner, owner)], total


def gradual(longest_um: F64, found: Stretches) -> F64:
    """Return lengths (n,) of sides that rise by no more than a part of each stretch along a curve, either way.

    A side that begins where they are short would else go on for as long as they may be farther away, and cut off what
    lies between: 0.65 of full scale of a disc of 60 000 photosites.

    >>> owner, length_um = np.array([0, 0, 0, 0, 1]), np.full(5, 4.0)
    >>> some = Stretches(owner, np.zeros(5), np.ones(5), np.zeros((5, 2)), np.ones(5), length_um)
    >>> gradual(np.array([9.0, 1.0, 9.0, 9.0, 9.0]), some)
    array([2., 1., 2., 3., 9.])
    """
    before, _ = running(found.owner, found.length_um)
    until = RISE * (before + found.length_um)
    rising = _least_so_far(longest_um - until, found.owner) + until
    falling = _least_so_far((rising + RISE * before)[::-1], found.owner[::-1])[::-1] - RISE * before
    return np.minimum(rising, falling)


def _least_so_far(values: F64, owner: I64) -> F64:
    """Return the least (n,) of an owner's values up to each: of twice as many in every round."""
    least, step = values.copy(), 1
    while step < len(least):
        same = owner[step:] == owner[:-step]
        np.minimum(least[step:], least[:-step].copy(), out=least[step:], where=same)
        step *= 2
    return least


def halved(found: Stretches, long: np.ndarray) -> tuple[Stretches, I64]:
    """Return stretches of which some are cut in two, and which each was."""
    twice = np.repeat(np.arange(len(long)), np.where(long, 2, 1))
    first = np.searchsorted(twice, np.flatnonzero(long))
    halves = found.some(twice)
    middle = 0.5 * (found.t0 + found.t1)[long]
    halves.t1[first], halves.t0[first + 1] = middle, middle
    halves.length_um[first] *= 0.5
    halves.length_um[first + 1] *= 0.5
    return halves, twice


def followers(first: I64) -> I64:
    """Return which one follows each in its loop, by where loops begin."""
    following = np.arange(1, first[-1] + 1)
    following[first[1:] - 1] = first[:-1]
    return following


class Whose(NamedTuple):
    """Whose pieces of outlines are, as far as one may cut another.

    primitive : (n,) of each piece
    crosses   : (n,) whether its own primitive's outlines may cut it
    meets     : (n,) whether any outline may
    """

    primitive: I64
    crosses: np.ndarray
    meets: np.ndarray


def cut_stretches(found: Stretches, curves: Curves, whose: Whose) -> tuple[Stretches, np.ndarray]:
    """Return stretches, finer where others are near, and which of them another outline may cut.

    found : of the curves that bend, numbered as in ``curves``
    """
    import shapely

    following = followers(curves.first)
    straight = np.flatnonzero((curves.kind == STRAIGHT) & whose.meets)
    fixed = np.stack([curves.points[straight, 0], curves.points[straight, 3]], axis=1)
    cut = whose.meets[found.owner]
    for turn in range(ROUNDS):
        if turn:
            found, which = halved(found, cut)
            cut = cut[which]
        here = np.flatnonzero(whose.meets[found.owner])
        bent = found.some(here)
        own = curves.some(bent.owner)
        chords = np.concatenate([np.stack([own.at(bent.t0), own.at(bent.t1)], axis=1), fixed])
        # An arc of a quarter radian or less rises by an eighth of its square over its radius; half of that is spare.
        high = np.minimum(HIGH * bent.length_um, 0.19 * bent.length_um**2 / bent.radius_um)
        high = np.concatenate([high, np.zeros(len(straight))])
        owner = np.concatenate([bent.owner, straight])
        boxes = shapely.box(*_boxes(chords[:, 0], chords[:, 1], high[:, None]).T)
        asked = np.flatnonzero(cut[here])
        first, second = shapely.STRtree(boxes).query(boxes[asked])
        first = asked[first]
        one, two = owner[first], owner[second]
        other = whose.primitive[one] != whose.primitive[two]
        follows = _after(owner, len(bent.owner), following)
        sharp = _sharp(curves.some(owner), bent, follows)
        ahead, back = follows[first] == second, follows[second] == first
        beside = (ahead | back) & ~(ahead & sharp[first]) & ~(back & sharp[second])
        other |= whose.crosses[one] & ~beside & (first != second)
        first, second = first[other], second[other]
        near = shapely.distance(*(shapely.linestrings(chords[part]) for part in (first, second)))
        cut[:] = False
        cut[here[first[near <= high[first] + high[second]]]] = True
    return found, cut


def _after(owner: I64, bent: int, following: I64) -> I64:
    """Return which part goes on where each ends, −1 for none that is there.

    owner : (n,) curve of each: those of ``bent`` parts in order, then straight ones, a part each
    """
    place = np.full(len(following), -1)
    place[owner[::-1]] = np.arange(len(owner))[::-1]  # of each curve's first part
    last = np.ones(len(owner), bool)
    last[:bent][:-1] = np.diff(owner[:bent]) != 0
    after: I64 = np.where(last, place[following[owner]], np.arange(1, len(owner) + 1))
    return after


def _sharp(curves: Curves, bent: Stretches, after: I64) -> np.ndarray:
    """Return whether each part meets the one after it in a corner so sharp that they may cross once more.

    curves : of the parts, first of those that are bent
    """
    t0, t1 = np.zeros(len(after)), np.ones(len(after))
    t0[: len(bent.t0)], t1[: len(bent.t1)] = bent.t0, bent.t1
    out, into = curves.slopes(t0)[0], curves.slopes(t1)[0]
    sharp: np.ndarray = (after >= 0) & (_angle(out[after], -into) < SHARP)
    return sharp


def _boxes(start: F64, end: F64, more: F64 | float) -> F64:
    return np.concatenate([np.minimum(start, end) - more, np.maximum(start, end) + more], axis=1)
