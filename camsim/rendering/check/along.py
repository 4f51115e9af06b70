"""One piece of an outline integrated, as a point sees it in some channels: straight, round or a Bézier curve."""

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
    """The same for one pair, and the channels that are asked for."""

    cells: F64  # (channels, n, 6)
    per_step: float
    far: F64  # (channels, 4)
    asked: I64  # (k,)


class Arc(NamedTuple):
    """Part of a circle: its centre from the point, its radius, and the angles at which it begins and ends."""

    dx: float
    dy: float
    big: float
    begin: float
    end: float


class Memory(NamedTuple):
    """What one thread writes on its way: the pieces that are near enough, where a round one is cut, and of the nodes of
    a straight one's panel the cells of the table in which they lie, and where in these; what one piece adds to every
    channel, and all of them."""

    pieces: I64  # (pieces,)
    cuts: F64  # (CUTS,)
    cells: I32  # (nodes,)
    within: F64  # (nodes,)
    piece: F64  # (k,)
    total: F64  # (k,)


class Rules(NamedTuple):
    """Gauss rules (2, q), nodes and weights: of a panel, and two of fewer nodes for what is short and far.

    longest, tiny : pitches, of a panel, and of one that ``few`` nodes follow as well
    """

    panel: F64
    few: F64
    fewest: F64
    longest: float
    tiny: float


class _Powers(NamedTuple):
    """∫ds/r^k along a line for k = 3, 5, 7."""

    third: float
    fifth: float
    seventh: float


@kernel(forceinline=True)
def _beyond(h: float, s: float) -> _Powers:
    """The same over the half line from s ≥ 0."""
    r = math.hypot(h, s)
    u = s / r
    third = 1.0 / (r * (r + s))
    square = third * third
    return _Powers(third, square * (2.0 + u) / 3.0, square * third * (8.0 + 9.0 * u + 3.0 * u * u) / 15.0)


@kernel()
def _add_far_line(h: float, s1: float, s2: float, energy: Energy, piece: F64) -> None:
    """Add the far form over s1 … s2: the angle and the first three odd powers of 1/r."""
    angle = math.atan2(h * (s2 - s1), h * h + s1 * s2)
    if s1 < 0.0 < s2:
        whole, a, b, times = _beyond(h, 0.0), _beyond(h, -s1), _beyond(h, s2), 2.0
    else:
        whole, a, times = _beyond(h, min(abs(s1), abs(s2))), _beyond(h, max(abs(s1), abs(s2))), 1.0
        b = _Powers(0.0, 0.0, 0.0)
    third = times * whole.third - a.third - b.third
    fifth = times * whole.fifth - a.fifth - b.fifth
    seventh = times * whole.seventh - a.seventh - b.seventh
    for c in range(energy.asked.size):
        far = energy.far[energy.asked[c]]
        piece[c] += far[0] * angle - h * (far[1] * third + far[2] * fifth + far[3] * seventh)


@kernel(forceinline=True)
def _quintic(c: F64, t: float) -> float:
    value: float = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    return value


@kernel(forceinline=True)
def _add_value(r: float, times: float, inside: bool, energy: Energy, piece: F64) -> None:
    """Add a number times E/r² from the table, or of its smooth powers."""
    cells, per_step, powers, asked = energy
    if inside:
        u = r * per_step
        cell = min(int(u), cells.shape[1] - 1)
        for c in range(asked.size):
            piece[c] += times * _quintic(cells[asked[c], cell], u - cell)
        return
    inv = 1.0 / r
    inv2 = inv * inv
    for c in range(asked.size):
        far = powers[asked[c]]
        piece[c] += times * inv2 * (far[0] - inv * (far[1] + inv2 * (far[2] + inv2 * far[3])))


@kernel()
def add_straight(
    x: float, y: float, o: Outlines, e: int, radius: float, energy: Energy, rules: Rules, memory: Memory
) -> None:
    """Add one straight piece: h is how far its line passes the point by, s runs along it."""
    piece, length = memory.piece, math.hypot(o.dx[e], o.dy[e])
    tx, ty = o.dx[e] / length, o.dy[e] / length
    dx, dy = o.x[e] - x, o.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + length
    cut = math.sqrt(max(radius * radius - h * h, 0.0))
    low, high = max(s1, -cut), min(s2, cut)
    if high <= low:
        _add_far_line(h, s1, s2, energy, piece)
        return
    if s1 < low:
        _add_far_line(h, s1, low, energy, piece)
    if s2 > high:
        _add_far_line(h, high, s2, energy, piece)
    panels = math.ceil((high - low) / rules.longest)
    half = 0.5 * (high - low) / panels
    g = rules.few if high - low < rules.tiny else rules.panel
    own, within, last = memory.cells, memory.within, np.int32(energy.cells.shape[1] - 1)
    for p in range(panels):
        middle = low + half * (2 * p + 1)
        # By themselves these are vectors; what is looked up and added up comes one by one.
        for q in range(g.shape[1]):
            s = middle + half * g[0, q]
            u = math.sqrt(h * h + s * s) * energy.per_step
            own[q] = min(np.int32(u), last)
            within[q] = u - own[q]
        for c in range(energy.asked.size):
            table, inside = energy.cells[energy.asked[c]], 0.0
            for q in range(g.shape[1]):
                inside += g[1, q] * _quintic(table[np.uintp(own[q])], within[q])
            piece[c] += h * half * inside


@kernel()
def add_bezier(x: float, y: float, bent: Bent, k: int, half: float, radius: float, energy: Energy, piece: F64) -> None:
    """Add one Bézier curve: (P × P′)·E/r² over t, by as many nodes as it takes; half: how far it reaches about t = 0.

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
    for q in range(order):
        t = g[0, q]
        rx, ry = x0 + t * (x1 + t * (x2 + t * x3)), y0 + t * (y1 + t * (y2 + t * y3))
        wx, wy = x1 + t * (2.0 * x2 + t * 3.0 * x3), y1 + t * (2.0 * y2 + t * 3.0 * y3)
        _add_value(math.sqrt(rx * rx + ry * ry), g[1, q] * (rx * wy - ry * wx), inside, energy, piece)


@kernel()
def _add_panel(
    arc: Arc, start: float, stop: float, times: float, inside: bool, energy: Energy, g: F64, piece: F64
) -> None:
    """Add one panel of an arc, from share ``start`` of it to ``stop``."""
    dx, dy, big, begin, end = arc
    half = 0.5 * (end - begin) * (stop - start)
    centre = begin + 0.5 * (end - begin) * (start + stop)
    times *= half * big
    for q in range(g.shape[1]):
        angle = centre + half * g[0, q]
        c, s = math.cos(angle), math.sin(angle)
        rx, ry = dx + big * c, dy + big * s
        r = math.sqrt(rx * rx + ry * ry)
        _add_value(r, times * g[1, q] * (rx * c + ry * s), inside, energy, piece)


@kernel()
def _add_slight(mx: float, my: float, arc: Arc, inside: bool, energy: Energy, g: F64, piece: F64) -> None:
    """Add one panel on an arc that turns but slightly, its middle at (mx, my) from the point: no sine, no cosine."""
    dx, dy, big, begin, end = arc
    half = 0.5 * (end - begin)
    c, s = (mx - dx) / big, (my - dy) / big
    times = half * big
    for q in range(g.shape[1]):
        t = half * g[0, q]
        u = t * t
        sine = t * (1.0 - u / 6.0 * (1.0 - u / 20.0 * (1.0 - u / 42.0)))
        less = -0.5 * u * (1.0 - u / 12.0 * (1.0 - u / 30.0))  # cosine − 1
        more_c, more_s = c * less - s * sine, s * less + c * sine
        rx, ry = mx + big * more_c, my + big * more_s
        r = math.sqrt(rx * rx + ry * ry)
        _add_value(r, times * g[1, q] * (rx * (c + more_c) + ry * (s + more_s)), inside, energy, piece)


@kernel()
def add_round_piece(
    x: float, y: float, o: Outlines, e: int, about: F64, radius: float, energy: Energy, rules: Rules, memory: Memory
) -> None:
    """Add one round piece: with d from the point to the centre and e(φ) to the rim, r × dr = (R² + R·d·e)dφ.

    about : (3,) of Parts
    """
    g, few, fewest, longest, tiny = rules
    cuts, piece = memory.cuts, memory.piece
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
        _add_slight(mx, my, Arc(dx, dy, big, begin, end), True, energy, few, piece)
        return
    if at - half > radius and half < SHORT[0][1] * at and end - begin < STRAIGHTISH:
        rule = fewest if half < SHORT[1][1] * at else few
        if slight:
            _add_slight(mx, my, Arc(dx, dy, big, begin, end), False, energy, rule, piece)
        else:
            _add_panel(Arc(dx, dy, big, begin, end), 0.0, 1.0, 1.0, False, energy, rule, piece)
        return
    # Cut where the rim is nearest and farthest, and where it crosses the table's radius: there
    # (|d| − R)² + 4R|d|·sin²(ψ/2) = radius², ψ from where it is nearest. Of a cosine a large R leaves no digit.
    cuts[0] = begin
    count = 1
    if gap > 0.0:
        square = (radius - gap + big) * (radius + gap - big) / (4.0 * big * gap)
        crossing = 2.0 * math.asin(math.sqrt(min(max(square, 0.0), 1.0)))
        towards = math.atan2(-dy, -dx)
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
                arc = Arc(dx, dy, big, low, high)
                _add_panel(arc, p / panels, (p + 1) / panels, 1.0, True, energy, rule, piece)
            continue
        # From the nearer end on, panels as long as they are far away.
        at_low = math.hypot(dx + big * math.cos(low), dy + big * math.sin(low))
        at_high = math.hypot(dx + big * math.cos(high), dy + big * math.sin(high))
        near, farther, forward = (low, high, 1.0) if at_low <= at_high else (high, low, -1.0)
        done = 0.0
        while done < 1.0:
            angle = near + done * (farther - near)
            r = math.hypot(dx + big * math.cos(angle), dy + big * math.sin(angle))
            stop = min(1.0, done + FAR_PANEL * r / (big * (high - low)))
            _add_panel(Arc(dx, dy, big, near, farther), done, stop, forward, False, energy, g, piece)
            done = stop
