"""Parts of rims as straight sides: each with its arc's area, and no farther from it at its ends than in its middle.

Sides of one length lie on a circle a little larger than theirs: two radii and a side of it have the sector's area,
r²·φ/2 = R²·sin(φ)/2. Where a part begins and ends, and where sides of another length follow, a step leads from the one
circle to the other: it lies on a radius and takes no area from a sector. So nothing is left over at the ends but what
ends there: wobbles whose second moments, s⁵/720r each, no longer cancel. They leave s⁴/720r times the slope of the
pattern, and this twice, for either end.
"""

from __future__ import annotations

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene.curves import ARC, Curves
from camsim.scene.rims import Rims
from camsim.scene.side_limits import MOST_TURN, SideLimits, judge_sides
from camsim.scene.stretches import Apart, Stretches, stretches

TOGETHER = 4096  # parts that are laid out at a time: memory for few numbers beyond the sides themselves
STEP = 1e-12  # of the radius: shorter ones are rounding


def sides_of(rims: Rims, limits: SideLimits, apart: Apart | None) -> tuple[I64, F64, F64]:
    """Return the sides of open parts: whose (n,), and their starts and ends (n, 2)."""
    found = [
        _laid(rims.some(np.arange(k, min(k + TOGETHER, len(rims.disc)))), limits, apart)
        for k in range(0, len(rims.disc), TOGETHER)
    ]
    whose = [part[0] + k * TOGETHER for k, part in enumerate(found)]
    return (
        np.concatenate([np.empty(0, np.int64), *whose]),
        np.concatenate([np.empty((0, 2)), *(part[1] for part in found)]),
        np.concatenate([np.empty((0, 2)), *(part[2] for part in found)]),
    )


def _laid(rims: Rims, limits: SideLimits, apart: Apart | None) -> tuple[I64, F64, F64]:
    found = stretches(_curves(rims), apart)
    side = limits.end_um(found.radius_um)
    if limits.longer is not None:
        side = np.maximum(side, limits.longer(found.place_um, found.radius_um, found.length_um))
    side = np.minimum(side, MOST_TURN * found.radius_um)
    judge_sides(float(np.sum(found.length_um / side)))
    count = np.ceil(found.length_um / side - 1e-9).astype(np.int64)
    owner, corners = _corners(rims, found, count)
    # Each part from its own start to its own end.
    first = np.searchsorted(owner, np.arange(len(rims.disc)))
    corners, owner = np.insert(corners, first, rims.start_um, axis=0), np.insert(owner, first, np.arange(len(first)))
    last = np.append(np.searchsorted(owner, np.arange(1, len(first))), len(owner))
    corners, owner = np.insert(corners, last, rims.end_um, axis=0), np.insert(owner, last, np.arange(len(first)))
    same = owner[1:] == owner[:-1]
    return owner[:-1][same], corners[:-1][same], corners[1:][same]


def _corners(rims: Rims, found: Stretches, count: I64) -> tuple[I64, F64]:
    """Return corners (n, 2) along all stretches, and whose they are."""
    turn = rims.turn_rad[found.owner] * (found.t1 - found.t0)
    each = turn / count
    radius = rims.radius_um[found.owner] * np.sqrt(each / np.sin(each))
    # A stretch begins with a corner of its own where sides of another length come before it.
    step = np.ones(len(count), bool)
    step[1:] = np.abs(np.diff(radius)) > STEP * radius[1:]
    step[1:] |= found.owner[1:] != found.owner[:-1]
    times = count + step
    part = np.repeat(np.arange(len(count)), times)
    number = np.arange(len(part)) - np.repeat(np.cumsum(times) - times, times) + ~step[part]
    owner = found.owner[part]
    angle = rims.from_rad[owner] + rims.turn_rad[owner] * found.t0[part] + number * each[part]
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return owner, rims.centre_um[owner] + radius[part][:, None] * way


def _curves(rims: Rims) -> Curves:
    """Return the parts as arcs."""
    count = len(rims.disc)
    ends = [rims.from_rad, rims.from_rad + rims.turn_rad]
    out = [rims.radius_um[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1) for angle in ends]
    across = np.stack([-out[0][:, 1], out[0][:, 0]], axis=1)
    points = np.stack([rims.centre_um + out[0], out[0], across, rims.centre_um + out[1]], axis=1)
    return Curves(points, rims.turn_rad, np.full(count, ARC), np.zeros(1, np.int64))
