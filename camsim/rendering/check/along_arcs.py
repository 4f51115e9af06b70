"""One arc of an outline integrated, as a point sees it in some channels."""

from __future__ import annotations

import math
from typing import NamedTuple

from camsim.arrays import F64
from camsim.kernels import kernel
from camsim.rendering.check.along import CUTS, PANEL_BLURS, SHORT, Energy, Memory, Rules, add_value, look_up
from camsim.rendering.check.records import Outlines

STRAIGHTISH = 2.0  # radians that such an arc may turn: it does not go round and back again, as a small circle does
SLIGHT = 0.2  # radians that an arc may turn whose nodes are found from its middle, by seven powers of the angle: 1e-13
BENT = 2.0 / math.pi
"""Blurs, by which a panel is longer for its rule with every radian that it turns.

exp(iz·cos φ) over φ = aτ asks for as many nodes as a wave of the phase za + 4a, to the rule's own error: with 2a, rules
of 20 nodes lost 5000 times that at 1e-13, and of 8 nodes 11 times.
"""
FAR_PANEL = 1.0  # of a round piece beyond the table, as a share of the distance of its nearer end


class Arc(NamedTuple):
    """Part of a circle: its centre from the point, its radius, and the angles at which it begins and ends."""

    dx: float
    dy: float
    big: float
    begin: float
    end: float


class _Slight(NamedTuple):
    """A panel that turns but slightly: its middle from the point and the normal there, its radius, half its turn."""

    x: float
    y: float
    c: float
    s: float
    big: float
    half: float


@kernel()
def _add_panel(
    arc: Arc, start: float, stop: float, times: float, inside: bool, energy: Energy, g: F64, memory: Memory
) -> None:
    """Add one panel of an arc, from share ``start`` of it to ``stop``."""
    dx, dy, big, begin, end = arc
    half = 0.5 * (end - begin) * (stop - start)
    centre = begin + 0.5 * (end - begin) * (start + stop)
    if abs(half) < 0.5 * SLIGHT:
        c, s = math.cos(centre), math.sin(centre)
        _add_slight(_Slight(dx + big * c, dy + big * s, c, s, big, half), times, inside, energy, g, memory)
        return
    for q in range(g.shape[1]):
        angle = centre + half * g[0, q]
        c, s = math.cos(angle), math.sin(angle)
        rx, ry = dx + big * c, dy + big * s
        memory.within[q] = math.sqrt(rx * rx + ry * ry)
        memory.times[q] = times * half * big * g[1, q] * (rx * c + ry * s)
    _add_nodes(g.shape[1], inside, energy, memory)


@kernel()
def _add_slight(panel: _Slight, times: float, inside: bool, energy: Energy, g: F64, memory: Memory) -> None:
    """Add such a panel without a sine or a cosine of any node."""
    mx, my, c, s, big, half = panel
    within, gain = memory.within, memory.times
    for q in range(g.shape[1]):
        t = half * g[0, q]
        u = t * t
        sine = t * (1.0 - u / 6.0 * (1.0 - u / 20.0 * (1.0 - u / 42.0)))
        less = -0.5 * u * (1.0 - u / 12.0 * (1.0 - u / 30.0))  # cosine − 1
        more_c, more_s = c * less - s * sine, s * less + c * sine
        rx, ry = mx + big * more_c, my + big * more_s
        within[q] = math.sqrt(rx * rx + ry * ry)
        gain[q] = times * half * big * g[1, q] * (rx * (c + more_c) + ry * (s + more_s))
    _add_nodes(g.shape[1], inside, energy, memory)


@kernel(forceinline=True)
def _add_nodes(count: int, inside: bool, energy: Energy, memory: Memory) -> None:
    """Add a panel's nodes, from the table or of its smooth powers."""
    if inside:
        look_up(count, energy, memory)
        return
    for q in range(count):
        add_value(memory.within[q], memory.times[q], False, energy, memory.piece)


@kernel()
def add_round_piece(
    x: float, y: float, o: Outlines, e: int, about: F64, radius: float, energy: Energy, rules: Rules, memory: Memory
) -> None:
    """Add one round piece: with d from the point to the centre and e(φ) to the rim, r × dr = (R² + R·d·e)dφ.

    about : (3,) of Parts
    """
    g, few, fewest, longest, tiny = rules
    cuts, big = memory.cuts, o.dx[e]
    dx, dy = o.x[e] - x, o.y[e] - y
    gap = math.hypot(dx, dy)
    begin, end = o.from_rad[e], o.from_rad[e] + o.turn_rad[e]
    # From afar a short arc is smooth all along, and near one that is shorter still.
    mx, my = about[0] - x, about[1] - y
    turn = 0.5 * (end - begin)
    at, half, slight = math.hypot(mx, my), big * turn, end - begin < SLIGHT
    # What an arc's radius is to its rules: longer, because it turns.
    bent = big + BENT * longest / PANEL_BLURS
    if slight and at + half < radius and (end - begin) * bent <= longest:
        rule = few if (end - begin) * bent < tiny else g
        _add_slight(_Slight(mx, my, (mx - dx) / big, (my - dy) / big, big, turn), 1.0, True, energy, rule, memory)
        return
    if at - half > radius and half < SHORT[0][1] * at and end - begin < STRAIGHTISH:
        rule = fewest if half < SHORT[1][1] * at else few
        if slight:
            _add_slight(_Slight(mx, my, (mx - dx) / big, (my - dy) / big, big, turn), 1.0, False, energy, rule, memory)
        else:
            _add_panel(Arc(dx, dy, big, begin, end), 0.0, 1.0, 1.0, False, energy, rule, memory)
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
                _add_panel(arc, p / panels, (p + 1) / panels, 1.0, True, energy, rule, memory)
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
            _add_panel(Arc(dx, dy, big, near, farther), done, stop, forward, False, energy, g, memory)
            done = stop
