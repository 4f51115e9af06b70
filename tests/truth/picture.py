"""What is seen of shapes in painter's order: outlines cut where they meet, and a winding test on both sides of a piece.

No polygon is ever clipped or joined. Every outline (sides, arcs of circles and ellipses, Bézier curves) is cut where
any other meets it; what lies just to the left and right of each piece is the last shape that covers that point, by the
shape's own definition. Outlines that run along each other make one piece.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import mpmath
import numba as nb
import numpy as np

from tests.truth import beziers
from tests.truth.beziers import Bezier, dot

SAME = 4e-13  # of the coordinates: places this near each other are one
ALONG = 4.0  # times as near: outlines there run along each other


@dataclass(frozen=True)
class Piece:
    """A straight piece from ``start`` to ``end``, or an arc centre + u·cos a + v·sin a from ``first`` up to ``last``,
    or a cubic Bézier curve of four ``points``.

    left  : index of the shape that lies where cross(direction, x − start) is above 0, −1: background
    right : the same on the other side
    """

    start: tuple[float, float]
    end: tuple[float, float]
    left: int
    right: int
    centre: tuple[float, float] | None = None
    u: tuple[float, float] = (0.0, 0.0)
    v: tuple[float, float] = (0.0, 0.0)
    first: float = 0.0
    last: float = 0.0
    points: tuple[tuple[float, float], ...] = ()

    @property
    def straight(self):
        return self.centre is None and not self.points

    @property
    def length(self):
        """At the most."""
        if self.points:
            return Bezier(self.points).length
        return math.dist(self.start, self.end) if self.centre is None else self.largest * (self.last - self.first)

    @property
    def largest(self):
        """Longest half axis of an arc."""
        return max(math.hypot(*self.u), math.hypot(*self.v))


class Segment:
    """A side of a polygon."""

    def __init__(self, a, b):
        self.a, self.b = np.array(a, float), np.array(b, float)
        self.length = float(np.hypot(*(self.b - self.a)))

    def at(self, t):
        return self.a + t * (self.b - self.a)

    def distance(self, point):
        t = np.clip(_along(self, point), 0.0, 1.0)
        return float(np.hypot(*(self.at(t) - point)))

    def normal(self, t):
        """To the left of the direction, in the sense of the cross product."""
        e = (self.b - self.a) / self.length
        return np.array([-e[1], e[0]])

    def piece(self, t, u, left, right):
        return Piece(tuple(self.at(t)), tuple(self.at(u)), left, right)


class Arc:
    """centre + u·cos a + v·sin a, from angle ``first`` up to ``last``; v at right angles to u, to its left."""

    def __init__(self, centre, u, v, first=0.0, last=2.0 * math.pi):
        self.centre, self.u, self.v = (np.array(p, float) for p in (centre, u, v))
        self.first, self.turn = first, last - first
        self.whole = abs(self.turn - 2.0 * math.pi) < 1e-12
        self.axes = np.array([np.hypot(*self.u), np.hypot(*self.v)])
        self.length = self.turn * float(self.axes.max())
        self.round = abs(self.axes[0] - self.axes[1]) <= 1e-15 * self.axes[0]

    def at(self, t):
        a = self.first + self.turn * t
        return self.centre + self.u * math.cos(a) + self.v * math.sin(a)

    def own(self, point):
        """The point in the frame in which the whole outline is the unit circle."""
        d = np.asarray(point, float) - self.centre
        return np.array([dot(d, self.u), dot(d, self.v)]) / self.axes**2

    def parameter(self, point):
        """Where on the outline the direction of a point lies; above 1: not on it, or just before its beginning."""
        x, y = self.own(point)
        t = ((math.atan2(y, x) - self.first) % (2.0 * math.pi)) / self.turn
        return t - 2.0 * math.pi / self.turn if (t - 1.0) * self.turn > math.pi else t

    def distance(self, point):
        """To the nearest place of it."""
        near = [self.parameter(point)] if self.round else self._feet(point)
        inside = [min(max(t, 0.0), 1.0) for t in (*near, 0.0, 1.0)]
        return min(float(np.hypot(*(self.at(t) - point))) for t in inside)

    def _feet(self, point):
        """Parameters at which the outline runs across the direction to a point: roots of a quartic in exp(ia)."""
        d, (a, b) = np.asarray(point, float) - self.centre, self.axes
        x, y = dot(d, self.u) / a, dot(d, self.v) / b
        # (b² − a²)·sin a·cos a + a·x·sin a − b·y·cos a = 0
        p, q = 0.25j * (a * a - b * b), 0.5 * (-1j * a * x - b * y)
        for z in np.roots([p, q, 0.0, np.conj(q), np.conj(p)]):
            yield ((float(np.angle(z)) - self.first) % (2.0 * math.pi)) / self.turn

    def normal(self, t):
        """To the left of the direction, in the sense of the cross product."""
        a = self.first + self.turn * t
        d = self.v * math.cos(a) - self.u * math.sin(a)
        return np.array([-d[1], d[0]]) / np.hypot(*d)

    def piece(self, t, u, left, right):
        first, last = self.first + self.turn * t, self.first + self.turn * u
        own = (tuple(float(v) for v in p) for p in (self.centre, self.u, self.v))
        return Piece(tuple(self.at(t)), tuple(self.at(u)), left, right, *own, first, last)


def circle(centre, radius, first=0.0, last=2.0 * math.pi):
    return Arc(centre, (radius, 0.0), (0.0, radius), first, last)


def outline(shape):
    """Sides and arcs of a shape of a specification, in any order and direction."""
    kind = shape["kind"]
    if kind == "disc":
        return [circle(shape["centre"], shape["radius"])]
    if kind == "ellipse":
        return [Arc(shape["centre"], *_axes(shape))]
    if kind == "ring":
        return [circle(shape["centre"], shape[which]) for which in ("radius", "inner")]
    if kind == "sector":
        return _sector(shape)
    if kind == "capsule":
        return _capsule(shape)
    if kind == "path":
        cubics = [p for p in beziers.outlines(shape) if len(p) == 4]
        lines = [Segment(*p) for p in beziers.outlines(shape) if len(p) == 2]
        return lines + [part for p in cubics for part in Bezier(p).one_way()]
    return _closed(corners(shape)) + [side for hole in shape.get("holes", ()) for side in _closed(np.array(hole))]


def _closed(points):
    pairs = zip(points, np.roll(points, -1, axis=0), strict=True)
    return [Segment(a, b) for a, b in pairs if np.hypot(*(b - a)) > 0.0]


def _axes(shape):
    a = math.radians(shape["rotate_deg"])
    return (
        shape["radii"][0] * np.array([math.cos(a), math.sin(a)]),
        shape["radii"][1] * np.array([-math.sin(a), math.cos(a)]),
    )


def _sector(shape):
    first = math.radians(shape["from_deg"])
    last = first + math.radians(shape["turn_deg"])
    arcs = [circle(shape["centre"], r, first, last) for r in (shape["radius"], shape["inner"]) if r > 0.0]
    inner = arcs[1] if len(arcs) > 1 else None
    centre = np.array(shape["centre"], float)
    return [*arcs, *(Segment(inner.at(t) if inner else centre, arcs[0].at(t)) for t in (0.0, 1.0))]


def _capsule(shape):
    """A line of one straight piece with round caps."""
    a, b = (np.array(p, float) for p in shape["points"])
    r, along = 0.5 * shape["width"], math.atan2(b[1] - a[1], b[0] - a[0])
    ends = [
        circle(b, r, along - 0.5 * math.pi, along + 0.5 * math.pi),
        circle(a, r, along + 0.5 * math.pi, along + 1.5 * math.pi),
    ]
    return [*ends, Segment(ends[0].at(1.0), ends[1].at(0.0)), Segment(ends[1].at(1.0), ends[0].at(0.0))]


def corners(shape):
    """Corners (n, 2) of a polygon or a rectangle; ``rotate_deg`` turns x towards y."""
    if shape["kind"] == "polygon":
        return np.array(shape["points"], float)
    a = math.radians(shape.get("rotate_deg", 0.0))
    across = 0.5 * shape["width"] * np.array([math.cos(a), math.sin(a)])
    down = 0.5 * shape["height"] * np.array([-math.sin(a), math.cos(a)])
    return np.array(shape["centre"], float) + np.array([-across - down, across - down, across + down, down - across])


def inside(shape, point):
    """Whether a shape covers a point, by its definition, and what clips it does."""
    if not all(inside(clip, point) for clip in shape.get("clips", ())):
        return False
    kind = shape["kind"]
    if kind == "path":
        turns = beziers.winds(shape.get("sides") or outline(shape), point)
        return turns % 2 == 1 if shape["rule"] == "evenodd" else turns != 0
    if kind == "ellipse":
        return float(np.hypot(*Arc(shape["centre"], *_axes(shape)).own(point))) < 1.0
    if kind == "capsule":
        return Segment(*shape["points"]).distance(np.asarray(point, float)) < 0.5 * shape["width"]
    if kind in ("disc", "ring", "sector"):
        x, y = point[0] - shape["centre"][0], point[1] - shape["centre"][1]
        within = shape.get("inner", -1.0) < math.hypot(x, y) < shape["radius"]
        turned = math.degrees(math.atan2(y, x)) - shape.get("from_deg", 0.0)
        return within and turned % 360.0 < shape.get("turn_deg", 361.0)
    rings = shape.get("rings") or _rings(shape)
    x, y = float(point[0]), float(point[1])
    return _winds(rings[0], x, y) and not any(_winds(hole, x, y) for hole in rings[1:])


def _rings(shape):
    """Corners of a polygon or a rectangle, and of its holes."""
    return [corners(shape), *(np.array(hole, float) for hole in shape.get("holes", ()))]


@nb.njit(cache=True)
def _winds(corners, x, y):
    """Whether a closed outline (n, 2) goes round a point."""
    total = 0
    for k in range(len(corners)):
        ax, ay = corners[k - 1, 0] - x, corners[k - 1, 1] - y
        bx, by = corners[k, 0] - x, corners[k, 1] - y
        cross = ax * by - ay * bx
        if ay <= 0.0 < by and cross > 0.0:
            total += 1
        if by <= 0.0 < ay and cross < 0.0:
            total -= 1
    return total != 0


def seen(shapes, point):
    """Index of the last shape that covers a point, −1 where none does."""
    for k in range(len(shapes) - 1, -1, -1):
        if inside(shapes[k], point):
            return k
    return -1


def pieces(shapes):
    """All pieces of outline with different shapes on their two sides."""
    shapes = [ready(shape) for shape in shapes]
    sides, alike = [], []  # with the shape of each, and of which others it is known that they do not cut it
    for k, shape in enumerate(shapes):
        for n, part in enumerate([shape, *shape.get("clips", ())]):
            for m, side in enumerate(outline(part)):
                sides.append((k, side))
                alike.append((k, n, m if part["kind"] == "path" else 0))
    boxes = np.array([_box(side) for _, side in sides]).reshape(-1, 4)
    scales = np.abs(boxes).max(axis=1, initial=0.0)
    lines = np.array([[*side.a, *side.b] if isinstance(side, Segment) else [math.nan] * 4 for _, side in sides])
    found = []
    for i, (_, side) in enumerate(sides):
        # Of two sides the larger says how near is the same, or only one of them would run along the other.
        near = SAME * np.maximum(scales, scales[i])
        # What shares a box with this side, and may cut it, lie along it or come close to it.
        meets = np.flatnonzero(
            (boxes[:, 0] <= boxes[i, 2] + near)
            & (boxes[:, 2] >= boxes[i, 0] - near)
            & (boxes[:, 1] <= boxes[i, 3] + near)
            & (boxes[:, 3] >= boxes[i, 1] - near)
        )
        others = [(j, sides[j][1]) for j in meets if alike[j] != alike[i]]
        cuts = {t for j, other in others for t in _cuts(side, other, ALONG * near[j])}
        if isinstance(side, Arc) and side.whole:
            cuts = sorted({t % 1.0 for t in cuts} or {0.0})
            cuts.append(cuts[0] + 1.0)
        else:
            cuts = sorted({0.0, 1.0} | {t for t in cuts if 0.0 < t < 1.0})
        for t, u in pairwise(cuts):
            if (u - t) * side.length <= ALONG * near[i]:
                continue
            left_right = _sides(shapes, sides, i, side, (t, u), near, boxes, lines)
            if left_right is not None:
                found.append(_piece(side, t, u, *left_right))
    return found


def ready(shape):
    """A shape with the sides of its paths and the corners of its polygons, which take a while to be made."""
    own = dict(shape)
    if shape["kind"] == "path":
        own["sides"] = outline(shape)
    if shape["kind"] in ("polygon", "rectangle"):
        own["rings"] = _rings(shape)
    return own | {"clips": [ready(clip) for clip in shape["clips"]]} if "clips" in shape else own


def _piece(side, t, u, left, right):
    if isinstance(side, Bezier):
        points = side.part(t, u).points
        ends = tuple(points[0]), tuple(points[-1])
        return Piece(*ends, left, right, points=tuple(map(tuple, points.tolist())))
    return side.piece(t, u, left, right)


def _sides(shapes, sides, own, side, stretch, near, boxes, lines):
    """What lies left and right of a piece; None where it is the same, or another outline's piece says it."""
    # In the middle another outline may just touch: then it is asked elsewhere. What runs along does so everywhere.
    begin, end = stretch
    places = [(1.0 - part) * begin + part * end for part in (0.5, 0.382, 0.7)]
    # What is farther than this changes no step.
    reach = 0.25 * (end - begin) * side.length
    gaps = []
    for t in places:
        at = side.at(t)
        gap = np.hypot(*np.maximum(np.maximum(boxes[:, :2] - at, at - boxes[:, 2:]), 0.0).T)
        close = np.flatnonzero(gap <= np.maximum(reach, ALONG * near))
        gap[close] = _from_lines(lines[close], at)
        for j in close[np.isnan(gap[close])]:
            gap[j] = sides[j][1].distance(at)
        gap[own] = math.inf
        gaps.append(gap)
        if np.all(gap > ALONG * near):
            break
    k = int(np.argmin([np.count_nonzero(each <= ALONG * near) for each in gaps]))
    t, step = places[k], 0.05 * (end - begin) * side.length
    middle = side.at(t)
    beside = gaps[k] > ALONG * near
    if not np.all(beside[:own]):
        return None
    step = min(step, 0.25 * float(gaps[k][beside].min(initial=math.inf)))
    if isinstance(side, Arc):
        step = min(step, 0.25 * float(side.axes.min() ** 2 / side.axes.max()))
    if isinstance(side, Bezier):
        step = min(step, 0.1 * side.radius(t))
    normal = side.normal(t)
    left, right = seen(shapes, middle + step * normal), seen(shapes, middle - step * normal)
    return None if left == right else (left, right)


def _from_lines(lines, point):
    """Distances of straight sides (a, b) from a point."""
    a, d = lines[:, :2], lines[:, 2:] - lines[:, :2]
    t = np.clip(np.sum((point - a) * d, axis=1) / np.sum(d * d, axis=1), 0.0, 1.0)
    return np.hypot(*(a + t[:, None] * d - point).T)


def _box(side):
    """Low x, low y, high x, high y; kept, for every other side asks."""
    if not hasattr(side, "known_box"):
        if isinstance(side, Arc):
            reach = np.hypot(side.u, side.v)
            low, high = side.centre - reach, side.centre + reach
        else:
            low, high = np.minimum(side.a, side.b), np.maximum(side.a, side.b)
        side.known_box = [*low.tolist(), *high.tolist()]
    return side.known_box


def _within(side, point, near):
    """Whether a side passes a point that near."""
    low_x, low_y, high_x, high_y = _box(side)
    outside = max(low_x - point[0], point[0] - high_x, low_y - point[1], point[1] - high_y)
    return outside <= near and side.distance(point) <= near


def _cuts(side, other, near):
    """Parameters on ``side`` where ``other`` meets it or ends on it."""
    if isinstance(side, Bezier) or isinstance(other, Bezier):
        yield from _with_a_curve(side, other, near)
        return
    if isinstance(side, Segment) and isinstance(other, Segment):
        yield from _segment_segment(side, other, near)
        return
    if isinstance(side, Segment):
        for t in _segment_arc(side, other):
            if other.whole or -1e-12 <= other.parameter(side.at(t)) <= 1.0 + 1e-12:
                yield t
        ends = () if other.whole else (other.at(0.0), other.at(1.0))
        yield from (_along(side, end) for end in ends if _within(side, end, near))
        return
    if isinstance(other, Segment):
        for u in _segment_arc(other, side):
            if -1e-15 <= u <= 1.0 + 1e-15:
                yield side.parameter(other.at(u))
        ends = (other.a, other.b)
    else:
        for t in _arc_arc(side, other):
            if other.whole or -1e-12 <= other.parameter(side.at(t)) <= 1.0 + 1e-12:
                yield t
        ends = () if other.whole else (other.at(0.0), other.at(1.0))
    yield from (side.parameter(end) for end in ends if _within(side, end, near))


def _with_a_curve(side, other, near):
    if not (isinstance(other, Arc) and other.whole):
        yield from (_parameter(side, end) for end in (other.at(0.0), other.at(1.0)) if _within(side, end, near))
    if isinstance(side, Bezier) and isinstance(other, Bezier):
        ways = (np.abs(side.points - points).max() for points in (other.points, other.points[::-1]))
        if min(ways) > near:  # or they are one curve: what clips several shapes
            yield from (t for t, _ in beziers.meets(side, other))
        return
    curve, plain = (side, other) if isinstance(side, Bezier) else (other, side)
    if isinstance(plain, Segment):
        places = beziers.on_line(curve, plain.a, plain.b - plain.a)
    else:
        places = beziers.on_ellipse(curve, plain)
    for t in places:
        u = _parameter(plain, curve.at(t))
        if -1e-12 <= u <= 1.0 + 1e-12 or (isinstance(plain, Arc) and plain.whole):
            yield t if curve is side else u


def _parameter(side, point):
    if isinstance(side, Segment):
        return _along(side, point)
    return side.parameter(point)


def _along(side, point):
    """The parameter of a point beside a straight side."""
    return float(dot(point - side.a, side.b - side.a)) / side.length**2


def _segment_segment(side, other, near):
    d, e = side.b - side.a, other.b - other.a
    for end in (other.a, other.b):
        if _within(side, end, near):
            yield _along(side, end)
    cross = d[0] * e[1] - d[1] * e[0]
    if abs(cross) <= 1e-14 * side.length * other.length:
        return
    gap = other.a - side.a
    t = (gap[0] * e[1] - gap[1] * e[0]) / cross
    u = (gap[0] * d[1] - gap[1] * d[0]) / cross
    if -1e-15 <= u <= 1.0 + 1e-15:
        yield float(t)


def _segment_arc(side, arc):
    """Parameters on a segment's line where the whole outline of an arc meets it."""
    if arc.round:
        d, gap, radius, length = (side.b - side.a) / side.length, side.a - arc.centre, arc.axes[0], side.length
    else:
        gap, b = arc.own(side.a), arc.own(side.b)
        length, radius = float(np.hypot(*(b - gap))), 1.0
        if length == 0.0:
            return  # shorter than the last bit of where it lies
        d = (b - gap) / length
    foot = float(dot(gap, d))
    height = float(gap[0] * d[1] - gap[1] * d[0])
    square = (radius - height) * (radius + height)
    if square >= 0.0:
        yield from ((-foot + sign * math.sqrt(square)) / length for sign in (-1.0, 1.0))


def _arc_arc(side, other):
    """Parameters on ``side`` where two whole circles or ellipses meet, to fifty digits: a rim of 10⁶ pitches is cut by
    another to parts of a pitch, at angles that doubles do not tell apart.

    On the unit circle of ``other`` lies x = c + ½(u − iv)·z + ½(u + iv)/z, z = exp(ia): x·x = 1 is a quartic, of two
    circles a quadratic.
    """
    with mpmath.workdps(50):
        centre, u, v, middle, across, up = (
            [mpmath.mpf(float(x)) for x in each]
            for each in (side.centre, side.u, side.v, other.centre, other.u, other.v)
        )
        squares = dot(across, across), dot(up, up)

        def own(vector):
            return [dot(vector, across) / squares[0], dot(vector, up) / squares[1]]

        c, u, v = own([a - b for a, b in zip(centre, middle, strict=True)]), own(u), own(v)
        w = [mpmath.mpc(a, -b) / 2 for a, b in zip(u, v, strict=True)]
        last, next_ = dot(w, w), 2 * dot(c, w)
        even = dot(c, c) + 2 * sum(abs(x) ** 2 for x in w) - 1
        polynomial = [last, next_, even, mpmath.conj(next_), mpmath.conj(last)]
        size = max(abs(x) for x in polynomial)
        if size <= 1e-12:
            return  # the same ellipse twice
        if abs(last) <= 1e-30 * size:  # of circles
            polynomial = polynomial[1:-1]
        if abs(polynomial[0]) <= 1e-30 * size:
            return  # about one centre
        for z in mpmath.polyroots(polynomial[::-1], maxsteps=500, extraprec=400, asc=True):
            if abs(abs(z) - 1) < 1e-10:
                yield ((float(mpmath.arg(z)) - side.first) % (2.0 * math.pi)) / side.turn
