"""Strokes as outlines: every piece of a path widened, and what joins and ends it.

All loops run the same way round, so that "nonzero" makes one of them where they overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from camsim.arrays import F64
from camsim.scene.curves import ARC
from camsim.scene.curves import Pen as Outline
from camsim.scene.svg.outline import Segment

_CLOSE = 1e-6  # of half the width: how far an outline may be off the true one
_MOST_CUTS = 12

Loop: TypeAlias = list[Segment]


@dataclass(frozen=True, slots=True)
class Pen:
    """How a stroke is drawn."""

    width: float
    cap: str = "butt"
    join: str = "miter"
    mitre_limit: float = 4.0


@dataclass(frozen=True, slots=True)
class _Piece:
    """A cubic (a straight piece has its points on a line): control points (4, 2), and directions at both ends."""

    points: F64
    begin: F64
    end: F64
    straight: bool


def stroked(segments: Sequence[Segment], pen: Pen) -> Loop:
    """Return the outline of a stroke, to be filled by "nonzero"; empty where it draws nothing."""
    loops: Loop = []
    for pieces, closed in _runs(segments):
        for piece in pieces:
            loops += _widened(piece, 0.5 * pen.width)
        follow = [*pieces[1:], pieces[0]] if closed else pieces[1:]
        for one, two in zip(pieces, follow, strict=False):
            loops += _joined(one.points[3], one.end, two.begin, pen)
        if not closed:
            loops += _capped(pieces[0].points[0], -pieces[0].begin, pen)
            loops += _capped(pieces[-1].points[3], pieces[-1].end, pen)
    return loops


def _runs(segments: Sequence[Segment]) -> Iterator[tuple[list[_Piece], bool]]:
    """Yield the pieces of each part of a path, and whether it is closed."""
    start = place = np.zeros(2)
    pieces: list[_Piece] = []
    dot = False
    for word, *numbers in [*segments, ("move", 0.0, 0.0)]:
        if word == "move":
            if pieces or dot:
                yield pieces or [_dot(place)], False
            pieces, start, dot = [], np.array(numbers), False
            place = start
            continue
        if word == "close":
            pieces += _straight(place, start)
            if pieces or dot:
                yield pieces or [_dot(place)], bool(pieces)
            pieces, place, dot = [], start, False
            continue
        to, dot = np.array(numbers[-2:]), True
        if word == "line":
            pieces += _straight(place, to)
        elif word == "quadratic":
            one = np.array(numbers[:2])
            pieces += _cubic(place, place + (one - place) / 1.5, to + (one - to) / 1.5, to)
        elif word == "cubic":
            pieces += _cubic(place, np.array(numbers[:2]), np.array(numbers[2:4]), to)
        else:
            pieces += _arc(place, numbers, to)
        place = to


def _dot(place: F64) -> _Piece:
    """Return a piece of no length: only its round or square ends are drawn."""
    right = np.array([1.0, 0.0])
    return _Piece(np.array([place] * 4), right, right, straight=True)


def _straight(place: F64, to: F64) -> list[_Piece]:
    step = to - place
    size = math.hypot(*step)
    if size == 0.0:
        return []
    return [_Piece(np.array([place, place + step / 3.0, to - step / 3.0, to]), step / size, step / size, straight=True)]


def _cubic(*corners: F64) -> list[_Piece]:
    points = np.array(corners)
    steps = [points[b] - points[a] for a, b in ((0, 1), (0, 2), (0, 3))]
    begin = next((step for step in steps if step.any()), None)
    if begin is None:
        return []
    end = next(step for step in (points[3] - points[k] for k in (2, 1, 0)) if step.any())
    return [_Piece(points, begin / math.hypot(*begin), end / math.hypot(*end), straight=False)]


def _arc(place: F64, numbers: Sequence[float], to: F64) -> list[_Piece]:
    """Return cubics along an arc, so many that they leave it by 1e-9 of its half axes."""
    outline = Outline()
    outline.move(*place)
    outline.arc(*numbers[:5], *to)
    curves = outline.curves()
    if not len(curves.kind) or curves.kind[0] != ARC:
        return _straight(place, to)
    start, u, v, _ = curves.points[0]
    turn, centre = float(curves.turn_rad[0]), start - u
    count = max(1, math.ceil(abs(turn) / math.radians(10.0)))
    step = turn / count
    handle = 4.0 / 3.0 * math.tan(0.25 * step)
    pieces = []
    for index in range(count):
        ends = []
        for angle in (index * step, (index + 1) * step):
            at = centre + u * math.cos(angle) + v * math.sin(angle)
            ends.append((at, handle * (v * math.cos(angle) - u * math.sin(angle))))
        (p, along), (q, onward) = ends
        pieces += _cubic(place if index == 0 else p, p + along, q - onward, to if index == count - 1 else q)
    return pieces


def _widened(piece: _Piece, half: float) -> Loop:
    """Return the outline of a piece between its two ends."""
    if piece.straight:
        side = half * _left(piece.begin)
        corners = [piece.points[0] + side, piece.points[0] - side, piece.points[3] - side, piece.points[3] + side]
        return _polygon(corners) if (piece.points[0] != piece.points[3]).any() else []
    if _folds(piece, half):
        return _swept(piece, half)
    there = _offset(piece, 0.0, 1.0, half, 0)
    back = [cubic[::-1] for cubic in reversed(_offset(piece, 0.0, 1.0, -half, 0))]
    loop: Loop = [("move", *there[0][0])]
    loop += [("cubic", *a, *b, *c) for _, a, b, c in there]
    loop.append(("line", *back[0][0]))
    loop += [("cubic", *a, *b, *c) for _, a, b, c in back]
    return [*loop, ("close",)]


def _folds(piece: _Piece, half: float) -> bool:
    """Return whether a cubic bends more sharply than half the width: its inner side would run backwards."""
    for t in np.linspace(0.0, 1.0, 65).tolist():
        direct = _beside(piece, t, 0.0)[1]
        for side in (half, -half):
            if not float(direct @ _beside(piece, t, side)[1]) > 0.0:
                return True
    return False


def _swept(piece: _Piece, half: float) -> Loop:
    """Return what a line across the curve sweeps, in steps of half a degree."""
    shares = np.linspace(0.0, 1.0, 257).tolist()
    ways = np.unwrap([math.atan2(*_beside(piece, t, 0.0)[1][::-1]) for t in shares])
    turned = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(ways)))])
    count = max(8, math.ceil(turned[-1] / math.radians(0.5)))
    cuts = np.interp(np.linspace(0.0, turned[-1], count + 1), turned, shares) if turned[-1] else shares
    sides = [[_beside(piece, t, side)[0] for side in (half, -half)] for t in np.asarray(cuts).tolist()]
    loop: Loop = []
    for one, two in pairwise(sides):
        corners = np.array([*one, *two])
        away = corners - corners.mean(axis=0)
        loop += _polygon(corners[np.argsort(np.arctan2(away[:, 1], away[:, 0]))])
    return loop


def _offset(piece: _Piece, begin: float, end: float, half: float, cuts: int) -> list[F64]:
    """Return cubics that run beside one at a distance: with its places and slopes at their ends, cut until they are."""
    places, slopes = zip(*(_beside(piece, t, half) for t in (begin, end)), strict=True)
    third = (end - begin) / 3.0
    cubic = np.array([places[0], places[0] + third * slopes[0], places[1] - third * slopes[1], places[1]])
    middle = 0.5 * (begin + end)
    shares = [(0.25, 0.75 * begin + 0.25 * end), (0.5, middle), (0.75, 0.25 * begin + 0.75 * end)]
    off = max(float(np.hypot(*(_at(cubic, s) - _beside(piece, t, half)[0]))) for s, t in shares)
    if off <= _CLOSE * abs(half) or cuts == _MOST_CUTS:
        return [cubic]
    return [*_offset(piece, begin, middle, half, cuts + 1), *_offset(piece, middle, end, half, cuts + 1)]


def _beside(piece: _Piece, t: float, half: float) -> tuple[F64, F64]:
    """Return the place beside a cubic at ``t``, to its left where ``half`` is above 0, and how fast it moves with t."""
    p = piece.points
    s = 1.0 - t
    at = _at(p, t)
    slope = 3.0 * (s * s * (p[1] - p[0]) + 2.0 * s * t * (p[2] - p[1]) + t * t * (p[3] - p[2]))
    bend = 6.0 * (s * (p[2] - 2.0 * p[1] + p[0]) + t * (p[3] - 2.0 * p[2] + p[1]))
    speed = math.hypot(*slope)
    if speed < 1e-9 * float(np.abs(p - p[0]).max()):
        return at + half * _left(piece.begin if t < 0.5 else piece.end), slope
    turning = (slope[0] * bend[1] - slope[1] * bend[0]) / speed**3
    return at + half * _left(slope / speed), slope * (1.0 + half * turning)


def _joined(place: F64, one: F64, two: F64, pen: Pen) -> Loop:
    """Return what fills the gap at the outside of a corner."""
    half, turn = 0.5 * pen.width, float(one[0] * two[1] - one[1] * two[0])
    same = float(one[0] * two[0] + one[1] * two[1])
    if abs(turn) < 1e-12 and same > 0.0:
        return []
    if pen.join == "round":
        return _disc(place, half)
    out = half if turn < 0.0 else -half
    first, second = place - out * _left(one), place - out * _left(two)
    corners = [place, first, second]
    # The tip lies 1/sin(half the angle between the sides) half widths away.
    sine = math.sqrt(max(0.0, 0.5 * (1.0 + same)))
    if pen.join.startswith("miter") and sine * pen.mitre_limit >= 1.0:
        tip = 0.5 * (first + second) - place
        corners.insert(2, place + tip / sine**2)
    return _polygon(corners)


def _capped(place: F64, away: F64, pen: Pen) -> Loop:
    """Return what an end has beyond it."""
    half = 0.5 * pen.width
    if pen.cap == "round":
        return _disc(place, half)
    if pen.cap != "square":
        return []
    side, beyond = half * _left(away), half * away
    return _polygon([place + side, place - side, place - side + beyond, place + side + beyond])


def _disc(place: F64, radius: float) -> Loop:
    x, y = place
    half = ("arc", radius, radius, 0.0, 0.0, 1.0)
    return [("move", x + radius, y), (*half, x - radius, y), (*half, x + radius, y), ("close",)]


def _polygon(corners: Sequence[F64]) -> Loop:
    """Return a polygon that runs as a disc does."""
    points = np.array(corners)
    x, y = (points - points[0]).T
    if float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) < 0.0:
        points = points[::-1]
    return [("line" if index else "move", *corner) for index, corner in enumerate(points.tolist())] + [("close",)]


def _left(direction: F64) -> F64:
    return np.array([direction[1], -direction[0]])


def _at(p: F64, t: float) -> F64:
    s = 1.0 - t
    place: F64 = s**3 * p[0] + 3.0 * s * s * t * p[1] + 3.0 * s * t * t * p[2] + t**3 * p[3]
    return place
