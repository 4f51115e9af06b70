"""Sums of a scene's transforms times a lens's on the photosites' grid of frequencies; arrays only.

The scene's are 4π²|k|² times what they are, as ``edge_transforms`` has them; the area takes their place at k = 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.kernels import kernel
from camsim.rendering.fourier.blocks import Place

COLUMNS = 128  # frequencies at a time: their phases stay in the nearest cache; rows cut out, so that loops are vectors


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


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
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


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
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
            begin, stop = max(0, -furthest - first_i), min(count_i, furthest - first_i + 1)
            foot_r, foot_i, scale = np.empty(COLUMNS), np.empty(COLUMNS), np.empty(COLUMNS)
            scene_r, scene_i, value_r, value_i = (
                np.empty(COLUMNS),
                np.empty(COLUMNS),
                np.empty(COLUMNS),
                np.empty(COLUMNS),
            )
            for low in range(begin, stop, COLUMNS):
                width = min(COLUMNS, stop - low)
                zero = -first_i - low if first_j + r == 0 and 0 <= -first_i - low < width else -1
                multiply(r, low, footprint, foot_r[:width], foot_i[:width])
                for c in range(width):
                    kx = (first_i + low) / px + c / px
                    square = kx * kx + ky * ky
                    scale[c] = 1.0 / (4.0 * math.pi * math.pi * (square if square > 0.0 else 1.0))
                for k in range(channels):
                    value_r[:width] = 0.0
                    value_i[:width] = 0.0
                    for j in range(wavelengths):
                        scene_r[:width] = 0.0
                        scene_i[:width] = 0.0
                        area = 0.0
                        for s in range(spectra):
                            weight = weights[s, k, j]
                            if weight == 0.0:
                                continue
                            area += weight * areas[s]
                            real, imaginary = (
                                transforms[s, r, 0, low : low + width],
                                transforms[s, r, 1, low : low + width],
                            )
                            for c in range(width):
                                scene_r[c] += weight * scale[c] * real[c]
                                scene_i[c] += weight * scale[c] * imaginary[c]
                        if zero >= 0:
                            scene_r[zero], scene_i[zero] = area, 0.0
                        lens = fields[j, r, low : low + width]
                        for c in range(width):
                            value_r[c] += scene_r[c] * lens[c, 0] - scene_i[c] * lens[c, 1]
                            value_i[c] += scene_r[c] * lens[c, 1] + scene_i[c] * lens[c, 0]
                    sums = total[k, target, column + low : column + low + width]
                    for c in range(width):
                        sums[c, 0] += value_r[c] * foot_r[c] - value_i[c] * foot_i[c]
                        sums[c, 1] += value_r[c] * foot_i[c] + value_i[c] * foot_r[c]
