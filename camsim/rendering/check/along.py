"""One piece of an outline integrated, as a point sees it: straight, round or a Bézier curve, near or far."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I32, I64
from camsim.kernels import kernel
from camsim.rendering.check.records import Bent, Outlines

PANEL_BLURS = 8.0  # the longest piece that one rule integrates: of 4 it takes three fifths of as many nodes
SHORT = ((8, 0.25), (4, 0.03))
"""Nodes, and of its distance half an arc for which they do: 8^{−16} of what it gives."""
STRAIGHTISH = 2.0  # radians that such an arc may turn: it does not go round and back again, as a small circle does
SLIGHT = 0.2  # radians that an arc may turn whose nodes are found from its middle, by seven powers of the angle: 1e-13
BENT = 2.0 / math.pi
"""Blurs, by which a panel is longer for its rule with every radian that it turns.

exp(iz·cos φ) over φ = aτ asks for as many nodes as a wave of the phase za + 4a, to the rule's own error: with 2a, rules
of 20 nodes lost 5000 times that at 1e-13, and of 8 nodes 11 times.
"""
CUTS = 10  # where a round piece may be cut, its ends among them
FAR_PANEL = 1.0  # of a round piece beyond the table, as a share of the distance of its nearer end


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


class Memory(NamedTuple):
    """What one thread writes on its way: the pieces that are near enough, where a round one is cut, and of the nodes of
    a straight one's panel the cells of the table in which they lie, and where in these."""

    pieces: I64  # (pieces,)
    cuts: F64  # (CUTS,)
    cells: I32  # (nodes,)
    within: F64  # (nodes,)


class Rules(NamedTuple):
    """Gauss rules (2, q), nodes and weights: of a panel, and two of fewer nodes for what is short and far.

    longest, tiny : pitches, of a panel, and of one that ``few`` nodes follow as well
    """

    panel: F64
    few: F64
    fewest: F64
    longest: float
    tiny: float


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
def _quintic(c: F64, t: float) -> float:
    value: float = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    return value


@kernel(forceinline=True)
def _value(r: float, inside: bool, energy: Energy) -> float:
    """E/r² from the table, or its smooth powers."""
    cells, per_step, far = energy
    if inside:
        u = r * per_step
        cell = min(int(u), len(cells) - 1)
        return _quintic(cells[cell], u - cell)
    inv = 1.0 / r
    inv2 = inv * inv
    smooth: float = inv2 * (far[0] - inv * (far[1] + inv2 * (far[2] + inv2 * far[3])))
    return smooth


@kernel()
def straight(
    x: float, y: float, o: Outlines, e: int, radius: float, energy: Energy, rules: Rules, memory: Memory
) -> float:
    """One straight piece: h is how far its line passes the point by, s runs along it."""
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
    panels = math.ceil((high - low) / rules.longest)
    half = 0.5 * (high - low) / panels
    g = rules.few if high - low < rules.tiny else rules.panel
    table, own, within, inside = energy.cells, memory.cells, memory.within, 0.0
    last = np.int32(len(table) - 1)
    for p in range(panels):
        middle = low + half * (2 * p + 1)
        # By themselves these are vectors; what is looked up and added up comes one by one.
        for q in range(g.shape[1]):
            s = middle + half * g[0, q]
            u = math.sqrt(h * h + s * s) * energy.per_step
            own[q] = min(np.int32(u), last)
            within[q] = u - own[q]
        for q in range(g.shape[1]):
            inside += g[1, q] * _quintic(table[np.uintp(own[q])], within[q])
    total += h * half * inside
    return total


@kernel()
def bezier(x: float, y: float, bent: Bent, k: int, half: float, radius: float, energy: Energy) -> float:
    """One Bézier curve: (P × P′)·E/r² over t, by as many nodes as it takes there; half: how far it reaches about t = 0.

    All of a curve that is partly within the radius is integrated with the table, which reaches as much farther.
    """
    x0, y0, x1, y1, x2, y2, x3, y3, eight, four = bent.terms[k]
    x0, y0 = x0 - x, y0 - y
    at = math.hypot(x0, y0)
    inside = at - half < radius
    order = bent.order[k]
    if not inside:
        order = 4 if at > four else 8 if at > eight else order
    g = bent.rules[order]
    total = 0.0
    for q in range(order):
        t = g[0, q]
        rx, ry = x0 + t * (x1 + t * (x2 + t * x3)), y0 + t * (y1 + t * (y2 + t * y3))
        wx, wy = x1 + t * (2.0 * x2 + t * 3.0 * x3), y1 + t * (2.0 * y2 + t * 3.0 * y3)
        total += g[1, q] * (rx * wy - ry * wx) * _value(math.sqrt(rx * rx + ry * ry), inside, energy)
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
def _slight(mx: float, my: float, arc: Arc, inside: bool, energy: Energy, g: F64) -> float:
    """One panel on an arc that turns but slightly, its middle at (mx, my) from the point: no sine and no cosine."""
    dx, dy, big, begin, end = arc
    half = 0.5 * (end - begin)
    c, s = (mx - dx) / big, (my - dy) / big
    part = 0.0
    for q in range(g.shape[1]):
        t = half * g[0, q]
        u = t * t
        sine = t * (1.0 - u / 6.0 * (1.0 - u / 20.0 * (1.0 - u / 42.0)))
        less = -0.5 * u * (1.0 - u / 12.0 * (1.0 - u / 30.0))  # cosine − 1
        more_c, more_s = c * less - s * sine, s * less + c * sine
        rx, ry = mx + big * more_c, my + big * more_s
        r = math.sqrt(rx * rx + ry * ry)
        part += g[1, q] * (rx * (c + more_c) + ry * (s + more_s)) * _value(r, inside, energy)
    return part * half * big


@kernel()
def round_piece(
    x: float,
    y: float,
    o: Outlines,
    e: int,
    about: F64,
    radius: float,
    energy: Energy,
    rules: Rules,
    cuts: F64,
) -> float:
    """One round piece: with d from the point to the centre and e(φ) to the rim, r × dr = (R² + R·d·e)dφ.

    about : (3,) of Parts;  cuts: (CUTS,) memory
    """
    g, few, fewest, longest, tiny = rules
    big = o.dx[e]
    dx, dy = o.x[e] - x, o.y[e] - y
    gap = math.hypot(dx, dy)
    begin, end = o.from_rad[e], o.from_rad[e] + o.turn_rad[e]
    # From afar a short arc is smooth all along, and near one that is shorter still.
    mx, my = about[0] - x, about[1] - y
    at, half, slight = math.hypot(mx, my), 0.5 * big * (end - begin), end - begin < SLIGHT
    # What an arc's radius is to its rules: longer, because it turns.
    bent = big + BENT * longest / PANEL_BLURS
    if slight and at + half < radius and (end - begin) * bent < tiny:
        return _slight(mx, my, Arc(dx, dy, big, begin, end), True, energy, few)
    if at - half > radius and half < SHORT[0][1] * at and end - begin < STRAIGHTISH:
        rule = fewest if half < SHORT[1][1] * at else few
        if slight:
            return _slight(mx, my, Arc(dx, dy, big, begin, end), False, energy, rule)
        return _panel(Arc(dx, dy, big, begin, end), 0.0, 1.0, False, energy, rule)
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
            panels = math.ceil((high - low) * bent / longest)
            rule = few if (high - low) * bent < tiny else g
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
