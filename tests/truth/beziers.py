"""Cubic Bézier curves as pieces of outline: parts that run along x and along y one way only; where others meet them."""

from __future__ import annotations

from itertools import pairwise

import numba as nb
import numpy as np

DEPTH = 9  # halves of two curves, in whose boxes they may meet: then Newton says where


def dot(a, b):
    """Of two vectors in the plane. BLAS ends on another last bit on another processor, and a branch may hang on it."""
    return a[0] * b[0] + a[1] * b[1]


class Bezier:
    """A cubic of four points (4, 2), or a part of one."""

    whole = False

    def __init__(self, points):
        self.points = np.array(points, float)
        p, q, r, s = self.points
        self.powers = np.array([p, 3.0 * (q - p), 3.0 * (p - 2.0 * q + r), s - p + 3.0 * (q - r)])  # of t⁰ … t³
        self.slopes = self.powers[1:] * np.array([[1.0], [2.0], [3.0]])
        self.length = float(np.hypot(*np.diff(self.points, axis=0).T).sum())  # at the most
        self.a, self.b = p, s

    def at(self, t):
        c = self.powers
        return c[0] + t * (c[1] + t * (c[2] + t * c[3]))

    def slope(self, t):
        """dB/dt."""
        c = self.slopes
        return c[0] + t * (c[1] + t * c[2])

    def normal(self, t):
        """To the left of the direction, in the sense of the cross product."""
        d = self.slope(t)
        return np.array([-d[1], d[0]]) / np.hypot(*d)

    def radius(self, t):
        """Of the circle that it follows there."""
        d, e = self.slope(t), self.slopes[1] + 2.0 * t * self.slopes[2]
        return float(np.hypot(*d) ** 3 / max(abs(d[0] * e[1] - d[1] * e[0]), 1e-300))

    def part(self, t, u):
        """From one parameter to another."""
        each = self.points
        for share, keep_last in ((u, False), (t / u if u else 0.0, True)):
            rows, left, right = each, [each[0]], [each[-1]]
            while len(rows) > 1:
                rows = rows[:-1] + share * (rows[1:] - rows[:-1])
                left.append(rows[0])
                right.append(rows[-1])
            each = np.array(right[::-1] if keep_last else left)
        return Bezier(each)

    def one_way(self):
        """Parts along which neither x nor y turns back."""
        turns = {0.0, 1.0}
        for axis in (0, 1):
            turns |= {t for t in _roots(self.slopes[:, axis]) if 1e-9 < t < 1.0 - 1e-9}
        ends = sorted(turns)
        return [self.part(t, u) for t, u in pairwise(ends)]

    def parameter(self, point):
        """Where it is nearest to a point."""
        gap = self.powers.copy()
        gap[0] -= point
        steep = sum(np.convolve(gap[:, axis], self.slopes[:, axis]) for axis in (0, 1))
        places = [0.0, 1.0, *(t for t in _roots(steep) if 0.0 < t < 1.0)]
        best = min(places, key=lambda t: float(np.hypot(*(self.at(t) - point))))
        for _ in range(2):  # roots are known to fewer digits than places on the curve
            d = self.slope(best)
            if d.any():
                best = min(max(best + float(dot(point - self.at(best), d) / dot(d, d)), 0.0), 1.0)
        return best

    def distance(self, point):
        """To the nearest place of it."""
        return float(np.hypot(*(self.at(self.parameter(point)) - point)))


def _roots(powers):
    """Real roots of a polynomial by its powers from 0 on; what rounding leaves of high ones hides the others."""
    powers = np.trim_zeros(np.where(np.abs(powers) > 1e-13 * np.abs(powers).max(), powers, 0.0), "b")
    if powers.size < 2:
        return []
    found = np.polynomial.polynomial.polyroots(powers)
    return found.real[np.abs(found.imag) < 1e-6].tolist()


def on_line(curve, a, direction):
    """Parameters where a curve meets the line through a point."""
    gap = curve.powers - np.array([a, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)])
    height = direction[0] * gap[:, 1] - direction[1] * gap[:, 0]
    return [t for t in (_polished(height, t) for t in _roots(height)) if -1e-12 <= t <= 1.0 + 1e-12]


def on_ellipse(curve, arc):
    """Parameters where a curve meets the whole outline of an arc."""
    gap = curve.powers - np.array([arc.centre, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)])
    each = np.stack([dot(gap.T, arc.u), dot(gap.T, arc.v)], axis=1) / arc.axes**2
    square = sum(np.convolve(each[:, axis], each[:, axis]) for axis in (0, 1))
    square[0] -= 1.0
    return [t for t in (_polished(square, t) for t in _roots(square)) if -1e-12 <= t <= 1.0 + 1e-12]


def _polished(powers, t):
    """A root of a polynomial after some steps of Newton's."""
    slopes = np.polynomial.polynomial.polyder(powers)
    for _ in range(4):
        steep = np.polynomial.polynomial.polyval(t, slopes)
        if abs(steep) > 1e-12 * np.abs(powers).max():
            t -= float(np.polynomial.polynomial.polyval(t, powers) / steep)
    return t


def meets(curve, other):
    """Pairs of parameters where two curves meet that run one way each."""
    found = []
    for p, q in _close(curve.powers, other.powers):
        for _ in range(8):
            gap, d, e = curve.at(p) - other.at(q), curve.slope(p), other.slope(q)
            across = d[0] * e[1] - d[1] * e[0]
            if abs(across) < 1e-12 * max(np.abs(d).max(), np.abs(e).max()) ** 2:
                break
            p -= (gap[0] * e[1] - gap[1] * e[0]) / across
            q -= (gap[0] * d[1] - gap[1] * d[0]) / across
            if not (-1.0 < p < 2.0 and -1.0 < q < 2.0):
                break
        near = float(np.hypot(*(curve.at(p) - other.at(q)))) <= 1e-12 * (1.0 + np.abs(curve.points).max())
        if near and -1e-9 <= p <= 1.0 + 1e-9 and -1e-9 <= q <= 1.0 + 1e-9:
            found.append((float(p), float(q)))
    return found


@nb.njit(cache=True)
def _close(curve, other):
    """Middles of parts of two curves, by their powers, that share a box after so many halvings: (p, q)."""
    found = [(0.0, 0.0) for _ in range(0)]
    todo = [(0.0, 1.0, 0.0, 1.0, DEPTH)]
    while todo:
        t, u, s, v, depth = todo.pop()
        apart = False
        for axis in range(2):
            a, b, c, d = _on(curve, t, axis), _on(curve, u, axis), _on(other, s, axis), _on(other, v, axis)
            low, high = max(min(a, b), min(c, d)), min(max(a, b), max(c, d))
            apart = apart or low > high + 1e-13 * abs(high)
        if apart:
            continue
        m, n = 0.5 * (t + u), 0.5 * (s + v)
        if depth == 0:
            found.append((m, n))
            continue
        todo.append((m, u, n, v, depth - 1))
        todo.append((m, u, s, n, depth - 1))
        todo.append((t, m, n, v, depth - 1))
        todo.append((t, m, s, n, depth - 1))
    return found


@nb.njit(cache=True)
def _on(powers, t, axis):
    return powers[0, axis] + t * (powers[1, axis] + t * (powers[2, axis] + t * powers[3, axis]))


@nb.njit(cache=True)
def _level(powers, y, up):
    """x where a curve that runs one way along y comes to a level, by halving."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (_on(powers, middle, 1) <= y) == up:
            low = middle
        else:
            high = middle
    return _on(powers, 0.5 * (low + high), 0)


def outlines(shape):
    """Points (2 or 4, 2) of a path's sides in order: straight ones, and cubics; closed by straight lines."""
    for start, *segments in shape["outlines"]:
        at = np.array(start, float)
        for segment in [*segments, [start]]:
            points = np.array([at, *segment], float)
            if len(points) == 3:
                a, b, c = points
                points = np.array([a, a + 2.0 / 3.0 * (b - a), c + 2.0 / 3.0 * (b - c), c])
            at = points[-1]
            if np.abs(np.diff(points, axis=0)).max() > 0.0:
                yield points


def winds(sides, point):
    """How often outlines go round a point, by their sides, none of which turns back along x or y."""
    total = 0
    for side in sides:
        (ax, ay), (bx, by) = side.a, side.b
        if (ay <= point[1]) == (by <= point[1]) or max(ax, bx) <= point[0]:
            continue
        if min(ax, bx) <= point[0]:
            if isinstance(side, Bezier):
                x = _level(side.powers, point[1], by > ay)
            else:
                x = ax + (point[1] - ay) / (by - ay) * (bx - ax)
            if x <= point[0]:
                continue
        total += 1 if by > ay else -1
    return total
