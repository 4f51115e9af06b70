"""What is seen of shapes in painter's order: outlines cut where they meet, and a winding test on both sides of a piece.

No polygon is ever clipped or joined. Every outline (polygon or circle) is cut where any other meets it; what lies just
to the left and right of each piece is the last shape that winds round that point. Outlines that run along each other
make one piece.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

SAME = 4e-13  # of the coordinates: places this near each other are one


@dataclass(frozen=True)
class Piece:
    """A straight piece from ``start`` to ``end``, or an arc about ``centre`` from angle ``first`` to ``last``.

    left  : index of the shape that lies where cross(direction, x − start) is above 0, −1: background
    right : the same on the other side
    """

    start: tuple[float, float]
    end: tuple[float, float]
    left: int
    right: int
    centre: tuple[float, float] | None = None
    radius: float = 0.0
    first: float = 0.0
    last: float = 0.0


class Segment:
    """A side of a polygon."""

    def __init__(self, a, b):
        self.a, self.b = np.array(a, float), np.array(b, float)
        self.length = float(np.hypot(*(self.b - self.a)))

    def at(self, t):
        return self.a + t * (self.b - self.a)

    def distance(self, point):
        t = np.clip(np.dot(point - self.a, self.b - self.a) / self.length**2, 0.0, 1.0)
        return float(np.hypot(*(self.at(t) - point)))

    def normal(self, t):
        """To the left of the direction, in the sense of the cross product."""
        e = (self.b - self.a) / self.length
        return np.array([-e[1], e[0]])

    def piece(self, t, u, left, right):
        return Piece(tuple(self.at(t)), tuple(self.at(u)), left, right)


class Circle:
    """A whole circle, from angle 0 to 2π; inside is to its left."""

    def __init__(self, centre, radius):
        self.centre, self.radius = np.array(centre, float), float(radius)
        self.length = 2.0 * math.pi * self.radius

    def at(self, t):
        a = 2.0 * math.pi * t
        return self.centre + self.radius * np.array([math.cos(a), math.sin(a)])

    def distance(self, point):
        return abs(float(np.hypot(*(point - self.centre))) - self.radius)

    def normal(self, t):
        a = 2.0 * math.pi * t
        return -np.array([math.cos(a), math.sin(a)])

    def parameter(self, point):
        d = point - self.centre
        return (math.atan2(d[1], d[0]) / (2.0 * math.pi)) % 1.0

    def piece(self, t, u, left, right):
        first, last = 2.0 * math.pi * t, 2.0 * math.pi * u
        return Piece(tuple(self.at(t)), tuple(self.at(u)), left, right, tuple(self.centre), self.radius, first, last)


def outline(shape):
    """Sides of a shape of a specification: in either direction, as its points are given."""
    if shape["kind"] == "disc":
        return [Circle(shape["centre"], shape["radius"])]
    points = corners(shape)
    pairs = zip(points, np.roll(points, -1, axis=0), strict=True)
    return [Segment(a, b) for a, b in pairs if np.hypot(*(b - a)) > 0.0]


def corners(shape):
    """Corners (n, 2) of a polygon or a rectangle; ``rotate_deg`` turns x towards y."""
    if shape["kind"] == "polygon":
        return np.array(shape["points"], float)
    a = math.radians(shape.get("rotate_deg", 0.0))
    across = 0.5 * shape["width"] * np.array([math.cos(a), math.sin(a)])
    down = 0.5 * shape["height"] * np.array([-math.sin(a), math.cos(a)])
    return np.array(shape["centre"], float) + np.array([-across - down, across - down, across + down, down - across])


def inside(shape, point):
    """Whether a shape winds round a point."""
    if shape["kind"] == "disc":
        return float(np.hypot(point[0] - shape["centre"][0], point[1] - shape["centre"][1])) < shape["radius"]
    p = corners(shape) - point
    q = np.roll(p, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    up = (p[:, 1] <= 0.0) & (q[:, 1] > 0.0) & (cross > 0.0)
    down = (p[:, 1] > 0.0) & (q[:, 1] <= 0.0) & (cross < 0.0)
    return int(np.count_nonzero(up)) != int(np.count_nonzero(down))


def seen(shapes, point):
    """Index of the last shape that covers a point, −1 where none does."""
    for k in range(len(shapes) - 1, -1, -1):
        if inside(shapes[k], point):
            return k
    return -1


def pieces(shapes):
    """All pieces of outline with different shapes on their two sides."""
    sides = [(k, side) for k, shape in enumerate(shapes) for side in outline(shape)]
    boxes = np.array([_box(side) for _, side in sides]).reshape(-1, 4)
    found = []
    for i, (k, side) in enumerate(sides):
        scale = float(np.abs(boxes[i]).max())
        near = SAME * scale
        # What shares a box with this side, and may cut it, lie along it or come close to it.
        meets = np.flatnonzero(
            (boxes[:, 0] <= boxes[i, 2] + near)
            & (boxes[:, 2] >= boxes[i, 0] - near)
            & (boxes[:, 1] <= boxes[i, 3] + near)
            & (boxes[:, 3] >= boxes[i, 1] - near)
        )
        others = [(j, sides[j][1]) for j in meets if sides[j][0] != k]
        cuts = {t for _, other in others for t in _cuts(side, other, near)}
        if isinstance(side, Circle):
            cuts = sorted({t % 1.0 for t in cuts} or {0.0})
            cuts.append(cuts[0] + 1.0)
        else:
            cuts = sorted({0.0, 1.0} | {t for t in cuts if 0.0 < t < 1.0})
        for t, u in pairwise(cuts):
            if (u - t) * side.length <= 4.0 * near:
                continue
            left_right = _sides(shapes, sides, i, side, t, u, near)
            if left_right is not None:
                found.append(side.piece(t, u, *left_right))
    return found


def _sides(shapes, sides, own, side, begin, end, near):
    """What lies left and right of a piece; None where it is the same, or another outline's piece says it."""
    # In the middle another outline may just touch: then it is asked elsewhere. What runs along does so everywhere.
    places = [(1.0 - part) * begin + part * end for part in (0.5, 0.382, 0.7)]
    gaps = [[other.distance(side.at(t)) for j, (_, other) in enumerate(sides) if j != own] for t in places]
    k = int(np.argmin([sum(gap <= 4.0 * near for gap in each) for each in gaps]))
    t, step = places[k], 0.05 * (end - begin) * side.length
    middle = side.at(t)
    for j, gap in zip([j for j in range(len(sides)) if j != own], gaps[k], strict=True):
        if gap > 4.0 * near:
            step = min(step, 0.25 * gap)
        elif j < own:
            return None
    if isinstance(side, Circle):
        step = min(step, 0.25 * side.radius)
    normal = side.normal(t)
    left, right = seen(shapes, middle + step * normal), seen(shapes, middle - step * normal)
    return None if left == right else (left, right)


def _box(side):
    if isinstance(side, Circle):
        return [*(side.centre - side.radius), *(side.centre + side.radius)]
    return [*np.minimum(side.a, side.b), *np.maximum(side.a, side.b)]


def _cuts(side, other, near):
    """Parameters on ``side`` where ``other`` meets it or ends on it."""
    if isinstance(side, Segment):
        if isinstance(other, Segment):
            yield from _segment_segment(side, other, near)
        else:
            yield from _segment_circle(side, other)
        return
    if isinstance(other, Segment):
        for u in _segment_circle(other, side):
            if -1e-15 <= u <= 1.0 + 1e-15:
                yield side.parameter(other.at(u))
        for end in (other.a, other.b):
            if side.distance(end) <= near:
                yield side.parameter(end)
    else:
        yield from _circle_circle(side, other)


def _segment_segment(side, other, near):
    d, e = side.b - side.a, other.b - other.a
    for end in (other.a, other.b):
        if side.distance(end) <= near:
            yield float(np.dot(end - side.a, d)) / side.length**2
    cross = d[0] * e[1] - d[1] * e[0]
    if abs(cross) <= 1e-14 * side.length * other.length:
        return
    gap = other.a - side.a
    t = (gap[0] * e[1] - gap[1] * e[0]) / cross
    u = (gap[0] * d[1] - gap[1] * d[0]) / cross
    if -1e-15 <= u <= 1.0 + 1e-15:
        yield float(t)


def _segment_circle(side, circle):
    """Parameters on a segment's line where a circle meets it."""
    d, gap = (side.b - side.a) / side.length, side.a - circle.centre
    foot = float(np.dot(gap, d))
    height = float(gap[0] * d[1] - gap[1] * d[0])
    square = (circle.radius - height) * (circle.radius + height)
    if square >= 0.0:
        yield from ((-foot + sign * math.sqrt(square)) / side.length for sign in (-1.0, 1.0))


def _circle_circle(side, other):
    gap = other.centre - side.centre
    apart = float(np.hypot(*gap))
    if not abs(side.radius - other.radius) < apart < side.radius + other.radius:
        return
    along = (apart**2 + side.radius**2 - other.radius**2) / (2.0 * apart)
    half = math.acos(min(max(along / side.radius, -1.0), 1.0))
    angle = math.atan2(gap[1], gap[0])
    yield from (((angle + sign * half) / (2.0 * math.pi)) % 1.0 for sign in (-1.0, 1.0))
