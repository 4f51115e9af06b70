"""The light at points: every piece of an outline integrated, E(r)·(r × dr)/r² along it, over 2π."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel, shared
from camsim.quadrature import gauss_legendre
from camsim.rendering.check.records import Outlines

PANEL_NODES = 20
PANEL_BLURS = 4.0
SHORT = ((8, 0.25), (4, 0.03))
"""Nodes, and of its distance half an arc for which they do: 8^{−16} of what it gives."""
STRAIGHTISH = 2.0  # radians that such an arc may turn: it does not go round and back again, as a small circle does
TINY = 1.0 / 16.0  # of a panel: there SHORT's eight nodes leave less than a panel's twenty on all of it
CUTS = 10  # where a round piece may be cut, its ends among them
FAR_PANEL = 1.0  # of a round piece beyond the table, as a share of the distance of its nearer end


class Tables(NamedTuple):
    """What the check knows of the lens, for every pair of spectra and channel."""

    cells: F64  # (pairs, channels, n, 6) E/r² as quintics
    step: float  # pitches
    far: F64  # (pairs, channels, 4) its smooth powers


class Asked(NamedTuple):
    """Where light is asked for, and from where."""

    points: F64  # (n, 2)
    sets: I64  # (n,) channel of each
    radius: F64  # (n,) within which E is taken from the table
    nodes: F64  # (m, 2) by which every point is moved
    least: F64  # (n,) distances of the points that pieces have at least, and that they do not have
    most: F64


class Parts(NamedTuple):
    """What is to be known of each piece besides its outline."""

    sides: I64  # which two spectra lie beside it
    times: F64  # what their difference is to be multiplied by
    about: F64  # (n, 3) its middle, and half its length: a circle that it lies in

    @classmethod
    def of(cls, o: Outlines, sides: I64, times: F64) -> Parts:
        """Collect it."""
        straight, middle = o.turn_rad == 0.0, o.from_rad + 0.5 * o.turn_rad
        x = o.x + np.where(straight, 0.5 * o.dx, o.dx * np.cos(middle))
        y = o.y + np.where(straight, 0.5 * o.dy, o.dx * np.sin(middle))
        return cls(sides, times, np.stack([x, y, 0.5 * o.length], axis=1))

    def gaps(self, points: F64) -> F64:
        """Return how far (points, pieces) all of each piece lies at least from points (m, 2)."""
        x, y, half = self.about.T
        gaps: F64 = np.hypot(points[:, :1] - x, points[:, 1:] - y) - half
        return gaps


class Energy(NamedTuple):
    """The same for one pair and channel."""

    cells: F64  # (n, 6)
    per_step: float
    far: F64  # (4,)


class Arc(NamedTuple):
    """Part of a circle: its centre from the point, its radius, and the angles at which it begins and ends."""

    dx: float
    dy: float
    big: float
    begin: float
    end: float


class Rules(NamedTuple):
    """Gauss rules (2, q), nodes and weights: of a panel, and two of fewer nodes for what is short and far."""

    panel: F64
    few: F64
    fewest: F64


@kernel(forceinline=True)
def _beyond(h: float, s: float, far: F64) -> float:
    """Σ c_k·∫ds/r^k over the half line from s ≥ 0, for k = 3, 5, 7."""
    r = math.hypot(h, s)
    u = s / r
    third = 1.0 / (r * (r + s))
    total: float = third * (
        far[1] + third * ((2.0 + u) / 3.0 * far[2] + third * (8.0 + 9.0 * u + 3.0 * u * u) / 15.0 * far[3])
    )
    return total


@kernel()
def _far_line(h: float, s1: float, s2: float, far: F64) -> float:
    """Far form over s1 … s2: the angle and the first three odd powers of 1/r."""
    if s1 < 0.0 < s2:
        powers = 2.0 * _beyond(h, 0.0, far) - _beyond(h, -s1, far) - _beyond(h, s2, far)
    else:
        powers = _beyond(h, min(abs(s1), abs(s2)), far) - _beyond(h, max(abs(s1), abs(s2)), far)
    total: float = far[0] * math.atan2(h * (s2 - s1), h * h + s1 * s2) - h * powers
    return total


@kernel(forceinline=True)
def _value(r: float, inside: bool, energy: Energy) -> float:
    """E/r² from the table, or its smooth powers."""
    cells, per_step, far = energy
    if inside:
        u = r * per_step
        cell = min(int(u), len(cells) - 1)
        t = u - cell
        c = cells[cell]
        value: float = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
        return value
    inv = 1.0 / r
    inv2 = inv * inv
    smooth: float = inv2 * (far[0] - inv * (far[1] + inv2 * (far[2] + inv2 * far[3])))
    return smooth


@kernel()
def _straight(
    x: float, y: float, o: Outlines, e: int, radius: float, panel: float, energy: Energy, rules: Rules
) -> float:
    far, length = energy.far, math.hypot(o.dx[e], o.dy[e])
    tx, ty = o.dx[e] / length, o.dy[e] / length
    dx, dy = o.x[e] - x, o.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + length
    cut = math.sqrt(max(radius * radius - h * h, 0.0))
    low, high = max(s1, -cut), min(s2, cut)
    if high <= low:
        return _far_line(h, s1, s2, far)
    total: float = 0.0
    if s1 < low:
        total += _far_line(h, s1, low, far)
    if s2 > high:
        total += _far_line(h, high, s2, far)
    panels = math.ceil((high - low) / panel)
    half = 0.5 * (high - low) / panels
    g = rules.few if high - low < TINY * panel else rules.panel
    inside = 0.0
    for p in range(panels):
        middle = low + half * (2 * p + 1)
        for q in range(g.shape[1]):
            s = middle + half * g[0, q]
            inside += g[1, q] * _value(math.sqrt(h * h + s * s), True, energy)
    total += h * half * inside
    return total


@kernel()
def _panel(arc: Arc, start: float, stop: float, inside: bool, energy: Energy, g: F64) -> float:
    """One panel of an arc, from share ``start`` of it to ``stop``."""
    dx, dy, big, begin, end = arc
    half = 0.5 * (end - begin) * (stop - start)
    centre = begin + 0.5 * (end - begin) * (start + stop)
    part = 0.0
    for q in range(g.shape[1]):
        angle = centre + half * g[0, q]
        c, s = math.cos(angle), math.sin(angle)
        rx, ry = dx + big * c, dy + big * s
        r = math.sqrt(rx * rx + ry * ry)
        part += g[1, q] * (rx * c + ry * s) * _value(r, inside, energy)
    return part * half * big


@kernel()
def _round(
    x: float, y: float, o: Outlines, e: int, radius: float, panel: float, energy: Energy, rules: Rules, cuts: F64
) -> float:
    """One round piece: with d from the point to the centre and e(φ) to the rim, r × dr = (R² + R·d·e)dφ.

    cuts : (CUTS,) memory
    """
    g, few, fewest = rules
    big = o.dx[e]
    dx, dy = o.x[e] - x, o.y[e] - y
    gap = math.hypot(dx, dy)
    begin, end = o.from_rad[e], o.from_rad[e] + o.turn_rad[e]
    # From afar a short arc is smooth all along.
    middle = begin + 0.5 * (end - begin)
    at, half = math.hypot(dx + big * math.cos(middle), dy + big * math.sin(middle)), 0.5 * big * (end - begin)
    if at - half > radius and half < SHORT[0][1] * at and end - begin < STRAIGHTISH:
        if half < SHORT[1][1] * at:
            return _panel(Arc(dx, dy, big, begin, end), 0.0, 1.0, False, energy, fewest)
        return _panel(Arc(dx, dy, big, begin, end), 0.0, 1.0, False, energy, few)
    # Cut where the rim is nearest and farthest, and where it crosses the table's radius:
    # |d|² + R² + 2R|d|cos(φ − φd) = radius².
    cuts[0] = begin
    count = 1
    if gap > 0.0:
        cosine = (radius * radius - gap * gap - big * big) / (2.0 * big * gap)
        crossing = math.acos(min(max(cosine, -1.0), 1.0))
        towards = math.atan2(dy, dx)
        for away in (0.0, math.pi, crossing, -crossing):
            angle = begin + (towards + away - begin) % math.tau
            while angle < end and count < CUTS - 1:
                place = count
                while place > 0 and cuts[place - 1] > angle:
                    cuts[place] = cuts[place - 1]
                    place -= 1
                cuts[place] = angle
                count += 1
                angle += math.tau
    cuts[count] = end
    total = 0.0
    for k in range(count):
        low, high = cuts[k], cuts[k + 1]
        if high <= low:
            continue
        middle = 0.5 * (low + high)
        at = math.hypot(dx + big * math.cos(middle), dy + big * math.sin(middle))
        if at < radius:
            panels = math.ceil((high - low) * big / panel)
            rule = few if (high - low) * big < TINY * panel else g
            for p in range(panels):
                total += _panel(Arc(dx, dy, big, low, high), p / panels, (p + 1) / panels, True, energy, rule)
            continue
        # From the nearer end on, panels as long as they are far away.
        at_low = math.hypot(dx + big * math.cos(low), dy + big * math.sin(low))
        at_high = math.hypot(dx + big * math.cos(high), dy + big * math.sin(high))
        near, farther = (low, high) if at_low <= at_high else (high, low)
        done = 0.0
        while done < 1.0:
            angle = near + done * (farther - near)
            r = math.hypot(dx + big * math.cos(angle), dy + big * math.sin(angle))
            stop = min(1.0, done + FAR_PANEL * r / (big * (high - low)))
            part = _panel(Arc(dx, dy, big, near, farther), done, stop, False, energy, g)
            total += part if near == low else -part
            done = stop
    return total


def light_at_points(asked: Asked, o: Outlines, parts: Parts, tables: Tables, panel: float, least: int) -> F64:
    """Return (points, nodes) the light besides the background's at the points, moved by the nodes.

    panel  : longest that one rule integrates, pitches
    least  : nodes that are worth a thread's while
    """
    light = np.empty((len(asked.points), len(asked.nodes)))
    rules = Rules(*(np.stack(gauss_legendre(count)) for count in (PANEL_NODES, *(count for count, _ in SHORT))))

    def work(begin: int, end: int) -> None:
        _light(begin, end, asked, o, parts, tables, panel, rules, np.empty(CUTS), light)

    shared(light.size, work, least=least)
    return light


@kernel(error_model="numpy", fastmath={"contract"})
def _light(
    begin: int,
    end: int,
    asked: Asked,
    o: Outlines,
    parts: Parts,
    tables: Tables,
    panel: float,
    rules: Rules,
    cuts: F64,
    light: F64,
) -> None:
    """Fill in some of the light, counted point by point; cuts: (CUTS,) memory."""
    points, sets, radius, nodes, least, most = asked
    sides, times, about = parts
    count, per_step = len(nodes), 1.0 / tables.step
    here, pieces, last = np.empty(len(sides), np.int64), 0, -1
    for job in range(begin, end):
        point, node = job // count, job % count
        if point != last:
            # All nodes of a point have the same pieces.
            last, pieces = point, 0
            for e in range(len(sides)):
                gap = math.hypot(points[point, 0] - about[e, 0], points[point, 1] - about[e, 1]) - about[e, 2]
                if least[point] <= gap < most[point]:
                    here[pieces] = e
                    pieces += 1
        x, y = points[point, 0] + nodes[node, 0], points[point, 1] + nodes[node, 1]
        channel, reach = sets[point], radius[point]
        total = 0.0
        for e in here[:pieces]:
            energy = Energy(tables.cells[sides[e], channel], per_step, tables.far[sides[e], channel])
            if o.turn_rad[e] == 0.0:
                total += times[e] * _straight(x, y, o, e, reach, panel, energy, rules)
            else:
                total += times[e] * _round(x, y, o, e, reach, panel, energy, rules, cuts)
        light[point, node] = total / math.tau
