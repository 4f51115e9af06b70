"""Transforms of a lattice's samples times the transfer of a round lens, column by column of the band; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64
from camsim.kernels import kernel


class Columns(NamedTuple):
    """Neighbouring columns kx = i/px, from ``first_i`` on, of all frequencies (i/px, j/py) up to ``cut``."""

    first_i: int
    count_x: int  # samples of a period, along either axis
    px: float
    py: float
    cut: float


class Cells(NamedTuple):
    """Round transfers as polynomials of |k| on cells, so many of them in a cycle/pitch."""

    coefficients: F64  # (cells, modes, 8)
    per_frequency: float


class Axes(NamedTuple):
    """What splines, OLPF, photosite and the lattice's place multiply by."""

    across: C128  # (columns,)
    down: C128  # (2·most + 1,) of j = −most … most
    both: C128  # (columns, 2·most + 1), or (0, 0) where there is no more to it


@kernel(error_model="numpy", fastmath={"contract"})
def _curve(coefficients: F64, place: F64, low: int, stop: int, cell: int, out: F64) -> None:
    """Set out[low:stop] to one cell's polynomial at places, which lie in it."""
    p0, p1, p2, p3 = coefficients[0], coefficients[1], coefficients[2], coefficients[3]
    p4, p5, p6, p7 = coefficients[4], coefficients[5], coefficients[6], coefficients[7]
    for q in range(low, stop):
        u = place[q] - cell
        u2 = u * u
        out[q] = p0 + u * p1 + u2 * (p2 + u * p3) + u2 * u2 * (p4 + u * p5 + u2 * (p6 + u * p7))


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def lit_columns(transforms: C128, cells: Cells, columns: Columns, axes: Axes) -> C128:
    """Return (columns, 2·most + 1): Σ over modes of transform × transfer; beyond the cut 0.

    transforms : (modes, count_x//2 + 1, count_y) of real lattices; they repeat for ever
    """
    first_i, count_x, px, py, cut = columns
    coefficients, per_frequency = cells
    count, most = len(axes.across), (len(axes.down) - 1) // 2
    modes, _, count_y = transforms.shape
    out = np.zeros((count, 2 * most + 1), np.complex128)
    place, lens = np.empty(most + 1), np.empty(2 * most + 1)
    own_r, own_i = np.empty(count_y), np.empty(count_y)
    sum_r, sum_i = np.empty(2 * most + 1), np.empty(2 * most + 1)
    for c in range(count):
        kx = (first_i + c) / px
        if kx > cut:
            continue
        top = min(most, int(math.sqrt(cut * cut - kx * kx) * py))
        first, stop = most - top, most + top + 1
        for j in range(top + 1):
            ky = j / py
            place[j] = math.sqrt(kx * kx + ky * ky) * per_frequency
        sum_r[first:stop] = 0.0
        sum_i[first:stop] = 0.0
        row = (first_i + c) % count_x
        for s in range(modes):
            # A real lattice: its transform at −k is the conjugate.
            if 2 * row <= count_x:
                for j in range(count_y):
                    value = transforms[s, row, j]
                    own_r[j], own_i[j] = value.real, value.imag
            else:
                for j in range(count_y):
                    value = transforms[s, count_x - row, (count_y - j) % count_y]
                    own_r[j], own_i[j] = value.real, -value.imag
            # Frequencies of one cell follow one another: their polynomial is read once.
            low = 0
            while low <= top:
                cell = min(int(place[low]), len(coefficients) - 1)
                high = low + 1
                while high <= top and place[high] < cell + 1:
                    high += 1
                _curve(coefficients[cell, s], place, low, high, cell, lens[most:])
                low = high
            for j in range(1, top + 1):
                lens[most - j] = lens[most + j]
            q = first
            while q < stop:
                begin = (q - most) % count_y
                end = min(stop, q + count_y - begin)
                for t in range(q, end):
                    sum_r[t] += lens[t] * own_r[begin + t - q]
                    sum_i[t] += lens[t] * own_i[begin + t - q]
                q = end
        for q in range(first, stop):
            out[c, q] = complex(sum_r[q], sum_i[q]) * axes.down[q] * axes.across[c]
        if len(axes.both):
            for q in range(first, stop):
                out[c, q] *= axes.both[c, q]
    return out
