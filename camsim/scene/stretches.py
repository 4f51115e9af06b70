"""Parts of curves with nearly constant curvature."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64, picked
from camsim.scene.curves import ARC, Curves, cross

TURN = 0.25  # radians over which curvature counts as constant
HALVINGS = 40
RISE = 0.25  # of a stretch's length: largest increase of sides to the next stretch


class Stretches(NamedTuple):
    """Parts of curves with nearly constant curvature.

    owner : (n,) index of the curve;  t0, t1: range of its parameter
    place_um, radius_um, length_um : (n, 2), (n,), (n,) midpoint, smallest radius, length
    """

    owner: I64
    t0: F64
    t1: F64
    place_um: F64
    radius_um: F64
    length_um: F64


def stretches(curves: Curves) -> Stretches:
    """Cut curved pieces into parts of nearly constant curvature."""
    count = len(curves.kind)
    initial = np.where(curves.kind == ARC, np.ceil(np.abs(curves.turn_rad) / TURN), 4).astype(np.int64)
    owner = np.repeat(np.arange(count), initial)
    step = np.arange(owner.size) - np.repeat(np.cumsum(initial) - initial, initial)
    t0, t1 = step / initial[owner], (step + 1) / initial[owner]
    done: list[Stretches] = []
    for turn in range(HALVINGS):
        found, bends = _measured(curves, owner, t0, t1)
        long = (bends > TURN) & (turn < HALVINGS - 1)
        done.append(picked(found, ~long))
        if not long.any():
            break
        owner, t0, t1 = np.repeat(owner[long], 2), np.repeat(t0[long], 2), np.repeat(t1[long], 2)
        middle = 0.5 * (t0 + t1)
        t1[::2], t0[1::2] = middle[::2], middle[1::2]
    joined = Stretches(*map(np.concatenate, zip(*done, strict=True)))
    return picked(joined, np.lexsort((joined.t0, joined.owner)))


def _measured(curves: Curves, owner: I64, t0: F64, t1: F64) -> tuple[Stretches, F64]:
    """Return stretches and the turn of each."""
    one = curves.some(owner)
    speeds, radii, ways = [], [], []
    for t in (t0, 0.5 * (t0 + t1), t1):
        along, bend = one.slopes(t)
        speed = np.hypot(along[:, 0], along[:, 1])
        turning = np.abs(cross(along, bend))
        straight = turning <= 1e-300 + 1e-15 * speed * np.hypot(bend[:, 0], bend[:, 1])
        radii.append(np.where(straight, np.inf, speed**3 / np.where(straight, 1.0, turning)))
        speeds.append(speed)
        ways.append(along)
    length = (t1 - t0) * (speeds[0] + 4.0 * speeds[1] + speeds[2]) / 6.0
    bends = _angle(ways[0], ways[1]) + _angle(ways[1], ways[2])
    # A cusp has radius 0 at one point; the turn of its stretch suffices.
    radius = np.maximum(np.minimum.reduce(radii), length / TURN * 0.1)
    return Stretches(owner, t0, t1, one.at(0.5 * (t0 + t1)), radius, length), bends


def _angle(a: F64, b: F64) -> F64:
    angle: F64 = np.abs(np.arctan2(cross(a, b), np.einsum("ij,ij->i", a, b)))
    return angle


def gradual(longest_um: F64, found: Stretches) -> F64:
    """Return lengths (n,) of sides that, along a curve in either direction, rise by at most a part of each stretch.

    Otherwise a side that starts among short ones could be as long as distant ones and cut off the curve between:
    an error of 0.65 of full scale for a disc of 60 000 photosites.

    >>> owner, length_um = np.array([0, 0, 0, 0, 1]), np.full(5, 4.0)
    >>> some = Stretches(owner, np.zeros(5), np.ones(5), np.zeros((5, 2)), np.ones(5), length_um)
    >>> gradual(np.array([9.0, 1.0, 9.0, 9.0, 9.0]), some)
    array([2., 1., 2., 3., 9.])
    """
    before = np.cumsum(found.length_um) - found.length_um
    before -= before[np.searchsorted(found.owner, found.owner)]
    until = RISE * (before + found.length_um)
    rising = _least_so_far(longest_um - until, found.owner) + until
    falling = _least_so_far((rising + RISE * before)[::-1], found.owner[::-1])[::-1] - RISE * before
    return np.minimum(rising, falling)


def _least_so_far(values: F64, owner: I64) -> F64:
    """Return the running minimum (n,) per owner, over spans that double in every round."""
    least, step = values.copy(), 1
    while step < len(least):
        same = owner[step:] == owner[:-step]
        np.minimum(least[step:], least[:-step].copy(), out=least[step:], where=same)
        step *= 2
    return least


def followers(first: I64) -> I64:
    """Return the index of the next element in each loop, from offsets of loops."""
    following = np.arange(1, first[-1] + 1)
    following[first[1:] - 1] = first[:-1]
    return following
