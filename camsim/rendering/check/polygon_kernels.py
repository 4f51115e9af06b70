"""Arcs cut into sides, for the check; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel

GROWTH = 1.3  # of a part's sides from its ends on


class _Cut(NamedTuple):
    """How an arc is cut: whether it is a whole circle, how many sides it has, and of a part's halves these.

    first, growing : the first side's length, and how many grow from it;  rest: of the others
    """

    whole: bool
    sides: int
    first: float
    growing: int
    rest: float


@kernel()
def _cut(radius: float, turn_rad: float, fine: tuple[float, float, bool]) -> _Cut:
    """Cut a circle or a part of one, whose halves are the same from either end.

    Each side of a part has its arc's area, but the first lean on their arcs: s³/36R of area lies on the wrong side of
    their middles, and s⁴/96R of its moment wherever sides grow. On a square wave, and on its cube, that keeps below
    what is allowed. A whole circle's sides are all alike and send nothing below their own frequency; a part's are not.
    """
    longest, allowed, textured = fine
    whole = turn_rad >= math.tau * (1.0 - 1e-15)
    side = min((0.7 if whole else 0.35) * longest, (229.0 * allowed * (radius * longest) ** 2) ** 0.25)
    if textured:
        side = min(side, (12.0 * allowed * radius * longest**2) ** (1.0 / 3.0))
    if whole:
        return _Cut(True, max(96, math.ceil(math.tau * radius / side)), 0.0, 0, 0.0)
    half = 0.5 * turn_rad * radius
    side = min(side, (96.0 * allowed * radius * longest**3) ** 0.25)
    first = min(side, (36.0 * radius * allowed * longest**2) ** (1.0 / 3.0))
    most = math.ceil(math.log(side / first) / math.log(GROWTH)) + 1
    growing, length = 0, 0.0
    while growing < most and length + first * GROWTH**growing < half:
        length += first * GROWTH**growing
        growing += 1
    more = max(1, math.ceil((half - length) / side))
    return _Cut(False, 2 * (growing + more), first, growing, (half - length) / more)


@kernel()
def count_sides(arcs: F64, fine: tuple[float, float, bool], counts: I64) -> None:
    """Write how many sides arcs are cut into."""
    for e in range(len(arcs)):
        counts[e] = _cut(arcs[e, 2], arcs[e, 4], fine).sides


@kernel(allocates=True)
def draw_sides(arcs: F64, fine: tuple[float, float, bool], sides: F64) -> None:
    """Write the sides (n, 4) of arcs: centre (x, y), radius, begin and turn of each.

    How far corners lie from the centre, where sides have their arcs' areas: rᵢ·rᵢ₊₁·sin θ = θ, all the same on a whole
    circle; a part's ends stay where other pieces meet them, and its middle is met from both.
    """
    n = 0
    for e in range(len(arcs)):
        x, y, radius, from_rad, turn_rad = arcs[e]
        cut = _cut(radius, turn_rad, fine)
        # From either end, so that the last corner is where the arc ends, to its last bit.
        angles, out = np.empty(cut.sides + 1), np.ones(cut.sides + 1)
        angles[0], angles[-1] = from_rad, from_rad + turn_rad
        if cut.whole:
            step = turn_rad / cut.sides
            for k in range(1, cut.sides):
                angles[k] = from_rad + k * step
            out[:] = math.sqrt(step / math.sin(step))
        else:
            turned = 0.0
            for k in range(cut.sides // 2):
                turn = (cut.first * GROWTH**k if k < cut.growing else cut.rest) / radius
                turned += turn
                angles[k + 1], angles[-k - 2] = from_rad + turned, from_rad + turn_rad - turned
                out[k + 1] = turn / math.sin(turn) / out[k]
                out[-k - 2] = out[k + 1]
        for k in range(cut.sides):
            sides[n, 0], sides[n, 1] = (
                x + radius * out[k] * math.cos(angles[k]),
                y + radius * out[k] * math.sin(angles[k]),
            )
            if k > 0:
                sides[n - 1, 2:] = sides[n, :2]
            n += 1
        last = 0 if cut.whole else cut.sides
        sides[n - 1, 2] = x + radius * out[last] * math.cos(angles[last])
        sides[n - 1, 3] = y + radius * out[last] * math.sin(angles[last])
