"""Sums over overlaps of a pupil with itself, and sums of these over wavelengths; arrays only."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64
from camsim.kernels import kernel
from camsim.quadrature import gauss_legendre


def overlap_nodes(count: int, shift: F64) -> tuple[F64, F64, F64]:
    """Return places u, v (shifts, n) along and across the shift, and weights, of rules over overlaps of two discs."""
    t, v = gauss_legendre(count)
    turn = 0.5 * np.pi * (1.0 + t)  # spaced as a cosine across: what is left of a line at either end are roots
    widest = np.sqrt(np.maximum(1.0 - np.square(shift), 0.0))[:, None]
    across, slope = -widest * np.cos(turn), 0.5 * np.pi * widest * np.sin(turn) * v
    half = np.maximum(np.sqrt(np.maximum(1.0 - np.square(across), 0.0)) - shift[:, None], 0.0)
    along = half[..., None] * t
    weights = (slope * half)[..., None] * v / np.pi
    return along.reshape(shift.size, -1), np.repeat(across, count, axis=1), weights.reshape(shift.size, -1)


@kernel(error_model="numpy", fastmath={"contract"})
def add_overlaps(step: F64, share: F64, waves: F64, samples: F64, first: int, stop: int) -> None:
    """Add Σ share·exp(2πi·step·waves), waves evenly spaced, at some shifts: (shifts, angles, colours, 2).

    step : (shifts, angles, nodes);  share: (shifts, nodes)
    """
    gap = waves[1] - waves[0] if waves.size > 1 else 0.0
    for s in range(first, stop):
        for a in range(step.shape[1]):
            total = samples[s, a]
            for n in range(step.shape[2]):
                phase, turn = 2.0 * math.pi * step[s, a, n] * waves[0], 2.0 * math.pi * step[s, a, n] * gap
                real, imaginary = share[s, n] * math.cos(phase), share[s, n] * math.sin(phase)
                cos, sin = math.cos(turn), math.sin(turn)
                for k in range(waves.size):
                    total[k, 0] += real
                    total[k, 1] += imaginary
                    real, imaginary = real * cos - imaginary * sin, real * sin + imaginary * cos


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def fuse(frequency: F64, blur: F64, weights: F64, own: F64, columns: F64, table: F64, first: int, stop: int) -> None:
    """Add up wavelengths at some frequencies: (frequencies, sets, columns).

    own     : (wavelengths, colours) what each takes of the colours that were followed
    columns : (colours · shifts, columns), shifts at Chebyshev nodes of 2·√(1 − ν) − 1
    """
    sets, colours = len(weights), own.shape[1]
    shifts = len(columns) // colours
    place, row = np.empty(shifts), np.empty(shifts)
    taken = np.empty((sets, colours, shifts))
    for k in range(shifts):
        # As ``quadrature.chebyshev`` has them, and what each weighs in the barycentric formula.
        turn = math.pi * (shifts - k - 0.5) / shifts
        place[k] = math.cos(turn)
    for f in range(first, stop):
        taken[:] = 0.0
        for j in range(blur.size):
            nu = frequency[f] * blur[j]
            if nu >= 1.0:
                continue
            x, total, hit = 2.0 * math.sqrt(1.0 - nu) - 1.0, 0.0, -1
            for k in range(shifts):
                gap = x - place[k]
                if abs(gap) < 1e-14:
                    hit = k
                    gap = 1.0
                row[k] = (1.0 - 2.0 * (k % 2)) * math.sin(math.pi * (k + 0.5) / shifts) / gap
                total += row[k]
            if hit >= 0:
                row[:] = 0.0
                row[hit], total = 1.0, 1.0
            for s in range(sets):
                for c in range(colours):
                    weight = weights[s, j] * own[j, c] / total
                    for k in range(shifts):
                        taken[s, c, k] += weight * row[k]
        for s in range(sets):
            for c in range(colours):
                for k in range(shifts):
                    weight, values = taken[s, c, k], columns[c * shifts + k]
                    for q in range(values.size):
                        table[f, s, q] += weight * values[q]
