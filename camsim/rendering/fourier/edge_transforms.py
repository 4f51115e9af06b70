"""Transforms of regions from their edges; arrays only.

The transform of a region is F(k) = (i/2π|k|²) Σ (k × e)·exp(−2πi k·m)·sinc(k·e) over its edges e, their middles m, by
Green's theorem; k × e = kx·ey − ky·ex, inside on the side where cross(e, x − start) > 0. With the phases a and b of an
edge's two ends exp(…)·sinc(…) = (a − b)/(2πi k·e), so every edge costs one division:

    4π²|k|²·F(k) = Σ (k × e)/(k·e)·(a − b)

That is what the transforms here return; the area takes F's place at k = 0.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel, shared
from camsim.rendering.fourier.blocks import Place
from camsim.rendering.fourier.kernels import COLUMNS

TURNS, PRODUCTS = 5_000, 50_000  # phases, and edges × frequencies: fewer are no work for a thread of its own
VECTORS = 32  # frequencies that are computed in steps of; what is beyond a row's end is thrown away
FLAT = 1e-3  # below this k·e the difference of the ends' phases is taken as a sinc


class Corners(NamedTuple):
    """Edges by the corners that they share."""

    points: F64  # (n, 2)
    begin: I64  # (edges,) index of each edge's ends
    finish: I64
    jump: F64  # (edges, spectra) of how much of each there is more to its left than to its right


def edge_transforms(place: Place, edges: Corners) -> F64:
    """Return 4π²|k|²·F of every spectrum's regions, real and imaginary part: (spectra, count_j, 2, count_i).

    Beyond the cut they are left at 0.
    """
    out = np.zeros((edges.jump.shape[1], place.count_j, 2, place.count_i))
    across = np.empty((2, len(edges.points), place.count_i + VECTORS))
    of_row = place.count_i * max(1, len(edges.points))
    turned = functools.partial(turn_across, place, edges.points, across)
    shared(len(edges.points), turned, least=-(-TURNS // place.count_i))
    shared(place.count_j, functools.partial(_transform, place, edges, across, out), least=-(-PRODUCTS // of_row))
    return out


@kernel(error_model="numpy", fastmath={"contract"})
def turn_across(place: Place, points: F64, across: F64, low: int, high: int) -> None:
    """Write some corners' phases along the first axis."""
    for v in range(low, high):
        for c in range(across.shape[2]):
            turn = points[v, 0] * (place.first_i + c) / place.px
            turn -= math.floor(turn)
            across[0, v, c], across[1, v, c] = math.cos(2.0 * math.pi * turn), -math.sin(2.0 * math.pi * turn)


@kernel(allocates=True)
def _sides(jump: F64) -> tuple[I64, I64]:
    """Return which spectra edges have to do with, and where those of each begin, (edges + 1,)."""
    sides, first, count = np.empty(jump.size, np.int64), np.zeros(len(jump) + 1, np.int64), 0
    for e in range(len(jump)):
        for side in range(jump.shape[1]):
            if jump[e, side] != 0.0:
                sides[count] = side
                count += 1
        first[e + 1] = count
    return sides[:count], first


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def _transform(place: Place, edges: Corners, across: F64, out: F64, low_row: int, high_row: int) -> None:
    """Add every edge to some rows."""
    points, begin, finish, jump = edges
    first_i, first_j, count_i = place.first_i, place.first_j, place.count_i
    px, py, cut = place.px, place.py, place.cut
    xr, xi = across[0], across[1]
    corners = len(points)
    sides, first = _sides(jump)
    for r in range(low_row, high_row):
        ky = (first_j + r) / py
        inside = cut * cut - ky * ky
        if inside <= 0.0:
            continue
        furthest = math.floor(px * math.sqrt(inside))
        lowest, stop = max(0, -furthest - first_i), min(count_i, furthest - first_i + 1)
        yr, yi = np.empty(corners), np.empty(corners)
        for v in range(corners):
            turn = points[v, 1] * (first_j + r) / py
            turn -= math.floor(turn)
            yr[v], yi[v] = math.cos(2.0 * math.pi * turn), -math.sin(2.0 * math.pi * turn)
        ar, ai = np.empty((corners, COLUMNS)), np.empty((corners, COLUMNS))
        kx_of, sum_r, sum_i = np.empty(COLUMNS), np.empty(COLUMNS), np.empty(COLUMNS)
        sums = np.empty((len(out), 2, COLUMNS))
        for low in range(lowest, stop, COLUMNS):
            width = min(COLUMNS, stop - low)
            wide = -(-width // VECTORS) * VECTORS
            start_x = (first_i + low) / px
            for c in range(wide):
                kx_of[c] = start_x + c / px
            for side in range(len(out)):
                for c in range(wide):
                    sums[side, 0, c], sums[side, 1, c] = 0.0, 0.0
            for v in range(corners):
                across_r, across_i, down_r, down_i = xr[v, low : low + wide], xi[v, low : low + wide], yr[v], yi[v]
                phase_r, phase_i = ar[v], ai[v]
                for c in range(wide):
                    phase_r[c] = across_r[c] * down_r - across_i[c] * down_i
                    phase_i[c] = across_r[c] * down_i + across_i[c] * down_r
            for e in range(len(begin)):
                a, b = begin[e], finish[e]
                ex, ey = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
                # Frequencies from flat_low to flat_high run nearly along the edge's normal.
                flat_low, flat_high = width, width
                if abs(ex) * width > 1e-12 * px * FLAT:
                    middle, half = -ky * ey / ex, FLAT / abs(ex)
                    at_low, at_high = (middle - half - start_x) * px, (middle + half - start_x) * px
                    if at_high >= 0.0 and at_low <= width:
                        flat_low, flat_high = max(0, math.ceil(at_low)), min(width, math.floor(at_high) + 1)
                elif abs(ky * ey + start_x * ex) < FLAT:
                    flat_low = 0
                begin_r, begin_i, finish_r, finish_i = ar[a], ai[a], ar[b], ai[b]
                for c in range(wide):
                    kx = kx_of[c]
                    along = kx * ex + ky * ey
                    ratio = (kx * ey - ky * ex) / (along if along != 0.0 else 1.0)
                    sum_r[c] = ratio * (begin_r[c] - finish_r[c])
                    sum_i[c] = ratio * (begin_i[c] - finish_i[c])
                for c in range(flat_low, flat_high):
                    kx = kx_of[c]
                    along = math.pi * (kx * ex + ky * ey)
                    turn = kx * 0.5 * (points[a, 0] + points[b, 0]) + ky * 0.5 * (points[a, 1] + points[b, 1])
                    turn = 2.0 * math.pi * (turn - math.floor(turn))
                    # 2πi·exp(−2πi k·m)·sinc(k·e), the sinc to 1e-16
                    size = (
                        2.0 * math.pi * (kx * ey - ky * ex) * (1.0 - along * along / 6.0 * (1.0 - along * along / 20.0))
                    )
                    sum_r[c], sum_i[c] = size * math.sin(turn), size * math.cos(turn)
                for side in sides[first[e] : first[e + 1]]:
                    times = jump[e, side]
                    for c in range(wide):
                        sums[side, 0, c] += times * sum_r[c]
                        sums[side, 1, c] += times * sum_i[c]
            for side in range(len(out)):
                out[side, r, :, low : low + width] = sums[side, :, :width]
