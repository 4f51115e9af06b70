"""Ringing on the real axis, tabulated over the distance and summed over wavelengths and oscillations.

A node on a short edge needs one number that depends on h, s and the direction of the edge: Re Σ_j w_j·G_j(r, θ), a
short real Fourier series in θ whose coefficients are functions of r alone. They are waves no shorter than the shortest
oscillation, so that eight evenly spaced values suffice for interpolation. As with the field near an edge, the cost does
not depend on the number of wavelengths. The ringing of ends is integrated off the real axis, where waves grow and
decay; it is not tabulated.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import C128, F64
from camsim.core.kernels import kernel, shared
from camsim.numerics.quadrature import EIGHT_POINTS
from camsim.rendering.boundary.potential import eight_points
from camsim.rendering.boundary.rings import PIECE_W, PIECE_X, left_of_waves, nodes_on

MARGIN = 4  # rows before the nearest distance: three of a look-up, and one for rounding
BEYOND = 5  # rows past the farthest cell: four of a look-up, likewise
WORTH_A_THREAD = 64  # rows


class RingTable(NamedTuple):
    """Ringing of every weight set times r⁻¹; lengths in pitches.

    values  : (pairs, channels, rows, harmonics, 4): coefficients of cos mφ and sin mφ, φ = turns·θ, first radial, then
              tangential, at ``nearest`` + (row − MARGIN)/``per_pitch``
    until   : largest distance of pieces that are looked up; 0: none are
    shortest : shortest length of an oscillation
    """

    values: F64
    nearest: float
    per_pitch: float
    until: float
    shortest: float


def ring_step(shortest: float, tolerance: float) -> float:
    """Return the table's step, pitches, for a look-up as accurate as quadrature on a piece (``left_of_waves``)."""
    angle: float = (left_of_waves(tolerance) / EIGHT_POINTS) ** 0.125
    return shortest * angle / (2.0 * math.pi)


def harmonics_counted(extent: float, shortest: float, *, turns: int, tolerance: float) -> int:
    """Return the approximate number of harmonics in the table for a footprint of size ``extent``.

    Bessel functions of order n are at most (x/2)ⁿ/n!, x the phase of the shortest oscillation across the footprint.
    """
    half, count = max(math.pi * extent / shortest, 1e-9), 1
    least = math.log(left_of_waves(tolerance))
    while turns * count * math.log(half) - math.lgamma(turns * count + 1) > least or turns * count < half:
        count += 1
    return count


def ring_table(
    amplitude: C128, lengths: F64, weights: F64, *, nearest: float, rows: int, tolerance: float
) -> RingTable:
    """Tabulate ringing.

    amplitude, lengths : of ``ring_amplitudes``, valid from ``nearest`` on, and ``oscillation_lengths``
    weights : (pairs, channels, j) of wavelengths
    rows    : of the table; 0 for none
    """
    pairs, channels, waves = weights.shape
    shortest = float(lengths.min(initial=math.inf))
    if not rows:
        return RingTable(np.empty((pairs, channels, 0, 1, 4)), nearest, 0.0, 0.0, shortest)
    step = ring_step(shortest, tolerance)
    series = _series(amplitude, left_of_waves(tolerance))
    columns = series.shape[2]
    flat = np.tile(weights.reshape(-1, waves), len(lengths) // waves)
    values = np.zeros((pairs * channels, rows, columns))
    parts = np.ascontiguousarray(series.real), np.ascontiguousarray(series.imag)
    work = functools.partial(_fill, (nearest, step), lengths, parts, np.ascontiguousarray(flat.T), values)
    shared(rows, work, least=WORTH_A_THREAD)
    return RingTable(
        values=values.reshape(pairs, channels, rows, columns // 4, 4),
        nearest=nearest,
        per_pitch=1.0 / step,
        until=nearest + (rows - MARGIN - BEYOND) * step,
        shortest=shortest,
    )


def _series(amplitude: C128, left: float) -> C128:
    """Return amplitudes as a real Fourier series (oscillations · j, powers, harmonics · 4), truncated.

    left : largest sum of the harmonics left out, over the largest amplitude

    Re (a·e^{imφ} + b·e^{−imφ})·e^{ikr} is cos mφ·Re (a + b)e^{ikr} + sin mφ·Re i(a − b)e^{ikr}.
    """
    most = amplitude.shape[2] // 2
    inverse = np.linspace(0.0, 1.0, amplitude.shape[3])
    sizes = np.abs(amplitude @ np.vander(inverse, increasing=True).T).max(axis=(0, 1, 3))
    one = sizes[most:] + sizes[most::-1]
    beyond = np.append(np.cumsum(one[::-1])[::-1], 0.0)
    kept = max(1, int(np.argmax(beyond <= left * sizes.max())))
    after, before = amplitude[:, :, most : most + kept], amplitude[:, :, most::-1][:, :, :kept]
    series = np.stack([after + before, 1j * (after - before)], axis=2)  # (oscillations · j, 2, 2, harmonics, powers)
    series[:, :, 0, 0] *= 0.5
    return np.moveaxis(series, (4, 3), (1, 2)).reshape(len(series), amplitude.shape[3], 4 * kept)


@kernel(allocates=True, fastmath={"contract"})
def _fill(
    grid: tuple[float, float],
    lengths: F64,
    series: tuple[F64, F64],
    weights: F64,
    values: F64,
    begin: int,
    end: int,
) -> None:
    """Fill rows begin … end of the table.

    grid: ``nearest`` and step;  series: real and imaginary parts;  weights: (oscillations · j, sets)
    """
    (nearest, step), (real, imaginary) = grid, series
    a, b = np.empty(real.shape[2]), np.empty(real.shape[2])
    for row in range(begin, end):
        r = nearest + (row - MARGIN) * step
        u, falls = nearest / r, 1.0 / (r * r * r * r)
        for j in range(lengths.size):
            a[:] = 0.0
            b[:] = 0.0
            for q in range(real.shape[1] - 1, -1, -1):
                for c in range(a.size):
                    a[c] = a[c] * u + real[j, q, c]
                    b[c] = b[c] * u + imaginary[j, q, c]
            phase = 2.0 * math.pi * r / lengths[j]
            cos, sin = falls * math.cos(phase), falls * math.sin(phase)
            for c in range(a.size):
                a[c] = a[c] * cos - b[c] * sin
            for k in range(len(values)):
                weight, one = weights[j, k], values[k, row]
                for c in range(a.size):
                    one[c] += weight * a[c]


@kernel(fastmath={"contract"})
def tabled_part(
    h: float, ends: tuple[float, float], way: complex, values: F64, table: RingTable, turns: int, phases: F64
) -> float:
    """Return the same as ``ring_part`` from the table, for a piece that lies within its ``until``.

    values : of one weight set;  phases: of ``piece_phases``
    """
    total, (s1, s2) = 0.0, ends
    middle, half = 0.5 * (s1 + s2), 0.5 * (s2 - s1)
    count = nodes_on(half, table.shortest, phases)
    for i in range(count):
        along = middle + half * PIECE_X[count, i]
        r = math.sqrt(h * h + along * along)
        inverse = 1.0 / r
        x, y = inverse * (way.real * along + way.imag * h), inverse * (way.imag * along - way.real * h)
        x, y = x * x - y * y, 2.0 * x * y
        if turns == 4:
            x, y = x * x - y * y, 2.0 * x * y
        at = (r - table.nearest) * table.per_pitch + (MARGIN - 3)
        cell = np.uintp(at)
        w0, w1, w2, w3, w4, w5, w6, w7 = eight_points(at - cell)
        cos, sin, rise = 1.0, 0.0, 0.0
        for m in range(values.shape[1]):
            a0 = a1 = a2 = a3 = 0.0
            k = cell
            for w in (w0, w1, w2, w3, w4, w5, w6, w7):
                row = values[k, m]
                a0, a1, a2, a3 = a0 + w * row[0], a1 + w * row[1], a2 + w * row[2], a3 + w * row[3]
                k += np.uintp(1)
            rise += cos * (h * a0 - along * a2) + sin * (h * a1 - along * a3)
            cos, sin = cos * x - sin * y, sin * x + cos * y
        total += PIECE_W[count, i] * rise
    return total * half
