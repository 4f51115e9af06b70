"""The sums over frequencies, as kernels."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel

HERMITE = 4


@kernel()
def add_curves(
    total: C128,
    source: C128,
    curves: F64,
    footprint: tuple[C128, C128, C128],
    share: tuple[F64, float],
    scale: tuple[float, float, float],
    begin: int,
    stop: int,
) -> None:
    """Add source × transfer to rows begin … stop of the photosites' lattice, for a round lens.

    total  : (channels, rows, cols) the image's transform, aliases added up
    source : (kinds, 2n − 1, m) transforms at j = −n … n, i = 0 … m
    curves : (points, kinds, channels) the lens at radial frequencies in even steps
    footprint : its transfer along x (m,), along y (2n − 1,), and what is no product of these (2n − 1, m) or (0, 0)
    share  : how much of a frequency is this level's: values on straight lines, points per cycle/pitch
    scale  : steps of i and of j in cycles/pitch, points per cycle/pitch
    """
    (across, down, both), (step_x, step_y, per) = footprint, scale
    kinds, lines, columns = source.shape
    channels, rows, cols = total.shape
    points, middle = len(curves), lines // 2
    most = (points - 1) / per
    for row in range(begin, stop):
        first = row - ((row + middle) // rows) * rows
        for j in range(first, middle + 1, rows):
            fy = j * step_y
            if abs(fy) >= most:
                continue
            last = min(columns - 1, int(math.sqrt(most * most - fy * fy) / step_x))
            own = down[j + middle]
            col = 0
            for i in range(last + 1):
                fx = i * step_x
                radius = math.sqrt(fx * fx + fy * fy)
                place = radius * per
                at = int(place)
                if at < points - 1:
                    t = place - at
                    times = across[i] * own * _line(share, radius)
                    if both.size:
                        times *= both[j + middle, i]
                    if i == 0:
                        times *= 0.5
                    for c in range(channels):
                        value = 0j
                        for k in range(kinds):
                            lens = curves[at, k, c] + t * (curves[at + 1, k, c] - curves[at, k, c])
                            value += source[k, j + middle, i] * lens
                        total[c, row, col] += value * times
                col += 1
                if col == cols:
                    col = 0


@kernel()
def _line(share: tuple[F64, float], frequency: float) -> float:
    """Return the value at a frequency, on straight lines; the last beyond the end."""
    values, per = share
    place = frequency * per
    at = int(place)
    if at >= len(values) - 1:
        return float(values[-1])
    return float(values[at] + (place - at) * (values[at + 1] - values[at]))


@kernel(allocates=True)
def add_polar(
    total: F64,
    source: C128,
    polar: F64,
    there: I64,
    footprint: tuple[C128, C128, C128],
    share: tuple[F64, float],
    scale: tuple[float, float, float],
    begin: int,
    stop: int,
) -> None:
    """Add source × transfer where that depends on direction.

    total : (rows, cols, 2·channels), and polar: (points, directions + 3, kinds, 2·channels): real and imaginary parts
    in turn, so that loops over channels are vectors. Directions run evenly from a step before −π/2 to two past π/2, or
    there is one.
    there : (points,) how many channels, the first ones, are summed at a radius
    All else as of ``add_curves``.
    """
    (across, down, both), (step_x, step_y, per) = footprint, scale
    kinds, lines, columns = source.shape
    rows, cols, parts = total.shape
    points, middle = len(polar), lines // 2
    turns = polar.shape[1]
    per_turn = (turns - 3) / math.pi
    most = (points - 1) / per
    lens = np.empty(parts)
    radial, turned = np.empty(4), np.ones(4)
    ways = 1 if turns == 1 else 4
    for row in range(begin, stop):
        first = row - ((row + middle) // rows) * rows
        for j in range(first, middle + 1, rows):
            fy = j * step_y
            if abs(fy) >= most:
                continue
            last = min(columns - 1, int(math.sqrt(most * most - fy * fy) / step_x))
            own = down[j + middle]
            col = 0
            for i in range(last + 1):
                fx = i * step_x
                radius = math.sqrt(fx * fx + fy * fy)
                place = radius * per
                at = min(max(int(place), 1), points - 3)
                if place <= points - 1:
                    times = across[i] * own * _line(share, radius)
                    if both.size:
                        times *= both[j + middle, i]
                    if i == 0:
                        times *= 0.5
                    _cubic(place - at, radial)
                    way = 1
                    if turns > 1:
                        turn = (math.atan2(fy, fx) + 0.5 * math.pi) * per_turn + 1.0
                        way = min(max(int(turn), 1), turns - 3)
                        _cubic(turn - way, turned)
                    parts = 2 * there[at]
                    for k in range(kinds):
                        value = source[k, j + middle, i] * times
                        for c in range(parts):
                            lens[c] = 0.0
                        for q in range(4):
                            for t in range(ways):
                                weight = radial[q] * turned[t]
                                near = polar[at + q - 1, way + t - 1, k]
                                for c in range(parts):
                                    lens[c] += weight * near[c]
                        here = total[row, col]
                        for c in range(0, parts, 2):
                            here[c] += value.real * lens[c] - value.imag * lens[c + 1]
                            here[c + 1] += value.real * lens[c + 1] + value.imag * lens[c]
                col += 1
                if col == cols:
                    col = 0


@kernel()
def channels_first(sums: F64, total: C128, begin: int, stop: int) -> None:
    """Add rows begin … stop of ``add_polar``'s sums (rows, cols, 2·channels) to a total (channels, rows, cols)."""
    for row in range(begin, stop):
        for c in range(len(total)):
            for col in range(total.shape[2]):
                total[c, row, col] += complex(sums[row, col, 2 * c], sums[row, col, 2 * c + 1])


@kernel()
def between(coarse: F64, down: bool, first: I64, taps: F64, out: F64, begin: int, stop: int) -> None:
    """Write rows begin … stop of what coarse points (n, rows, cols) are between them, down columns or along rows.

    first : of the points that a place of ``out`` is made of;  taps: (places, taps) their weights
    """
    count = taps.shape[1]
    for n in range(len(out)):
        for row in range(begin, stop):
            here = out[n, row]
            if down:
                for tap in range(count):
                    own, weight = coarse[n, first[row] + tap], taps[row, tap]
                    for col in range(len(here)):
                        here[col] += weight * own[col]
            else:
                own = coarse[n, row]
                for col in range(len(here)):
                    total = 0.0
                    for tap in range(count):
                        total += own[first[col] + tap] * taps[col, tap]
                    here[col] = total


@kernel()
def mix(image: F64, each: F64, down: F64, across: F64, begin: int, stop: int) -> None:
    """Add Σ_m (Σ_a down[a]·across[a])·each[m] to rows begin … stop of an image (channels, rows, cols).

    each : (m, rows, cols);  down: (rows, channels, m, a) and across: (a, cols) what a mixture's amount is at a place
    """
    count, cols = across.shape
    for row in range(begin, stop):
        for c in range(len(image)):
            for m in range(len(each)):
                for a in range(count):
                    weight = down[row, c, m, a]
                    for i in range(cols):
                        image[c, row, i] += weight * across[a, i] * each[m, row, i]


@kernel()
def _cubic(t: float, weights: F64) -> None:
    """Write Lagrange's weights of places −1, 0, 1 and 2 at t."""
    a, b, c = t + 1.0, t - 1.0, t - 2.0
    weights[0], weights[1] = -t * b * c / 6.0, a * b * c / 2.0
    weights[2], weights[3] = -a * t * c / 2.0, a * t * b / 6.0


@kernel()
def slope(whole: C128, middle: int, step_x: float, step_y: float, area: float, begin: int, stop: int) -> None:
    """Make of Σ (ey + i·ex)·exp(−2πi f·y) over closed outlines the transform of what they enclose, in rows.

    Σ (f·e)·exp(−2πi f·y) = 0 and (fx + i·fy)(ey + i·ex) = fx·ey − fy·ex + i·(f·e), over −2πi|f|² by Stokes.
    """
    for row in range(begin, stop):
        fy = (row - middle) * step_y
        for col in range(whole.shape[1]):
            fx = col * step_x
            square = 2.0 * math.pi * (fx * fx + fy * fy)
            if square == 0.0:
                whole[row, col] = area
            else:
                whole[row, col] *= complex(-fy / square, fx / square)
