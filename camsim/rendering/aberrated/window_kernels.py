"""A window's sum on the photosites' own grid of frequencies, from its edges or from their transforms; arrays only.

A row of frequencies and its mirror image are done together: one row of the difference's table has both, and a corner's
phases are products of the same four. Edges are taken corner by corner: 4π²|k|²·F = Σ phase·(ratio of the edge that
begins there − ratio of the one that ends there), see fourier/edge_transforms.py. The table has the 1/4π²|k|² in it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel
from camsim.rendering.fourier.edge_transforms import FLAT, Corners
from camsim.rendering.fourier.kernels import Factors, multiply

COLUMNS = 64  # frequencies at a time, always as many: vectors, and nothing is left over


def frequencies_within(cut: float, period: int) -> int:
    """Return how many frequencies of a window there are from 0 on, up to a multiple of ``COLUMNS``."""
    return COLUMNS * (math.floor(cut * period) // COLUMNS + 1)


class Table(NamedTuple):
    """The difference's transfers as windows multiply by them.

    fields : (b, 2, j, 2, i) at (i, ±j)/period, footprint included, over 4π²|k|²;  at 0 as they are, and nothing
             beyond the band, up to a multiple of ``COLUMNS``
    weights : (spectra, channels, b);  areas: (spectra,) of the regions, which take the place of F at 0
    period : photosites;  cut: cycles/pitch
    """

    fields: F64
    weights: F64
    areas: F64
    period: int
    cut: float


class _Room(NamedTuple):
    """What one row writes to, ``COLUMNS`` frequencies at a time; frequencies last.

    sums   : (spectra, 2, 2) of +j and −j, real and imaginary;  shares: (spectra, 2, corners) what phases weigh
    ratio, kx : of an edge, of all
    product : (channels, 2, 2, i) of all of the row
    """

    sums: F64
    shares: F64
    ratio: F64
    kx: F64
    product: F64


@kernel(allocates=True, forceinline=True)
def _room(spectra: int, corners: int, channels: int, count: int) -> _Room:
    return _Room(
        np.empty((spectra, 2, 2, COLUMNS)),
        np.empty((spectra, 2, corners, COLUMNS)),
        np.empty(COLUMNS),
        np.empty(COLUMNS),
        np.empty((channels, 2, 2, count)),
    )


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
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
def _multiply(table: Table, j: int, sides: int, low: int, room: _Room) -> None:
    """Multiply part of rows j (side 0) and −j (1) of the scene's transforms by the table's."""
    for side in range(sides):
        for k in range(len(room.product)):
            product = room.product[k, side]
            real, imaginary = product[0, low : low + COLUMNS], product[1, low : low + COLUMNS]
            for c in range(COLUMNS):
                real[c], imaginary[c] = 0.0, 0.0
            for b in range(len(table.fields)):
                lens = table.fields[b, side, j]
                lens_r, lens_i = lens[0, low : low + COLUMNS], lens[1, low : low + COLUMNS]
                for s in range(len(table.weights)):
                    weight = table.weights[s, k, b]
                    if weight == 0.0:
                        continue
                    scene_r, scene_i = room.sums[s, side, 0], room.sums[s, side, 1]
                    for c in range(COLUMNS):
                        real[c] += weight * (scene_r[c] * lens_r[c] - scene_i[c] * lens_i[c])
                        imaginary[c] += weight * (scene_r[c] * lens_i[c] + scene_i[c] * lens_r[c])


@kernel(forceinline=True)
def _add(total: F64, period: int, j: int, side: int, end: int, room: _Room) -> None:
    """Add row j (side 0) or −j (1) up to ``end`` where its aliases fall, and those of its mirror image."""
    rows, half = total.shape[2], period // 2
    row = j % rows if side == 0 else (rows - j % rows) % rows
    other = (rows - row) % rows
    for k in range(len(total)):
        here_r, here_i, there_r, there_i = total[k, 0, row], total[k, 1, row], total[k, 0, other], total[k, 1, other]
        real, imaginary = room.product[k, side, 0], room.product[k, side, 1]
        for first in range(0, end, period):
            for c in range(min(half + 1, end - first)):
                here_r[c] += real[first + c]
                here_i[c] += imaginary[first + c]
            for c in range(half + 1, min(period, end - first)):
                there_r[period - c] += real[first + c]
                there_i[period - c] -= imaginary[first + c]
            # Frequencies that are their own mirror image's aliases: both are here.
            if first > 0:
                there_r[0] += real[first]
                there_i[0] -= imaginary[first]
            if 2 * half == period and first + half < end:
                there_r[half] += real[first + half]
                there_i[half] -= imaginary[first + half]


@kernel(forceinline=True)
def _flats(ky: float, end: int, edges: Corners, period: int, flats: I64) -> None:
    """Write from which i on, and before which, frequencies (i/period, ±ky) run nearly along each edge's normal."""
    points, begin, finish, _ = edges
    for e in range(len(begin)):
        ex = points[finish[e], 0] - points[begin[e], 0]
        for side in range(2):
            along = (ky if side == 0 else -ky) * (points[finish[e], 1] - points[begin[e], 1])
            if abs(ex) * end > 1e-12 * period * FLAT:
                middle, half = -along / ex * period, FLAT / abs(ex) * period
                low, high = max(middle - half, 0.0), min(middle + half, end - 1.0)
                flats[e, side, 0], flats[e, side, 1] = (math.ceil(low), math.floor(high) + 1) if low <= high else (0, 0)
            else:
                flats[e, side, 0], flats[e, side, 1] = 0, end if abs(along) < FLAT else 0


@kernel(forceinline=True)
def _of_edges(ky: float, low: int, edges: Corners, period: int, flats: I64, room: _Room) -> None:
    """Write what phases weigh, and begin the sums with what edges give along their normals."""
    points, begin, finish, jump = edges
    sums, shares, kx, ratio = room.sums, room.shares, room.kx, room.ratio
    for s in range(jump.shape[1]):
        for side in range(2):
            for c in range(COLUMNS):
                sums[s, side, 0, c], sums[s, side, 1, c] = 0.0, 0.0
            for v in range(len(points)):
                for c in range(COLUMNS):
                    shares[s, side, v, c] = 0.0
    for c in range(COLUMNS):
        kx[c] = (low + c) / period
    for e in range(len(begin)):
        a, b = begin[e], finish[e]
        ex, ey = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
        for side in range(2 if ky > 0.0 else 1):
            own = ky if side == 0 else -ky
            for c in range(COLUMNS):
                along = kx[c] * ex + own * ey
                ratio[c] = (kx[c] * ey - own * ex) / (along if along != 0.0 else 1.0)
            for i in range(max(flats[e, side, 0], low), min(flats[e, side, 1], low + COLUMNS)):
                c = i - low
                ratio[c] = 0.0
                along = math.pi * (kx[c] * ex + own * ey)
                turn = kx[c] * 0.5 * (points[a, 0] + points[b, 0]) + own * 0.5 * (points[a, 1] + points[b, 1])
                turn = 2.0 * math.pi * (turn - math.floor(turn))
                # 2πi·exp(−2πi k·m)·sinc(k·e), the sinc to 1e-16
                size = 1.0 - along * along / 6.0 * (1.0 - along * along / 20.0)
                size *= 2.0 * math.pi * (kx[c] * ey - own * ex)
                for s in range(jump.shape[1]):
                    sums[s, side, 0, c] += jump[e, s] * size * math.sin(turn)
                    sums[s, side, 1, c] += jump[e, s] * size * math.cos(turn)
            for s in range(jump.shape[1]):
                times = jump[e, s]
                if times != 0.0:
                    for c in range(COLUMNS):
                        shares[s, side, a, c] += times * ratio[c]
                        shares[s, side, b, c] -= times * ratio[c]


@kernel(forceinline=True)
def _of_corner(v: int, x_r: F64, x_i: F64, y_r: float, y_i: float, room: _Room) -> None:
    """Add a corner's phases, from those along x and down y, times what they weigh."""
    sums, shares = room.sums, room.shares
    for s in range(len(sums)):
        for c in range(COLUMNS):
            a, b, d, e = x_r[c] * y_r, x_i[c] * y_i, x_r[c] * y_i, x_i[c] * y_r
            above, below = shares[s, 0, v, c], shares[s, 1, v, c]
            sums[s, 0, 0, c] += above * (a - b)
            sums[s, 0, 1, c] += above * (d + e)
            sums[s, 1, 0, c] += below * (a + b)
            sums[s, 1, 1, c] += below * (e - d)


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_edges(total: F64, table: Table, edges: Corners, across: F64, first: int, stop: int) -> None:
    """Add a window's edges to rows ``first`` … ``stop`` of ``total`` (channels, 2, rows, columns), and their mirror's.

    across : (2, corners, i) phases along x, as far as the table goes
    """
    rows, period, corners, spectra = total.shape[2], table.period, len(edges.points), edges.jump.shape[1]
    room = _room(spectra, corners, len(total), table.fields.shape[4])
    y_r, y_i, flats = np.empty(corners), np.empty(corners), np.empty((len(edges.begin), 2, 2), np.int64)
    for target in range(first, stop):
        for turn in range(2 * (table.fields.shape[2] // rows + 1)):
            # Rows of the band that fall on this one, and on its mirror image.
            j = turn // 2 * rows + (target if turn % 2 == 0 else rows - target)
            if j >= table.fields.shape[2] or (turn % 2 == 1 and (target == 0 or 2 * target == rows)):
                continue
            end, ky = _furthest(j, table) + 1, j / period
            for v in range(corners):
                place = edges.points[v, 1] * j / period
                place -= math.floor(place)
                y_r[v], y_i[v] = math.cos(2.0 * math.pi * place), -math.sin(2.0 * math.pi * place)
            sides = 2 if j > 0 else 1
            _flats(ky, end, edges, period, flats)
            for low in range(0, end, COLUMNS):
                _of_edges(ky, low, edges, period, flats, room)
                for v in range(corners):
                    x_r, x_i = across[0, v, low : low + COLUMNS], across[1, v, low : low + COLUMNS]
                    _of_corner(v, x_r, x_i, y_r[v], y_i[v], room)
                if j == 0 and low == 0:
                    for s in range(spectra):
                        room.sums[s, 0, 0, 0], room.sums[s, 0, 1, 0] = table.areas[s], 0.0
                _multiply(table, j, sides, low, room)
            for side in range(sides):
                _add(total, period, j, side, end, room)


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_strip(total: F64, table: Table, first_j: int, transforms: C128, first: int, stop: int) -> None:
    """Add rows j = first_j … of the scene's transforms (spectra, j, i), all of one sign or 0, likewise."""
    rows, spectra, most = total.shape[2], len(transforms), table.fields.shape[4]
    room, sums = _room(spectra, 0, len(total), most), np.zeros((spectra, 2, most))
    for r in range(transforms.shape[1]):
        j, side = abs(first_j + r), 0 if first_j + r >= 0 else 1
        target = min(j % rows, rows - j % rows)
        if target < first or target >= stop:
            continue
        end = min(transforms.shape[2], _furthest(j, table) + 1)
        sums[:] = 0.0
        for s in range(spectra):
            for c in range(end):
                sums[s, 0, c], sums[s, 1, c] = transforms[s, r, c].real, transforms[s, r, c].imag
            if j == 0:
                sums[s, 0, 0], sums[s, 1, 0] = table.areas[s], 0.0
        for low in range(0, end, COLUMNS):
            for s in range(spectra):
                for part in range(2):
                    room.sums[s, side, part] = sums[s, part, low : low + COLUMNS]
            _multiply(table, j, side + 1, low, room)
        _add(total, table.period, j, side, end, room)
