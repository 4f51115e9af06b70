"""Transforms of regions from their edges, and their sum on the photosites' grid of frequencies; arrays only.

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

TURNS, PRODUCTS = 5_000, 50_000  # phases, and edges × frequencies: fewer are no work for a thread of its own
COLUMNS = 128  # frequencies at a time: their phases stay in the nearest cache; rows cut out, so that loops are vectors
FLAT = 1e-3  # below this k·e the difference of the ends' phases is taken as a sinc


class Factors(NamedTuple):
    """A transfer on a block of frequencies as a product; real and imaginary part last."""

    across: F64  # (count_i, 2)
    down: F64  # (count_j, 2)
    both: F64  # (count_j, count_i, 2), or (0, 0, 2) where there is no more to it


class SceneBlock(NamedTuple):
    """What the scene gives on a block of frequencies."""

    transforms: F64  # (spectra, count_j, 2, count_i)
    areas: F64  # (spectra,)


class Curves(NamedTuple):
    """A round lens's transfer for every spectrum and channel, as piecewise polynomials of |k|."""

    cells: F64  # (cells, spectra, channels, 8)
    per_frequency: float  # cells in a cycle/pitch


class Corners(NamedTuple):
    """Edges by the corners that they share."""

    points: F64  # (n, 2)
    begin: I64  # (edges,) index of each edge's ends
    finish: I64
    jump: F64  # (edges, spectra) of how much of each there is more to its left than to its right


@kernel(error_model="numpy", fastmath={"contract"})
def multiply(r: int, low: int, factors: Factors, real: F64, imaginary: F64) -> None:
    """Set real and imaginary part to the product for row r, from column ``low`` on."""
    width = real.size
    across, down_r, down_i = factors.across[low : low + width], factors.down[r, 0], factors.down[r, 1]
    for c in range(width):
        real[c] = down_r * across[c, 0] - down_i * across[c, 1]
        imaginary[c] = down_r * across[c, 1] + down_i * across[c, 0]
    if len(factors.both):
        both = factors.both[r, low : low + width]
        for c in range(width):
            product = real[c] * both[c, 0] - imaginary[c] * both[c, 1]
            imaginary[c] = real[c] * both[c, 1] + imaginary[c] * both[c, 0]
            real[c] = product


def edge_transforms(place: Place, edges: Corners) -> F64:
    """Return 4π²|k|²·F of every spectrum's regions, real and imaginary part: (spectra, count_j, 2, count_i).

    Beyond the cut they are left at 0.
    """
    out = np.zeros((edges.jump.shape[1], place.count_j, 2, place.count_i))
    across = np.empty((2, len(edges.points), place.count_i))
    of_row = place.count_i * max(1, len(edges.points))
    turned = functools.partial(turn_across, place, edges.points, across)
    shared(len(edges.points), turned, least=-(-TURNS // place.count_i))
    shared(place.count_j, functools.partial(_transform, place, edges, across, out), least=-(-PRODUCTS // of_row))
    return out


@kernel(error_model="numpy", fastmath={"contract"})
def turn_across(place: Place, points: F64, across: F64, low: int, high: int) -> None:
    """Write some corners' phases along the first axis."""
    for v in range(low, high):
        for c in range(place.count_i):
            turn = points[v, 0] * (place.first_i + c) / place.px
            turn -= math.floor(turn)
            across[0, v, c], across[1, v, c] = math.cos(2.0 * math.pi * turn), -math.sin(2.0 * math.pi * turn)


@kernel(error_model="numpy", fastmath={"contract"})
def _transform(place: Place, edges: Corners, across: F64, out: F64, low_row: int, high_row: int) -> None:
    """Add every edge to some rows."""
    points, begin, finish, jump = edges
    first_i, first_j, count_i = place.first_i, place.first_j, place.count_i
    px, py, cut = place.px, place.py, place.cut
    xr, xi = across[0], across[1]
    corners = len(points)
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
        for low in range(lowest, stop, COLUMNS):
            width = min(COLUMNS, stop - low)
            start_x = (first_i + low) / px
            for c in range(width):
                kx_of[c] = start_x + c / px
            for v in range(corners):
                across_r, across_i, down_r, down_i = xr[v, low : low + width], xi[v, low : low + width], yr[v], yi[v]
                phase_r, phase_i = ar[v], ai[v]
                for c in range(width):
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
                for c in range(width):
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
                for side in range(len(out)):
                    times = jump[e, side]
                    if times != 0.0:
                        out_r, out_i = out[side, r, 0, low : low + width], out[side, r, 1, low : low + width]
                        for c in range(width):
                            out_r[c] += times * sum_r[c]
                            out_i[c] += times * sum_i[c]


@kernel(error_model="numpy", fastmath={"contract"})
def add_round(
    total: F64, scene: SceneBlock, footprint: Factors, lens_curves: Curves, place: Place, low_row: int, high_row: int
) -> None:
    """Add a block of round kernels to some rows of ``total`` (channels, rows, columns, 2)."""
    transforms, areas = scene
    curves, cells_per_frequency = lens_curves
    first_i, first_j, column, row, rows = place.first_i, place.first_j, place.column, place.row, place.rows
    px, py, cut = place.px, place.py, place.cut
    spectra, count_j, _, count_i = transforms.shape
    channels = total.shape[0]
    last = len(curves) - 1
    # One thread for each row of the photosites' grid: what the rows of a block add to it comes in one order.
    for target in range(low_row, high_row):
        for r in range((target - row) % rows, count_j, rows):
            ky = (first_j + r) / py
            inside = cut * cut - ky * ky
            if inside <= 0.0:
                continue
            furthest = math.floor(px * math.sqrt(inside))
            begin, stop = max(0, -furthest - first_i), min(count_i, furthest - first_i + 1)
            cell, t, scale = np.empty(COLUMNS, np.int64), np.empty(COLUMNS), np.empty(COLUMNS)
            sum_r, sum_i = np.empty(COLUMNS), np.empty(COLUMNS)
            foot_r, foot_i, lens = np.empty(COLUMNS), np.empty(COLUMNS), np.empty(COLUMNS)
            for low in range(begin, stop, COLUMNS):
                width = min(COLUMNS, stop - low)
                start_x = (first_i + low) / px
                for c in range(width):
                    kx = start_x + c / px
                    square = kx * kx + ky * ky
                    t[c] = math.sqrt(square) * cells_per_frequency
                    scale[c] = 1.0 / (4.0 * math.pi * math.pi * (square if square > 0.0 else 1.0))
                for c in range(width):
                    cell[c] = min(int(t[c]), last)
                    t[c] -= cell[c]
                multiply(r, low, footprint, foot_r[:width], foot_i[:width])
                for k in range(channels):
                    sum_r[:width] = 0.0
                    sum_i[:width] = 0.0
                    for s in range(spectra):
                        real, imaginary = transforms[s, r, 0, low : low + width], transforms[s, r, 1, low : low + width]
                        for c in range(width):
                            p, u = curves[cell[c], s, k], t[c]
                            u2 = u * u
                            low_half = p[0] + u * p[1] + u2 * (p[2] + u * p[3])
                            lens[c] = low_half + u2 * u2 * (p[4] + u * p[5] + u2 * (p[6] + u * p[7]))
                        for c in range(width):
                            sum_r[c] += lens[c] * real[c]
                            sum_i[c] += lens[c] * imaginary[c]
                    if first_j + r == 0 and first_i + low <= 0 < first_i + low + width:
                        zero = -first_i - low
                        scale[zero], sum_i[zero], sum_r[zero] = 1.0, 0.0, 0.0
                        for s in range(spectra):
                            sum_r[zero] += curves[0, s, k, 0] * areas[s]
                    sums = total[k, target, column + low : column + low + width]
                    for c in range(width):
                        value_r, value_i = sum_r[c] * scale[c], sum_i[c] * scale[c]
                        sums[c, 0] += value_r * foot_r[c] - value_i * foot_i[c]
                        sums[c, 1] += value_r * foot_i[c] + value_i * foot_r[c]


@kernel()
def add_fields(
    total: F64,
    scene: SceneBlock,
    footprint: Factors,
    fields: F64,
    weights: F64,
    place: Place,
    low_row: int,
    high_row: int,
) -> None:
    """Add a block of kernels that are given frequency by frequency to some rows.

    fields  : (j, count_j, count_i, 2) transfer of the lens at each wavelength;  weights: (spectra, channels, j)
    """
    transforms, areas = scene
    first_i, first_j, column, row, rows = place.first_i, place.first_j, place.column, place.row, place.rows
    px, py, cut = place.px, place.py, place.cut
    spectra, count_j, _, count_i = transforms.shape
    channels, wavelengths = total.shape[0], len(fields)
    # One thread for each row of the photosites' grid: what the rows of a block add to it comes in one order.
    for target in range(low_row, high_row):
        for r in range((target - row) % rows, count_j, rows):
            ky = (first_j + r) / py
            inside = cut * cut - ky * ky
            if inside <= 0.0:
                continue
            furthest = math.floor(px * math.sqrt(inside))
            foot_r, foot_i = np.empty(count_i), np.empty(count_i)
            multiply(r, 0, footprint, foot_r, foot_i)
            for c in range(max(0, -furthest - first_i), min(count_i, furthest - first_i + 1)):
                kx = (first_i + c) / px
                square = kx * kx + ky * ky
                scale = 1.0 / (4.0 * math.pi * math.pi * square) if square > 0.0 else 0.0
                for k in range(channels):
                    value_r, value_i = 0.0, 0.0
                    for j in range(wavelengths):
                        scene_r, scene_i = 0.0, 0.0
                        for s in range(spectra):
                            if square > 0.0:
                                scene_r += weights[s, k, j] * transforms[s, r, 0, c] * scale
                                scene_i += weights[s, k, j] * transforms[s, r, 1, c] * scale
                            else:
                                scene_r += weights[s, k, j] * areas[s]
                        lens_r, lens_i = fields[j, r, c, 0], fields[j, r, c, 1]
                        value_r += scene_r * lens_r - scene_i * lens_i
                        value_i += scene_r * lens_i + scene_i * lens_r
                    total[k, target, column + c, 0] += value_r * foot_r[c] - value_i * foot_i[c]
                    total[k, target, column + c, 1] += value_r * foot_i[c] + value_i * foot_r[c]
