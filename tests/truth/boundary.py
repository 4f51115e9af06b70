"""Single photosites behind a round lens: two line integrals, and nothing else.

With ΔΦ = P, the lens's pattern, the share of a photosite A's light that comes from a region R is by Gauss's theorem,
used on both, −(1/|A|) ∮_∂R ∮_∂A Φ(|y − a|) n(y)·n(a) dt ds; for a point it is ∮_∂R n·(y − x) E(r)/(2πr²) ds, E the
encircled energy. Both integrands are as band-limited as the pattern, wherever a photosite lies on an edge, a corner or
an edge's extension: Gauss panels of a few lengths of the pattern are exact, and nothing has a kink to be aware of.

Beyond ``resolved`` what oscillates is left out (E is its power law), on panels that grow with the distance. The error
is found by computing everything twice, with other panels, borders, tables and another such distance.
"""

from __future__ import annotations

import functools
import math

import numba as nb
import numpy as np

from tests.truth import photosites
from tests.truth.beziers import Bezier
from tests.truth.pupils import gauss
from tests.truth.waves import alike, merged

CELLS = 7, 5  # of the two tables, per shortest wavelength on the sensor: to 1e-11
FINE_CELLS = 12, 9  # for targets below ``FINE``
FINE = 1e-10
DEGREE = 9
NODES = 20
INTEGRAND_S = 1.5e-8


class BoundaryTruth:
    """Photosites of one picture.

    pieces  : from ``picture.pieces``
    lenses  : (n,) round lenses, one for each wavelength
    jumps   : (pieces, n) what lies left of each piece less what lies right of it, times what the wavelength weighs
    photosite, olpf : of a specification
    lights  : of fields: nodes (places, light) made in two ways, and (n,) what each wavelength weighs
    """

    def __init__(self, pieces, lenses, jumps, photosite, olpf, *, target, lights=()):
        self.lights = lights
        self.pieces, self.photosite, self.olpf = pieces, photosite, olpf
        weights = np.array([one for *_, one in lights], float).reshape(-1, len(lenses))
        jumps = np.concatenate([np.reshape(jumps, (-1, len(lenses))), weights])
        self.lenses, jumps = merged(lenses, jumps)
        self.rows, self.kind_of, self.times = alike(jumps)
        self.length = 1.0 / max(lens.cutoff for lens in lenses)
        slowest = max(getattr(lens, "beat", 1.0) / lens.cutoff for lens in lenses)
        self.resolved = slowest * max(30.0, 1.2 * (3e-3 / target) ** 0.4)
        self.cells = FINE_CELLS if target < FINE else CELLS
        self._known = {}

    def values(self, points):
        """Light of every photosite centre (n, 2), less the background's, and the error of each."""
        points = np.asarray(points, float)
        fine = self._values(points, panel=3.0, density=7.0, resolved=self.resolved, cells=self.cells[0])
        other = self._values(points, panel=4.0, density=5.0, resolved=0.6 * self.resolved, cells=self.cells[1])
        fine, other = fine + self._exposed(points, 0), other + self._exposed(points, 1)
        return fine, np.abs(fine - other) + 1e-14 * (1.0 + len(self.pieces))

    def _exposed(self, points, way):
        """Light of the fields' nodes: the pattern between each of them and nodes over photosite and spots."""
        total = np.zeros(len(points))
        spots = photosites.spots(self.olpf)
        inner, share = photosites.inner_nodes(self.photosite, self._order(way))
        inner, share = (spots[:, None] + inner).reshape(-1, 2), np.tile(share, len(spots)) / len(spots)
        farthest = np.hypot(*inner.T).max() + self.length
        for (*ways, _), kind, times in zip(
            self.lights, self.kind_of[len(self.pieces) :], self.times[len(self.pieces) :], strict=True
        ):
            places, light = ways[way]
            last = max(float(np.hypot(*(places - point).T).max()) for point in points) + farthest
            *_, patterns = self._tables(last, self.cells[way])
            total += times * _seen(points, places, light, inner, share, patterns[kind], self.length / self.cells[way])
        return total

    def _order(self, way):
        """Nodes along each line of a photosite."""
        return math.ceil(2.6 * photosites.reach(self.photosite) / self.length) + (12, 9)[way]

    def cost(self):
        """Seconds that one photosite takes, about."""
        spots = len(photosites.spots(self.olpf))
        nodes = len(photosites.inner_nodes(self.photosite, self._order(0))[1])
        fields = 2.0 * sum(len(ways[0][1]) for *ways, _ in self.lights) * spots * nodes
        length = sum(p.length for p in self.pieces)
        length = min(length, 4.0 * self.resolved * len(self.pieces))
        along = NODES * (length / (3.0 * self.length) + 4.0 * len(self.pieces))
        if self.photosite["kind"] != "point":
            along *= len(photosites.border(self.photosite, 7.0 / self.length)[0])
        return (fields + 2.0 * along * spots) * INTEGRAND_S

    def _values(self, points, *, panel, density, resolved, cells):
        if not self.pieces:
            return np.zeros(len(points))
        reach = photosites.reach(self.photosite) + float(np.hypot(*photosites.spots(self.olpf).T).max())
        farthest = max(_farthest(points, piece).max() for piece in self.pieces) + 2.0 * reach
        last = min(farthest, resolved + (panel + 2.0) * self.length + 2.0 * reach) * 1.001 + self.length
        fields, potentials, _ = self._tables(last, cells)
        c1 = self.rows @ np.array([lens.powers[0] for lens in self.lenses])
        c3 = self.rows @ np.array([lens.powers[1] for lens in self.lenses])
        whole = self.rows.sum(axis=1)
        inner, share = photosites.inner_nodes(self.photosite)
        d = photosites.spots(self.olpf)
        inner = (d[:, None] + inner).reshape(-1, 2)
        share = np.tile(share, len(d)) / len(d)
        if self.photosite["kind"] == "point":
            border, normal = np.empty((0, 2)), np.empty((0, 2))
        else:
            border, normal = photosites.border(self.photosite, density / self.length)
            normal = np.tile(normal, (len(d), 1)) / (photosites.area(self.photosite) * len(d))
            border = (d[:, None] + border).reshape(-1, 2)
        x, w = gauss(NODES)
        total = np.zeros(len(points))
        of = zip(self.pieces, self.kind_of[: len(self.pieces)], self.times[: len(self.pieces)], strict=True)
        for piece, kind, times in of:
            straight, begin, stop, height = _frame(points, piece)
            total += times * _integrals(
                points, straight, *_bent(piece), begin, stop, height,
                _direction(piece), panel * self.length, resolved, reach, border, normal, inner, share,
                fields[kind], potentials[kind], self.length / cells, whole[kind], c1[kind], c3[kind], x, w,
            )  # fmt: skip
        return total

    def _tables(self, last, cells):
        """E/(2πr²), Φ and P of every row of jumps, as polynomials (kinds, cells, degree) on equal cells of radius."""
        if cells not in self._known or self._known[cells][0] < last:
            self._known[cells] = (last, *self._made(last, cells))
        return self._known[cells][1:]

    def _made(self, last, cells):
        step = self.length / cells
        count = math.ceil(last / step) + 2
        t, coefficients, rising, at_nodes, powers, more_powers = _bases()
        r = (np.arange(count)[:, None] + 0.5 * (1.0 + t)) * step
        near = 4
        u, w = gauss(24)
        u, w = 0.5 * (1.0 + u), 0.5 * w
        at_near = r[:near, :, None] * u
        patterns = np.zeros((len(self.rows), *r.shape))
        first = np.zeros((len(self.rows), near, r.shape[1]))
        for j, lens in enumerate(self.lenses):
            used = self.rows[:, j] != 0.0
            if not used.any():
                continue
            patterns[used] += np.multiply.outer(self.rows[used, j], lens.pattern(r))
            start = (lens.pattern(at_near) * u) @ w  # E/(2πr²) = ∫ P(ru)·u du
            first[used] += np.multiply.outer(self.rows[used, j], start)
        fields, potentials = [], []
        for ring, start in zip(2.0 * np.pi * r * patterns, first, strict=True):
            inside = 0.5 * step * (ring @ coefficients.T @ rising.T)
            ends = np.concatenate([[0.0], np.cumsum(inside.sum(axis=1))])
            energy = ends[:-1, None] + inside @ at_nodes.T
            field = energy / (2.0 * np.pi * r**2)
            field[:near] = start
            fields.append(field @ coefficients.T @ powers)
            inside = 0.5 * step * ((field * r) @ coefficients.T @ rising.T)
            ends = np.concatenate([[0.0], np.cumsum(inside.sum(axis=1))])
            inside[:, 0] += ends[:-1]
            potentials.append(inside @ more_powers)
        return np.array(fields), np.array(potentials), patterns @ coefficients.T @ powers


@functools.cache
def _bases():
    """Chebyshev nodes on −1 … 1 and what makes of values there coefficients, integrals from −1, values and powers."""
    order = DEGREE + 1
    t = np.cos(np.pi * (np.arange(order) + 0.5) / order)[::-1]
    at = np.polynomial.chebyshev.chebvander(t, DEGREE)
    coefficients = at.T * (2.0 / order)
    coefficients[0] *= 0.5
    eye = np.eye(order)
    rising = np.stack([np.polynomial.chebyshev.chebint(row, lbnd=-1.0) for row in eye], axis=1)
    at_nodes = np.polynomial.chebyshev.chebvander(t, order)

    def to_powers(count):
        rows = [np.polynomial.chebyshev.cheb2poly(row) for row in np.eye(count)]
        return np.array([np.pad(row, (0, count - len(row))) for row in rows])

    return t, coefficients, rising, at_nodes, to_powers(order), to_powers(order + 1)


def _bent(piece):
    """(n, 2) centre and half axes of an arc, or powers of a curve; and how fast either goes at most."""
    if piece.points:
        return Bezier(piece.points).powers, 3.0 * float(np.hypot(*np.diff(piece.points, axis=0).T).max())
    return np.array([piece.centre or (0.0, 0.0), piece.u, piece.v]), piece.largest


def _direction(piece):
    if not piece.straight:
        return np.zeros(2)
    d = np.array(piece.end, np.longdouble) - np.array(piece.start, np.longdouble)
    return (d / np.hypot(*d)).astype(float)


def _frame(points, piece):
    """Where a piece begins and ends for every photosite: along the line from the foot, or as angles of an arc.

    Extended precision: a foot is known to a part of a pitch though the piece begins a million of them away.
    """
    if not piece.straight:
        one = np.ones(len(points))
        first, last = (0.0, 1.0) if piece.points else (piece.first, piece.last)
        return False, first * one, last * one, 0.0 * one
    a, b = np.array(piece.start, np.longdouble), np.array(piece.end, np.longdouble)
    d = b - a
    length = np.hypot(*d)
    e = d / length
    gap = a - points.astype(np.longdouble)
    along = gap @ e
    height = gap[:, 0] * e[1] - gap[:, 1] * e[0]  # along the normal to the right of the direction: outwards
    return True, along.astype(float), (along + length).astype(float), height.astype(float)


def _farthest(points, piece):
    """No less than the largest distance of every point from a piece."""
    if piece.points:
        return np.max([np.hypot(*(points - np.array(p)).T) for p in piece.points], axis=0)
    if piece.centre is not None:
        return np.hypot(*(points - np.array(piece.centre)).T) + piece.largest
    _, begin, stop, height = _frame(points, piece)
    return np.hypot(np.maximum(np.abs(begin), np.abs(stop)), height)


@nb.njit(cache=True)
def _polynomial(cells, u):
    cell = int(u)
    t = 2.0 * (u - cell) - 1.0
    c = cells[cell]
    value = c[c.size - 1]
    for k in range(c.size - 2, -1, -1):
        value = value * t + c[k]
    return value


@nb.njit(cache=True)
def _seen(points, places, light, inner, share, pattern, step):
    """Light at points of all places, by the pattern between them and the nodes of a photosite."""
    out = np.zeros(len(points))
    for p in range(len(points)):
        for k in range(len(inner)):
            x, y, one = points[p, 0] + inner[k, 0], points[p, 1] + inner[k, 1], 0.0
            for q in range(len(light)):
                one += light[q] * _polynomial(pattern, math.hypot(places[q, 0] - x, places[q, 1] - y) / step)
            out[p] += share[k] * one
    return out


@nb.njit(cache=True)
def _at(bent, s):
    """Place x, y and slope of an arc (centre and half axes) at an angle, or of a curve (its powers) at a parameter."""
    if len(bent) == 3:
        cos, sin = math.cos(s), math.sin(s)
        x, y = bent[0, 0] + bent[1, 0] * cos + bent[2, 0] * sin, bent[0, 1] + bent[1, 1] * cos + bent[2, 1] * sin
        return x, y, bent[2, 0] * cos - bent[1, 0] * sin, bent[2, 1] * cos - bent[1, 1] * sin
    x, y, dx, dy = 0.0, 0.0, 0.0, 0.0
    for k in range(len(bent) - 1, -1, -1):
        dx, dy = dx * s + x, dy * s + y
        x, y = x * s + bent[k, 0], y * s + bent[k, 1]
    return x, y, dx, dy


@nb.njit(cache=True)
def _integrals(
    points, straight, bent, longer, begin, stop, height, direction, panel, resolved, reach, border, normal,
    inner, share, field, potential, step, whole, c1, c3, gauss_x, gauss_w,
):  # fmt: skip
    """One piece, every photosite."""
    out = np.zeros(len(points))
    for p in range(len(points)):
        s, last, h = begin[p], stop[p], height[p]
        total = 0.0
        while s < last:
            # How far from here the photosite is decides how long a panel may be.
            if straight:
                away = math.hypot(s, h)
            else:
                x, y, ex, ey = _at(bent, s)
                away, speed = math.hypot(x - points[p, 0], y - points[p, 1]), math.hypot(ex, ey)
            away = max(away - reach, 0.0)
            near = away < resolved
            length = panel if near else 0.5 * away
            if not straight:
                # As far as it goes when it grows as fast as it may: slow at a flat ellipse's tip.
                length = min(length, 0.25 * longer)
                length = 2.0 * length / (speed + math.sqrt(speed * speed + 8.0 * longer * length))
            rest = last - s
            length = rest if rest < 1.0000001 * length else min(length, rest)
            part = 0.0
            for q in range(gauss_x.size):
                at = s + 0.5 * length * (1.0 + gauss_x[q])
                if straight:
                    nx, ny = direction[1], -direction[0]
                    dx, dy = at * direction[0] + h * nx, at * direction[1] + h * ny
                    weight = 0.5 * length * gauss_w[q]
                else:
                    # n ds is the step along it turned by a quarter: to its right.
                    x, y, ex, ey = _at(bent, at)
                    nx, ny = ey, -ex
                    dx, dy = x - points[p, 0], y - points[p, 1]
                    weight = 0.5 * length * gauss_w[q]
                value = 0.0
                if near and len(border):
                    for k in range(len(border)):
                        r = math.hypot(dx - border[k, 0], dy - border[k, 1])
                        value -= (nx * normal[k, 0] + ny * normal[k, 1]) * _polynomial(potential, r / step)
                else:
                    for k in range(len(inner)):
                        gx, gy = dx - inner[k, 0], dy - inner[k, 1]
                        square = gx * gx + gy * gy
                        if near:
                            f = _polynomial(field, math.sqrt(square) / step)
                        else:
                            r = math.sqrt(square)
                            f = (whole - c1 / r - c3 / (r * square)) / (2.0 * math.pi * square)
                        value += share[k] * (nx * gx + ny * gy) * f
                part += weight * value
            total += part
            s = last if length == rest else s + length
        out[p] = total
    return out
