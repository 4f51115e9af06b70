"""Closed outlines of straight, cubic and elliptical pieces, all in a few arrays; linear maps move points only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64

STRAIGHT, CUBIC, ARC = 0, 1, 2
ROUNDING = 1e-13  # of a coordinate: gaps between pieces up to here are rounding
ROUND = 1e-12  # largest relative difference of half axes of a circle


class Curves(NamedTuple):
    """Pieces of closed outlines, one loop after the other; each ends where the next of its loop begins.

    points   : (n, 4, 2) x, y in µm: start, two more, end. The two are a cubic's control points; of an arc they are the
               vectors u, v of two half axes, start − u is its centre and centre + u·cos φ + v·sin φ runs along it
    turn_rad : (n,) for an arc, the range of φ from 0 on
    kind     : (n,) STRAIGHT, CUBIC or ARC
    first    : (loops + 1,) index of the first piece of each loop
    """

    points: F64
    turn_rad: F64
    kind: I64
    first: I64

    def moved(self, matrix: F64) -> Curves:
        """Return the curves transformed by x, y → matrix · (x, y, 1); matrix (2, 3)."""
        return self._replace(points=np.einsum("ij,nkj->nki", matrix[:, :2], self.points)).shifted(matrix[:, 2])

    def shifted(self, by_um: F64) -> Curves:
        """Return the curves translated by a vector."""
        places, arcs = self.points + by_um, self.kind == ARC
        if arcs.any():
            places[arcs, 1:3] = self.points[arcs, 1:3]
        return self._replace(points=places)

    def some(self, which: I64 | np.ndarray) -> Curves:
        """Return the selected pieces, without loops."""
        return Curves(self.points[which], self.turn_rad[which], self.kind[which], np.zeros(1, np.int64))

    def loops(self, which: Sequence[int]) -> Curves:
        """Return the selected loops."""
        pieces = np.concatenate([np.arange(self.first[loop], self.first[loop + 1]) for loop in which])
        first = np.cumsum([0, *np.diff(self.first)[list(which)]])
        return self.some(pieces)._replace(first=first)

    def at(self, t: F64) -> F64:
        """Return points (n, 2), one on each piece, at parameters t (n,) in 0..1."""
        p = self.points
        places: F64 = p[:, 0] + t[:, None] * (p[:, 3] - p[:, 0])
        # Each kind separately: many scenes have only one.
        if (which := np.flatnonzero(self.kind == CUBIC)).size:
            (a, b, c, d), u = _columns(p, which), t[which]
            s = 1.0 - u
            places[which] = (s * s * s * a + 3.0 * s * s * u * b + 3.0 * s * u * u * c + u * u * u * d).T
        if (which := np.flatnonzero(self.kind == ARC)).size:
            start, x, y, _ = p[which].transpose(1, 0, 2)
            phi = (self.turn_rad * t)[which, None]
            places[which] = start - x + x * np.cos(phi) + y * np.sin(phi)
        return places

    def slopes(self, t: F64) -> tuple[F64, F64]:
        """Return first and second derivatives (n, 2) by the parameter."""
        p = self.points
        first, second = p[:, 3] - p[:, 0], np.zeros((len(p), 2))
        if (which := np.flatnonzero(self.kind == CUBIC)).size:
            edges, u = np.diff(_columns(p, which), axis=0), t[which]
            a, b, c = edges
            first[which] = 3.0 * _slope(edges, u).T
            second[which] = (6.0 * ((1.0 - u) * (b - a) + u * (c - b))).T
        if (which := np.flatnonzero(self.kind == ARC)).size:
            turn, (x, y) = self.turn_rad[which, None], p[which, 1:3].transpose(1, 0, 2)
            cos, sin = np.cos(turn * t[which, None]), np.sin(turn * t[which, None])
            first[which], second[which] = turn * (y * cos - x * sin), -turn * turn * (x * cos + y * sin)
        return first, second

    def areas(self, t0: F64, t1: F64) -> F64:
        """Return the areas (n,) between pieces from t0 to t1 and their chords.

        Positive where they bulge away from the side on which the cross product is positive.
        """
        areas = np.zeros(len(t0))
        if (which := np.flatnonzero(self.kind == CUBIC)).size:
            edges, begin, end = np.diff(_columns(self.points, which), axis=0), t0[which], t1[which]
            one, middle, three = (_slope(edges, t) for t in (begin, 0.5 * (begin + end), end))
            # Simpson's rule is exact for the quadratic slopes' chord; the area needs one more product.
            areas[which] = 0.3 * (end - begin) ** 2 * cross((2.0 * middle + 0.5 * one).T, (three - one).T)
        if (which := np.flatnonzero(self.kind == ARC)).size:
            angle = self.turn_rad[which] * (t1 - t0)[which]
            # φ − sin φ without cancellation.
            square = angle * angle
            series = angle * square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
            segment = np.where(np.abs(angle) < 0.1, series, angle - np.sin(angle))
            areas[which] = 0.5 * cross(self.points[which, 1], self.points[which, 2]) * segment
        return areas

    @property
    def boxes(self) -> F64:
        """Bounding boxes (n, 4) of the pieces, possibly too large: low x, low y, high x, high y."""
        p = self.points
        arc = self.kind == ARC
        reach = np.where(arc[:, None], np.hypot(p[:, 1], p[:, 2]), 0.0)
        centre = np.where(arc[:, None], p[:, 0] - p[:, 1], p[:, 0])
        corners = np.where((self.kind == CUBIC)[:, None, None], p, p[:, [0, 0, 3, 3]])
        low = np.minimum(corners.min(axis=1), centre - reach)
        high = np.maximum(corners.max(axis=1), centre + reach)
        return np.concatenate([low, high], axis=1)

    @property
    def extent(self) -> F64:
        """The exact bounding box (4,) of all pieces: low x, low y, high x, high y."""
        inner = [self.at(t) for axis in (0, 1) for t in self.extremes(axis).T]
        every = np.concatenate([self.points[:, 0], self.points[:, 3], *inner])
        return np.concatenate([every.min(axis=0, initial=math.inf), every.max(axis=0, initial=-math.inf)])

    def extremes(self, axis: int) -> F64:
        """Return parameters (n, 3) of extrema of x or y, in order, 1 if none."""
        shares = np.ones((len(self.kind), 3))
        x = self.points[..., axis]
        if (cubic := np.flatnonzero(self.kind == CUBIC)).size:
            a, b, c = np.diff(x[cubic], axis=1).T
            square, half = a - 2.0 * b + c, a - b
            # The two roots of square·t² − 2·half·t + a, without cancellation.
            root = np.sqrt(np.maximum(half * half - square * a, 0.0))
            sum_ = half + np.where(half < 0.0, -root, root)
            for column, (over, under) in enumerate(((sum_, square), (a, sum_))):
                shares[cubic, column] = over / np.where(under == 0.0, np.inf, under)
        if (arc := np.flatnonzero(self.kind == ARC)).size:
            turn = self.turn_rad[arc]
            first = np.arctan2(x[arc, 2], x[arc, 1]) % np.pi
            for column in range(3):
                angle = first + column * np.pi
                shares[arc, column] = np.where(turn > 0.0, angle, np.pi * (column + 1) - first) / np.abs(turn)
        shares[~((shares > 0.0) & (shares < 1.0))] = 1.0
        return np.sort(shares, axis=1)

    @property
    def loop(self) -> I64:
        """Index of the loop of each piece (n,)."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))


def _columns(points: F64, which: I64) -> F64:
    """Return selected points (4, 2, n): long rows are several times faster than rows of two."""
    return np.ascontiguousarray(points[which].transpose(1, 2, 0))


def _slope(edges: F64, t: F64) -> F64:
    """Return a third of cubics' slopes (2, n), from the edges (3, 2, n) between their control points."""
    (a, b, c), s = edges, 1.0 - t
    slope: F64 = s * s * a + 2.0 * s * t * b + t * t * c
    return slope


def circles_among(curves: Curves) -> np.ndarray:
    """Return a mask of pieces that are parts of circles."""
    u, v = curves.points[:, 1], curves.points[:, 2]
    size = np.hypot(u[:, 0], u[:, 1])
    same = np.abs(np.hypot(v[:, 0], v[:, 1]) - size) <= ROUND * size
    square = np.abs(np.einsum("ij,ij->i", u, v)) <= ROUND * size * size
    circles: np.ndarray = (curves.kind == ARC) & same & square
    return circles


def cross(a: F64, b: F64) -> F64:
    """Return a.x·b.y − a.y·b.x of vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def joined(parts: Sequence[Curves]) -> Curves:
    """Return several Curves concatenated."""
    if len(parts) == 1:
        return parts[0]
    counts = np.cumsum([0, *(len(part.kind) for part in parts)])
    loops = [len(part.first) - 1 for part in parts]
    first = np.concatenate([np.empty(0, np.int64), *(part.first[:-1] for part in parts)])
    return Curves(
        np.concatenate([np.empty((0, 4, 2)), *(part.points for part in parts)]),
        np.concatenate([np.empty(0), *(part.turn_rad for part in parts)]),
        np.concatenate([np.empty(0, np.int64), *(part.kind for part in parts)]),
        np.append(first + np.repeat(counts[:-1], loops), counts[-1]),
    )


def through(corners: F64) -> Curves:
    """Return the closed polygon of corners (n, 2)."""
    count = len(corners)
    points = np.empty((count, 4, 2))
    points[:, 0] = points[:, 1] = corners
    points[:-1, 3], points[-1, 3] = corners[1:], corners[0]
    points[:, 2] = points[:, 3]
    return Curves(points, np.zeros(count), np.zeros(count, np.int64), np.array([0, count]))


def around(centre: Sequence[float] | F64, u: F64, v: F64) -> Curves:
    """Return a whole ellipse by the vectors of two half axes."""
    start = np.asarray(centre) + u
    return Curves(np.array([[start, u, v, start]]), np.array([math.tau]), np.array([ARC]), np.array([0, 1]))


class Pen:
    """Draws loops piece by piece, each from the end of the previous one; open loops are closed by a straight piece.

    Straight pieces and arcs whose length is zero or rounding are omitted: rounding differs between processors.
    """

    def __init__(self) -> None:
        self._points: list[tuple[tuple[float, float], ...]] = []
        self._turn: list[float] = []
        self._kind: list[int] = []
        self._first = [0]
        self.start = self.place = (0.0, 0.0)

    def move(self, x: float, y: float) -> None:
        """Close an open loop and begin a new one."""
        self.close()
        self.start = self.place = (x, y)

    def line(self, x: float, y: float) -> None:
        """Draw a straight piece to (x, y)."""
        if not self._is_at(x, y):
            self._add((self.place, self.place, (x, y), (x, y)), 0.0, STRAIGHT)

    def quadratic(self, x1: float, y1: float, x: float, y: float) -> None:
        """Draw a quadratic Bézier curve to (x, y), as a cubic."""
        x0, y0 = self.place
        one = (x0 + 2.0 / 3.0 * (x1 - x0), y0 + 2.0 / 3.0 * (y1 - y0))
        self.cubic(*one, x + 2.0 / 3.0 * (x1 - x), y + 2.0 / 3.0 * (y1 - y), x, y)

    def cubic(self, x1: float, y1: float, x2: float, y2: float, x: float, y: float) -> None:
        """Draw a cubic Bézier curve to (x, y)."""
        points = (self.place, (x1, y1), (x2, y2), (x, y))
        if len(set(points)) > 1:
            self._add(points, 0.0, CUBIC)

    def arc(self, rx: float, ry: float, rotate_deg: float, large: float, sweep: float, x: float, y: float) -> None:
        """Draw part of an ellipse, as SVG gives it (SVG 1.1, F.6.5): half axes too short are lengthened."""
        rx, ry = abs(rx), abs(ry)
        if (x, y) == self.place or (not large and self._is_at(x, y)) or rx == 0.0 or ry == 0.0:
            self.line(x, y)
            return
        x0, y0 = self.place
        c, s = math.cos(math.radians(rotate_deg)), math.sin(math.radians(rotate_deg))
        # In rotated units of the half axes: a circle of radius 1 through two points half a chord from its midpoint.
        px, py = (c * 0.5 * (x0 - x) + s * 0.5 * (y0 - y)) / rx, (c * 0.5 * (y0 - y) - s * 0.5 * (x0 - x)) / ry
        half = math.hypot(px, py)
        if half > 1.0:
            rx, ry, px, py, half = rx * half, ry * half, px / half, py / half, 1.0
        off = math.sqrt(max(0.0, 1.0 / (half * half) - 1.0)) * (-1.0 if bool(large) == bool(sweep) else 1.0)
        qx, qy = off * py, -off * px  # the centre
        begin, end = math.atan2(py - qy, px - qx), math.atan2(-py - qy, -px - qx)
        turn = (end - begin) % math.tau if sweep else -((begin - end) % math.tau)
        u, v = (math.cos(begin), math.sin(begin)), (-math.sin(begin), math.cos(begin))
        axes = [(c * rx * a - s * ry * b, s * rx * a + c * ry * b) for a, b in (u, v)]
        self._add((self.place, *axes, (x, y)), turn, ARC)

    def close(self) -> None:
        """Close the loop; the next one begins at its start."""
        self.line(*self.start)
        if len(self._kind) > self._first[-1]:
            self._first.append(len(self._kind))
        self.place = self.start

    def curves(self) -> Curves:
        """Return the drawn curves."""
        self.close()
        return Curves(
            np.array(self._points).reshape(-1, 4, 2),
            np.array(self._turn),
            np.array(self._kind, np.int64),
            np.array(self._first),
        )

    def _is_at(self, x: float, y: float) -> bool:
        """Return whether the pen is at (x, y), but for rounding."""
        return math.dist((x, y), self.place) <= ROUNDING * max(abs(x), abs(y))

    def _add(self, points: tuple[tuple[float, float], ...], turn: float, kind: int) -> None:
        self._points.append(points)
        self._turn.append(turn)
        self._kind.append(kind)
        self.place = points[3]
