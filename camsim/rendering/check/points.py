"""The light at points: every piece of an outline integrated, E(r)·(r × dr)/r² along it, over 2π."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel, shared
from camsim.quadrature import gauss_legendre, gauss_phases
from camsim.rendering.check.along import (
    CUTS,
    PANEL_BLURS,
    SHORT,
    Energy,
    Memory,
    Rules,
    add_bezier,
    add_straight,
)
from camsim.rendering.check.along_arcs import add_round_piece
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
    sets: I64  # (n, k) channels in which each is asked for
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
    """Return (points, nodes, k) what pieces in each node's zone add to the background's light at points, moved by it.

    least : nodes that are worth a thread's while
    """
    shape = len(asked.points), len(asked.nodes), asked.sets.shape[1]
    light = np.empty((shape[0] * shape[1], shape[2]))

    def work(begin: int, end: int) -> None:
        nodes = max(rules.panel.shape[1], rules.few.shape[1])
        memory = memory_for(len(parts.sides), nodes, shape[2])
        _light(begin, end, asked, o, parts, tables, rules, memory, light)

    shared(len(light), work, least=least)
    return light.reshape(shape)


def memory_for(pieces: int, nodes: int, channels: int) -> Memory:
    """Return what one thread writes on its way, for so many pieces, nodes of a rule, and channels."""
    within = np.empty(nodes, np.int32), np.empty(nodes), np.empty(nodes)
    return Memory(np.empty(pieces, np.int64), np.empty(CUTS), *within, np.zeros(channels), np.zeros(channels))


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
    piece, total = memory.piece, memory.total
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
        reach = radius[point]
        total[:] = 0.0
        for e in here[:pieces]:
            piece[:] = 0.0
            energy = Energy(tables.cells[sides[e]], per_step, tables.far[sides[e]], sets[point])
            if curves.of[e] >= 0:
                add_bezier(x, y, curves, curves.of[e], about[e, 2], reach, energy, piece)
            elif o.turn_rad[e] == 0.0:
                add_straight(x, y, o, e, reach, energy, rules, memory)
            else:
                add_round_piece(x, y, o, e, about[e], reach, energy, rules, memory)
            for c in range(piece.size):
                total[c] += times[e] * piece[c]
        for c in range(piece.size):
            light[job, c] = total[c] / math.tau
