"""Compiled kernels of the sums over frequencies."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import C128, F64, I64, Complex, Floats
from camsim.core.kernels import kernel

SMALL_PHASE = 1e-4  # radians below which a sinc is taken from its series


@kernel()
def add_curves(
    total: Complex,
    source: Complex,
    curves: F64,
    footprint: tuple[C128, C128, C128],
    share: tuple[F64, float],
    scale: tuple[float, float, float],
    lowest: int,
    begin: int,
    stop: int,
) -> None:
    """Add source × transfer to rows begin … stop of the photosites' lattice, for a rotationally symmetric lens.

    total  : (channels, rows, cols) the image's transform, with aliases summed; like ``source`` in single or double
             precision
    source : (kinds, n, m) transforms at j = lowest, lowest + 1 …, i = 0 … m
    curves : (points, kinds, channels) the lens at radial frequencies in even steps
    footprint : its transfer along x (m,), along y (n,), and the factor that is not separable (n, m) or (0, 0)
    share  : this level's share of a frequency, linearly interpolated: values, points per cycle/pitch
    scale  : steps of i and of j in cycles/pitch, points per cycle/pitch
    """
    (across, down, both), (step_x, step_y, per) = footprint, scale
    kinds, lines, columns = source.shape
    channels, rows, cols = total.shape
    points = len(curves)
    most = (points - 1) / per
    for row in range(begin, stop):
        first = row - ((row - lowest) // rows) * rows
        for j in range(first, lowest + lines, rows):
            fy = j * step_y
            if abs(fy) >= most:
                continue
            last = min(columns - 1, int(math.sqrt(most * most - fy * fy) / step_x))
            one = down[j - lowest]
            col = 0
            for i in range(last + 1):
                fx = i * step_x
                radius = math.sqrt(fx * fx + fy * fy)
                place = radius * per
                at = int(place)
                if at < points - 1:
                    t = place - at
                    times = across[i] * one * _line(share, radius)
                    if both.size:
                        times *= both[j - lowest, i]
                    if i == 0:
                        times *= 0.5
                    for c in range(channels):
                        value = 0j
                        for k in range(kinds):
                            lens = curves[at, k, c] + t * (curves[at + 1, k, c] - curves[at, k, c])
                            value += source[k, j - lowest, i] * lens
                        total[c, row, col] += value * times
                col += 1
                if col == cols:
                    col = 0


@kernel()
def _line(share: tuple[F64, float], frequency: float) -> float:
    """Return the linearly interpolated value at a frequency; the last value beyond the end."""
    values, per = share
    place = frequency * per
    at = int(place)
    if at >= len(values) - 1:
        return float(values[-1])
    return float(values[at] + (place - at) * (values[at + 1] - values[at]))


@kernel(allocates=True)
def add_polar(
    total: Complex,
    source: Complex,
    polar: F64,
    there: I64,
    real: bool,
    footprint: tuple[C128, C128, C128],
    share: tuple[F64, float],
    scale: tuple[float, float, float, float],
    turn: tuple[float, float, int, F64],
    lowest: int,
    begin: int,
    stop: int,
) -> None:
    """Add source × transfer for a transfer that depends on direction.

    total : (channels, rows, cols) as of ``add_curves``
    polar : (points, directions, kinds, 2·channels): real and imaginary parts interleaved, so that loops over channels
            vectorise, or (…, channels) real parts; in the precision of ``total``
    there : (points,) how many of the first channels are summed at a radius
    real  : whether ``polar`` has only real parts
    scale : as of ``add_curves``, and the highest frequency
    turn  : direction where the first panel begins, panels per radian, steps n in each; a panel has n + 3 directions,
            from a step before it to one past its end. A single direction stands for all. Last, (panels, 2) vectors
            whose product with a frequency is its radial coordinate, or an empty array: that is then |f|
    """
    (across, down, both), (step_x, step_y, per, most) = footprint, scale
    kinds, lines, columns = source.shape
    channels, rows, cols = total.shape
    points, directions, parts = len(polar), polar.shape[1], polar.shape[3]
    begins, per_radian, steps, border = turn
    panels = directions // (steps + 3)
    lens, sums = np.empty(parts, polar.dtype), np.empty((cols, 2 * channels), polar.dtype)
    radial, turned, places = np.empty(4), np.ones(4), np.empty(columns)
    near, value = np.empty((4, 4), polar.dtype), np.empty(2, polar.dtype)  # weights, and light
    for row in range(begin, stop):
        sums[:] = 0.0
        first = row - ((row - lowest) // rows) * rows
        for j in range(first, lowest + lines, rows):
            fy = j * step_y
            if abs(fy) >= most:
                continue
            last = min(columns - 1, int(math.sqrt(most * most - fy * fy) / step_x))
            one = down[j - lowest]
            col = 0
            if directions > 1:  # apart, as the function holds up what follows
                for i in range(last + 1):
                    places[i] = max((math.atan2(fy, i * step_x) - begins) * per_radian, 0.0)
            for i in range(last + 1):
                fx = i * step_x
                radius = math.sqrt(fx * fx + fy * fy)
                panel = 0
                place = 0.0
                along = radius
                way = 0
                if directions > 1:
                    panel = min(int(places[i]), panels - 1)
                    place = (places[i] - panel) * steps + 1.0
                    if len(border):
                        along = fx * border[panel, 0] + fy * border[panel, 1]
                    way = min(max(int(place), 1), steps)
                    _cubic(place - way, turned)
                    way += panel * (steps + 3) - 1
                place = along * per
                at = min(max(int(place), 1), points - 3)
                if place <= points - 1:
                    times = across[i] * one * _line(share, radius)
                    if both.size:
                        times *= both[j - lowest, i]
                    if i == 0:
                        times *= 0.5
                    _cubic(place - at, radial)
                    for q in range(4):
                        for t in range(4):
                            near[q, t] = radial[q] * turned[t]
                    parts = there[at] if real else 2 * there[at]
                    here = sums[col]
                    for k in range(kinds):
                        light = source[k, j - lowest, i] * times
                        value[0], value[1] = light.real, light.imag
                        _mix(polar, at - 1, way, k, near, lens, parts)
                        if real:
                            for c in range(parts):
                                here[2 * c] += value[0] * lens[c]
                                here[2 * c + 1] += value[1] * lens[c]
                            continue
                        for c in range(0, parts, 2):
                            here[c] += value[0] * lens[c] - value[1] * lens[c + 1]
                            here[c + 1] += value[0] * lens[c + 1] + value[1] * lens[c]
                col += 1
                if col == cols:
                    col = 0
        for c in range(channels):
            for i in range(cols):
                total[c, row, i] += complex(sums[i, 2 * c], sums[i, 2 * c + 1])


@kernel()
def _mix(polar: F64, at: int, way: int, k: int, weights: F64, lens: F64, parts: int) -> None:
    """Write the weighted sum over four radii and four directions; a single direction stands for all."""
    for q in range(4):
        w0, w1, w2, w3 = weights[q, 0], weights[q, 1], weights[q, 2], weights[q, 3]
        for c in range(parts):
            if polar.shape[1] == 1:
                total = w0 * polar[at + q, 0, k, c]
            else:
                total = (
                    w0 * polar[at + q, way, k, c]
                    + w1 * polar[at + q, way + 1, k, c]
                    + w2 * polar[at + q, way + 2, k, c]
                    + w3 * polar[at + q, way + 3, k, c]
                )
            lens[c] = lens[c] + total if q else total


@kernel()
def between(coarse: F64, down: bool, first: I64, taps: F64, out: F64, begin: int, stop: int) -> None:
    """Interpolate rows begin … stop of ``out`` from coarse points (n, rows, cols), down columns or along rows.

    first : index of the first point that a place of ``out`` uses;  taps: (places, taps) weights of the points
    """
    count = taps.shape[1]
    for n in range(len(out)):
        for row in range(begin, stop):
            here = out[n, row]
            if down:
                for tap in range(count):
                    one, weight = coarse[n, first[row] + tap], taps[row, tap]
                    for col in range(len(here)):
                        here[col] += weight * one[col]
            else:
                one = coarse[n, row]
                for col in range(len(here)):
                    total = 0.0
                    for tap in range(count):
                        total += one[first[col] + tap] * taps[col, tap]
                    here[col] = total


@kernel(allocates=True)
def mix(image: F64, one: Floats, down: F64, across: F64, begin: int, stop: int) -> None:
    """Add (Σ_a down[a]·across[a])·one to rows begin … stop of an image (channels, rows, cols).

    one : (rows, cols);  down: (rows, channels, a) and across: (a, cols) factors of a mixture's weight
    """
    count, cols = across.shape
    parts = np.empty((count, cols))
    for row in range(begin, stop):
        for a in range(count):
            for i in range(cols):
                parts[a, i] = across[a, i] * one[row, i]
        for c in range(len(image)):
            for a in range(count):
                weight = down[row, c, a]
                for i in range(cols):
                    image[c, row, i] += weight * parts[a, i]


@kernel()
def _cubic(t: float, weights: F64) -> None:
    """Write the Lagrange interpolation weights at t of the points −1, 0, 1 and 2."""
    a, b, c = t + 1.0, t - 1.0, t - 2.0
    weights[0], weights[1] = -t * b * c / 6.0, a * b * c / 2.0
    weights[2], weights[3] = -a * t * c / 2.0, a * t * b / 6.0


@kernel(allocates=True, error_model="numpy")
def transform_edges(
    out: Complex,
    jump: F64,
    sides: F64,
    across: F64,
    down: F64,
    scale: tuple[float, float, float],
    lowest: int,
    area: F64,
    begin: int,
    stop: int,
) -> None:
    """Write rows begin … stop of the transforms (kinds, n, m) of regions that few edges bound, each in closed form.

    Stokes' theorem gives Σ jump·i·(fx·ey − fy·ex)/(2π|f|²)·exp(−2πi f·middle)·sinc(f·e) over the edges e.

    jump   : (edges, kinds);  sides: (edges, 2) ex and ey;  area: (kinds,) the transforms at frequency 0
    across : (4, edges, m) cosine and sine of −2πfx·middle and of πfx·ex;  down: (4, edges, n) the same of y
    scale  : steps of m and of n, and the highest frequency, cycles/pitch;  lowest: the first row over its step
    """
    kinds, _, columns = out.shape
    step_x, step_y, most = scale
    real, imaginary = np.empty((kinds, columns)), np.empty((kinds, columns))
    cosine, sine = np.empty(columns), np.empty(columns)
    for row in range(begin, stop):
        fy = (lowest + row) * step_y
        last = 0 if abs(fy) > most else min(columns, int(math.sqrt(most * most - fy * fy) / step_x) + 1)
        real[:], imaginary[:] = 0.0, 0.0
        for e in range(len(jump)):
            (ex, ey), (u, v, c, s) = sides[e], down[:, e, row]
            cos_middle, sin_middle, cos_half, sin_half = across[0, e], across[1, e], across[2, e], across[3, e]
            for i in range(last):
                fx = i * step_x
                x = math.pi * (fx * ex + fy * ey)
                waves = sin_half[i] * c + cos_half[i] * s
                size = (1.0 - x * x / 6.0 if abs(x) < SMALL_PHASE else waves / x) * (fx * ey - fy * ex)
                cosine[i] = size * (cos_middle[i] * u - sin_middle[i] * v)
                sine[i] = size * (sin_middle[i] * u + cos_middle[i] * v)
            for k in range(kinds):
                times = jump[e, k]
                for i in range(last):
                    real[k, i] += times * cosine[i]
                    imaginary[k, i] += times * sine[i]
        for k in range(kinds):
            for i in range(columns):
                square = 2.0 * math.pi * ((i * step_x) ** 2 + fy * fy)
                out[k, row, i] = complex(-imaginary[k, i] / square, real[k, i] / square)
            if fy == 0.0:
                out[k, row, 0] = area[k]


@kernel()
def slope(whole: Complex, middle: int, step_x: float, step_y: float, area: float, begin: int, stop: int) -> None:
    """Convert Σ (ey + i·ex)·exp(−2πi f·y) over closed outlines to the transform of their interior, in place.

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


@kernel()
def repeat(
    out: Complex,
    whole: C128,
    samples: int,
    which: tuple[I64, I64],
    times: tuple[C128, C128],
    added: tuple[C128, C128],
    begin: int,
    stop: int,
) -> None:
    """Write rows of out (m, n): the periodic transform of real samples, times a factor along each axis.

    whole : (rows, samples // 2 + 1) the FFT of rows of ``samples`` real numbers
    which : column (n,) and row (m,) in the periodic transform;  times: (n,) and (m,) factors
    added : (p, m) and (p, n) factors of p outer products that are added
    """
    (columns, rows), (across, down), (of_rows, of_columns) = which, times, added
    for j in range(begin, stop):
        row = rows[j]
        back = (len(whole) - row) % len(whole)
        for i in range(out.shape[1]):
            column = columns[i]
            value = whole[row, column] if column < whole.shape[1] else whole[back, samples - column].conjugate()
            value *= across[i] * down[j]
            for p in range(len(of_rows)):
                value += of_rows[p, j] * of_columns[p, i]
            out[j, i] = value
