"""The light at points: every piece of an outline integrated, E(r)·(r × dr)/r² along it, over 2π."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel, shared
from camsim.quadrature import gauss_legendre, gauss_phases
from camsim.rendering.check.along import CUTS, PANEL_BLURS, SHORT, Energy, Memory, Rules, bezier, round_piece, straight
from camsim.rendering.check.records import Outlines, Parts

MOST_NODES = 64


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
    nodes: F64  # (m, 2) by which every point is moved, zone after zone
    zone: I64  # (m,) of each
    least: F64  # (zones, n) distances of the points that a zone's pieces have at least, and that they do not have
    most: F64


@functools.lru_cache(maxsize=16)
def rules_of(blur: float, allowed: float) -> Rules:
    """Return rules that leave so much of the shortest wave, whose length is the blur (pitches)."""
    phases = gauss_phases(allowed, MOST_NODES)
    nodes = int(np.searchsorted(phases, math.pi * PANEL_BLURS)) + 1
    few, fewest = (count for count, _ in SHORT)
    panel, short, shortest = (np.stack(gauss_legendre(count)) for count in (nodes, few, fewest))
    return Rules(panel, short, shortest, PANEL_BLURS * blur, float(phases[few - 1]) / math.pi * blur)


def light_at_points(asked: Asked, o: Outlines, parts: Parts, tables: Tables, rules: Rules, least: int) -> F64:
    """Return (points, nodes) what pieces in each node's zone add to the background's light at the points, moved by it.

    least : nodes that are worth a thread's while
    """
    light = np.empty((len(asked.points), len(asked.nodes)))

    def work(begin: int, end: int) -> None:
        nodes = max(rules.panel.shape[1], rules.few.shape[1])
        memory = Memory(
            np.empty(len(parts.sides), np.int64), np.empty(CUTS), np.empty(nodes, np.int32), np.empty(nodes)
        )
        _light(begin, end, asked, o, parts, tables, rules, memory, light)

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
    rules: Rules,
    memory: Memory,
    light: F64,
) -> None:
    """Fill in some of the light, counted point by point."""
    points, sets, radius, nodes, zones, least, most = asked
    sides, times, about, curves = parts
    count, per_step = len(nodes), 1.0 / tables.step
    here, pieces, last, zone = memory.pieces, 0, -1, -1
    for job in range(begin, end):
        point, node = job // count, job % count
        if point != last or zones[node] != zone:
            # All nodes of a zone have the same pieces.
            last, zone, pieces = point, zones[node], 0
            for e in range(len(sides)):
                gap = math.hypot(points[point, 0] - about[e, 0], points[point, 1] - about[e, 1]) - about[e, 2]
                if least[zone, point] <= gap < most[zone, point]:
                    here[pieces] = e
                    pieces += 1
        x, y = points[point, 0] + nodes[node, 0], points[point, 1] + nodes[node, 1]
        channel, reach = sets[point], radius[point]
        total = 0.0
        for e in here[:pieces]:
            energy = Energy(tables.cells[sides[e], channel], per_step, tables.far[sides[e], channel])
            if curves.of[e] >= 0:
                total += times[e] * bezier(x, y, curves, curves.of[e], about[e, 2], reach, energy)
            elif o.turn_rad[e] == 0.0:
                total += times[e] * straight(x, y, o, e, reach, energy, rules, memory)
            else:
                total += times[e] * round_piece(x, y, o, e, about[e], reach, energy, rules, memory.cuts)
        light[point, node] = total / math.tau
