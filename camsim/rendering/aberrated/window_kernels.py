"""A window's sum on the photosites' own grid of frequencies, from its edges or from their transforms; arrays only.

A row of frequencies and its mirror image are done together: one row of the difference's table has both, and a corner's
phases are products of the same four. Edges are taken corner by corner: 4π²|k|²·F = Σ phase·(ratio of the edge that
begins there − ratio of the one that ends there), see fourier/edge_transforms.py. The table has the 1/4π²|k|² in it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64
from camsim.kernels import kernel
from camsim.rendering.fourier.edge_transforms import FLAT, Corners
from camsim.rendering.fourier.kernels import Factors, multiply

COLUMNS = 64  # frequencies at a time: what a corner takes of them stays in the nearest cache


class Table(NamedTuple):
    """The difference's transfers as windows multiply by them.

    fields : (b, 2, j, 2, i) at (i, ±j)/period, footprint included, over 4π²|k|²;  at 0 as they are
    weights : (spectra, channels, b);  areas: (spectra,) of the regions, which take the place of F at 0
    period : photosites;  cut: cycles/pitch
    """

    fields: F64
    weights: F64
    areas: F64
    period: int
    cut: float


class _Room(NamedTuple):
    """What one piece of a row writes to; frequencies last.

    sums   : (spectra, 2, 2) of +j and −j, real and imaginary;  shares: (spectra, 2, corners) what phases weigh
    phase  : (4,) a corner's at +j and at −j;  ratio, kx: of an edge, of all;  product: (2,)
    """

    sums: F64
    shares: F64
    phase: F64
    ratio: F64
    kx: F64
    product: F64


@kernel(forceinline=True)
def _room(spectra: int, corners: int) -> _Room:
    return _Room(
        np.empty((spectra, 2, 2, COLUMNS)),
        np.empty((spectra, 2, corners, COLUMNS)),
        np.empty((4, COLUMNS)),
        np.empty(COLUMNS),
        np.empty(COLUMNS),
        np.empty((2, COLUMNS)),
    )


@kernel(error_model="numpy", fastmath={"contract"})
def with_footprint(values: F64, footprint: Factors, period: int, first: int, stop: int) -> None:
    """Multiply some rows of transfers (b, 2, j, 2, i) by the footprint's, and divide them by 4π²|k|².

    footprint : on (i, j) of either sign of j
    """
    count = values.shape[4]
    foot_r, foot_i = np.empty(count), np.empty(count)
    for j in range(first, stop):
        for side in range(2):
            multiply(values.shape[2] - 1 + (j if side == 0 else -j), 0, footprint, foot_r, foot_i)
            for c in range(count):
                square = float(c * c + j * j)
                scale = period * period / (4.0 * math.pi * math.pi * square) if square > 0.0 else 1.0
                foot_r[c] *= scale
                foot_i[c] *= scale
            for b in range(len(values)):
                real, imaginary = values[b, side, j, 0], values[b, side, j, 1]
                for c in range(count):
                    product = real[c] * foot_r[c] - imaginary[c] * foot_i[c]
                    imaginary[c] = real[c] * foot_i[c] + imaginary[c] * foot_r[c]
                    real[c] = product


@kernel(forceinline=True)
def _furthest(j: int, table: Table) -> int:
    """Return the last i of a row within the band, -1 if there is none."""
    inside = table.cut * table.cut - (j / table.period) ** 2
    return min(table.fields.shape[4] - 1, math.floor(table.period * math.sqrt(inside))) if inside > 0.0 else -1


@kernel(forceinline=True)
def _piece(low: int, end: int, period: int) -> int:
    """Return how many frequencies from ``low`` on, of those before ``end``, are in one half of an alias."""
    place = low % period
    return min(COLUMNS, end - low, (period // 2 + 1 if place <= period // 2 else period) - place)


@kernel(forceinline=True)
def _add(total: F64, table: Table, j: int, side: int, low: int, width: int, room: _Room) -> None:
    """Multiply a piece of row j (side 0) or −j (1) of the scene's transforms, and add it where its alias falls."""
    rows, period, place = total.shape[2], table.period, low % table.period
    row = j % rows if side == 0 else (rows - j % rows) % rows
    other = (rows - row) % rows
    real, imaginary = room.product[0], room.product[1]
    for k in range(len(total)):
        real[:width] = 0.0
        imaginary[:width] = 0.0
        for b in range(len(table.fields)):
            lens = table.fields[b, side, j]
            lens_r, lens_i = lens[0, low : low + width], lens[1, low : low + width]
            for s in range(len(table.weights)):
                weight = table.weights[s, k, b]
                if weight == 0.0:
                    continue
                scene_r, scene_i = room.sums[s, side, 0], room.sums[s, side, 1]
                for c in range(width):
                    real[c] += weight * (scene_r[c] * lens_r[c] - scene_i[c] * lens_i[c])
                    imaginary[c] += weight * (scene_r[c] * lens_i[c] + scene_i[c] * lens_r[c])
        if place <= period // 2:
            into_r, into_i = total[k, 0, row, place : place + width], total[k, 1, row, place : place + width]
            for c in range(width):
                into_r[c] += real[c]
                into_i[c] += imaginary[c]
            # A frequency that is its own mirror image's alias: both are here.
            if place == 0 and low > 0:
                total[k, 0, other, 0] += real[0]
                total[k, 1, other, 0] -= imaginary[0]
            last = place + width - 1
            if 2 * last == period:
                total[k, 0, other, last] += real[width - 1]
                total[k, 1, other, last] -= imaginary[width - 1]
        else:
            into_r, into_i = total[k, 0, other], total[k, 1, other]
            for c in range(width):
                into_r[period - place - c] += real[c]
                into_i[period - place - c] -= imaginary[c]


@kernel(forceinline=True)
def _flat(ky: float, first: float, width: int, ex: float, ey: float, period: int) -> tuple[int, int]:
    """Return which frequencies (first + c/period, ky) run nearly along the normal of an edge (ex, ey)."""
    if abs(ex) * width > 1e-12 * period * FLAT:
        middle, half = -ky * ey / ex, FLAT / abs(ex)
        low, high = (middle - half - first) * period, (middle + half - first) * period
        return (max(0, math.ceil(low)), min(width, math.floor(high) + 1)) if high >= 0.0 and low <= width else (0, 0)
    return (0, width) if abs(ky * ey + first * ex) < FLAT else (0, 0)


@kernel(forceinline=True)
def _of_edges(ky: float, low: int, width: int, edges: Corners, period: int, room: _Room) -> None:
    """Write what phases weigh, and begin the sums with what edges give along their normals."""
    points, begin, finish, jump = edges
    room.sums[:], room.shares[:] = 0.0, 0.0
    kx, ratio, first = room.kx, room.ratio, low / period
    for c in range(width):
        kx[c] = first + c / period
    for e in range(len(begin)):
        a, b = begin[e], finish[e]
        ex, ey = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
        for side in range(2 if ky > 0.0 else 1):
            own = ky if side == 0 else -ky
            for c in range(width):
                along = kx[c] * ex + own * ey
                ratio[c] = (kx[c] * ey - own * ex) / (along if along != 0.0 else 1.0)
            flat_low, flat_high = _flat(own, first, width, ex, ey, period)
            for c in range(flat_low, flat_high):
                ratio[c] = 0.0
                along = math.pi * (kx[c] * ex + own * ey)
                turn = kx[c] * 0.5 * (points[a, 0] + points[b, 0]) + own * 0.5 * (points[a, 1] + points[b, 1])
                turn = 2.0 * math.pi * (turn - math.floor(turn))
                # 2πi·exp(−2πi k·m)·sinc(k·e), the sinc to 1e-16
                size = 1.0 - along * along / 6.0 * (1.0 - along * along / 20.0)
                size *= 2.0 * math.pi * (kx[c] * ey - own * ex)
                for s in range(jump.shape[1]):
                    room.sums[s, side, 0, c] += jump[e, s] * size * math.sin(turn)
                    room.sums[s, side, 1, c] += jump[e, s] * size * math.cos(turn)
            for s in range(jump.shape[1]):
                times = jump[e, s]
                if times != 0.0:
                    here, there = room.shares[s, side, a], room.shares[s, side, b]
                    for c in range(width):
                        here[c] += times * ratio[c]
                        there[c] -= times * ratio[c]


@kernel(forceinline=True)
def _of_corner(v: int, x: tuple[F64, F64], y: tuple[float, float], room: _Room) -> None:
    """Add a corner's phases, from those along x and down y, times what they weigh."""
    above_r, above_i, below_r, below_i = room.phase[0], room.phase[1], room.phase[2], room.phase[3]
    width = x[0].size
    for c in range(width):
        a, b, d, e = x[0][c] * y[0], x[1][c] * y[1], x[0][c] * y[1], x[1][c] * y[0]
        above_r[c], above_i[c], below_r[c], below_i[c] = a - b, d + e, a + b, e - d
    for s in range(len(room.sums)):
        for side in range(2):
            share, real, imaginary = room.shares[s, side, v], room.sums[s, side, 0], room.sums[s, side, 1]
            phase_r, phase_i = room.phase[2 * side], room.phase[2 * side + 1]
            for c in range(width):
                real[c] += share[c] * phase_r[c]
                imaginary[c] += share[c] * phase_i[c]


@kernel(error_model="numpy", fastmath={"contract"})
def add_edges(total: F64, table: Table, edges: Corners, across: F64, first: int, stop: int) -> None:
    """Add a window's edges to rows ``first`` … ``stop`` of ``total`` (channels, 2, rows, columns), and their mirror's.

    across : (2, corners, i) phases along x
    """
    rows, period, corners, spectra = total.shape[2], table.period, len(edges.points), edges.jump.shape[1]
    room, y_r, y_i = _room(spectra, corners), np.empty(corners), np.empty(corners)
    for target in range(first, stop):
        for turn in range(2 * (table.fields.shape[2] // rows + 1)):
            # Rows of the band that fall on this one, and on its mirror image.
            j = turn // 2 * rows + (target if turn % 2 == 0 else rows - target)
            if j >= table.fields.shape[2] or (turn % 2 == 1 and (target == 0 or 2 * target == rows)):
                continue
            end, ky, low = _furthest(j, table) + 1, j / period, 0
            for v in range(corners):
                place = edges.points[v, 1] * j / period
                place -= math.floor(place)
                y_r[v], y_i[v] = math.cos(2.0 * math.pi * place), -math.sin(2.0 * math.pi * place)
            while low < end:
                width = _piece(low, end, period)
                _of_edges(ky, low, width, edges, period, room)
                for v in range(corners):
                    x = across[:, v, low : low + width]
                    _of_corner(v, (x[0], x[1]), (y_r[v], y_i[v]), room)
                if j == 0 and low == 0:
                    for s in range(spectra):
                        room.sums[s, 0, 0, 0], room.sums[s, 0, 1, 0] = table.areas[s], 0.0
                for side in range(2 if j > 0 else 1):
                    _add(total, table, j, side, low, width, room)
                low += width


@kernel(error_model="numpy", fastmath={"contract"})
def add_strip(total: F64, table: Table, first_j: int, transforms: C128, first: int, stop: int) -> None:
    """Add rows j = first_j … of the scene's transforms (spectra, j, i), all of one sign or 0, likewise."""
    rows, spectra = total.shape[2], len(transforms)
    room = _room(spectra, 0)
    for r in range(transforms.shape[1]):
        j, side = abs(first_j + r), 0 if first_j + r >= 0 else 1
        target = min(j % rows, rows - j % rows)
        if target < first or target >= stop:
            continue
        end, low = min(transforms.shape[2], _furthest(j, table) + 1), 0
        while low < end:
            width = _piece(low, end, table.period)
            for s in range(spectra):
                for c in range(width):
                    room.sums[s, side, 0, c] = transforms[s, r, low + c].real
                    room.sums[s, side, 1, c] = transforms[s, r, low + c].imag
                if j == 0 and low == 0:
                    room.sums[s, side, 0, 0], room.sums[s, side, 1, 0] = table.areas[s], 0.0
            _add(total, table, j, side, low, width, room)
            low += width
