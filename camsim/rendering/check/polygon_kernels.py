"""Arcs cut into sides, for the check; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel


class _Cut(NamedTuple):
    """How an arc is cut: whether it is a whole circle, how many sides it has, and how long they may be at the most.

    side  : where nothing ends;  first: at an end of a part
    times : what the sides of a part are multiplied by, so that both of its halves end in its middle
    """

    whole: bool
    sides: int
    side: float
    first: float
    times: float


@kernel()
def _cut(radius: float, turn_rad: float, far: float, fine: tuple[float, float, bool]) -> _Cut:
    """Cut a circle or a part of one, whose halves are the same from either end; far: sides are so long, 0: not known.

    Each side of a part has its arc's area, but the first lean on their arcs: s³/36R of area lies on the wrong side of
    their middles. On a square wave that keeps below what is allowed.
    """
    longest, allowed, textured = fine
    if far > 0.0:
        pairs = max(1, math.ceil(0.5 * turn_rad * radius / far))
        return _Cut(False, 2 * pairs, 0.5 * turn_rad * radius / pairs, 0.0, 1.0)
    whole = turn_rad >= math.tau * (1.0 - 1e-15)
    side = min((0.7 if whole else 0.35) * longest, (229.0 * allowed * (radius * longest) ** 2) ** 0.25)
    if textured:
        side = min(side, (12.0 * allowed * radius * longest**2) ** (1.0 / 3.0))
    if whole:
        return _Cut(True, max(96, math.ceil(math.tau * radius / side)), side, 0.0, 1.0)
    first = min((6.0 * allowed * radius * longest**3) ** 0.25, (36.0 * radius * allowed * longest**2) ** (1.0 / 3.0))
    cut = _Cut(False, 0, side, first, 1.0)
    length, sides, half = 0.0, 0, 0.5 * turn_rad * radius
    while length < half:
        length += _next(length, radius, 2.0 * half, fine, cut)
        sides += 1
    return _Cut(False, 2 * sides, side, first, half / length)


@kernel()
def _next(length: float, radius: float, whole: float, fine: tuple[float, float, bool], cut: _Cut) -> float:
    """Return a part's next side after so much of its length: as long as is right in its middle.

    A whole circle's sides are all alike and send nothing below their own frequency. A part's send 1/288 of how s⁴/R
    bends: that is kept below what is allowed of a long wave, and at an end below what is of a square one.
    """
    longest, allowed, _ = fine
    if cut.first == 0.0:
        return cut.side
    side = 0.0
    for _ in range(2):
        over = 1.0 / cut.side**4
        for away in (length + 0.5 * side, max(whole - length - 0.5 * side, 0.0)):
            over += 1.0 / (cut.first**4 + 72.0 * radius * allowed * longest * away * (longest + away))
        side = over**-0.25
    return side


@kernel()
def count_sides(arcs: F64, fine: tuple[float, float, bool], counts: I64) -> None:
    """Write how many sides arcs are cut into."""
    for e in range(len(arcs)):
        counts[e] = _cut(arcs[e, 2], arcs[e, 4], arcs[e, 5], fine).sides


@kernel(allocates=True)
def draw_sides(arcs: F64, fine: tuple[float, float, bool], sides: F64) -> None:
    """Write the sides (n, 4) of arcs: centre (x, y), radius, begin and turn of each, and how long its sides are.

    How far corners lie from the centre, where sides have their arcs' areas: rᵢ·rᵢ₊₁·sin θ = θ, all the same on a whole
    circle; a part's ends stay where other pieces meet them, and its middle is met from both.
    """
    n = 0
    for e in range(len(arcs)):
        x, y, radius, from_rad, turn_rad, far = arcs[e]
        cut = _cut(radius, turn_rad, far, fine)
        # From either end, so that the last corner is where the arc ends, to its last bit.
        angles, out = np.empty(cut.sides + 1), np.ones(cut.sides + 1)
        angles[0], angles[-1] = from_rad, from_rad + turn_rad
        if cut.whole:
            step = turn_rad / cut.sides
            for k in range(1, cut.sides):
                angles[k] = from_rad + k * step
            out[:] = math.sqrt(step / math.sin(step))
        else:
            length = 0.0
            for k in range(cut.sides // 2):
                side = _next(length, radius, radius * turn_rad, fine, cut)
                length += side
                turn, turned = cut.times * side / radius, cut.times * length / radius
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
