"""Polar tables of transfers looked up on a lattice of frequencies, and their products with a scene; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel
from camsim.rendering.angular import six_points
from camsim.rendering.fourier.blocks import Place

PIECE = 32  # frequencies whose transfers stay in a cache
BEFORE, AFTER = 2, 3  # points of a six-point look-up on either side of the first


class Polar(NamedTuple):
    """Transfers over |f| and half a circle of angles, on the other half their conjugates."""

    values: F64  # (|f|, angles, 2·transfers), BEFORE and AFTER more of the first two
    per_frequency: float  # points in a cycle/pitch
    active: I64  # (|f|,) how many transfers are something there: the first ones


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def on_lattice(place: Place, polar: Polar, more: F64, out: F64, first_row: int, stop_row: int) -> None:
    """Fill in rows of (count_j, sets, 2, terms, columns) from the block's first column on, where there is anything.

    more : (count_j, count_i, 2) what all are multiplied by
    """
    values = polar.values
    angles = values.shape[1] - BEFORE - AFTER
    last = polar.active.size - 1
    # Some columns at a time: a transfer's own row is written as a whole.
    along, round_about, total = np.empty(6), np.empty(6), np.empty((PIECE, values.shape[2]))
    for r in range(first_row, stop_row):
        ky = (place.first_j + r) / place.py
        for low in range(0, place.count_i, PIECE):
            width, most = min(PIECE, place.count_i - low), 0
            for c in range(width):
                own = total[c]
                own[:] = 0.0
                kx = (place.first_i + low + c) / place.px
                at = math.sqrt(kx * kx + ky * ky) * polar.per_frequency
                row = int(at)
                active = polar.active[row] if row <= last else 0
                if active == 0:
                    continue
                most, wide = max(most, active), 2 * active
                back = ky < 0.0 or (ky == 0.0 and kx < 0.0)
                angle = math.atan2(-ky, -kx) if back else math.atan2(ky, kx)
                turn = angle * (angles / math.pi)
                column = min(int(turn), angles - 1)
                six_points(at - row, along)
                six_points(turn - column, round_about)
                for a in range(6):
                    for b in range(6):
                        weight, there = along[a] * round_about[b], values[row + a, column + b]
                        for n in range(wide):
                            own[n] += weight * there[n]
                real, imaginary = more[r, low + c, 0], more[r, low + c, 1]
                sign = -1.0 if back else 1.0
                for n in range(active):
                    x, y = own[2 * n], sign * own[2 * n + 1]
                    own[2 * n], own[2 * n + 1] = x * real - y * imaginary, x * imaginary + y * real
            for n in range(most):
                into, first = out[r, n % out.shape[1]], place.column + low
                for c in range(width):
                    into[0, n // out.shape[1], first + c] = total[c, 2 * n]
                    into[1, n // out.shape[1], first + c] = total[c, 2 * n + 1]


class Sets(NamedTuple):
    """Which transfers make which sums: transfer (set, term) goes to sum (channel, term)."""

    weights: F64  # (tiles, spectra, sets) of each spectrum's transform
    channel: I64  # (sets,) −1: of no channel that is wanted
    cuts: F64  # (terms,) beyond which a term is nothing, cycles/pitch; falling


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_terms(total: F64, scenes: F64, fields: F64, sets: Sets, place: Place, first: int, stop: int) -> None:
    """Add a block to rows ``first`` … ``stop`` of ``total`` (tiles, channels, rows, 2, terms, columns).

    scenes : (tiles, spectra, count_j, 2, count_i) 4π²|k|² times transforms
    fields : (count_j, sets, 2, terms, columns) transfers with all that they are multiplied by, 0 beside the block
    """
    first_i, first_j, column, row, rows = place.first_i, place.first_j, place.column, place.row, place.rows
    px, py = place.px, place.py
    spectra, count_j, count_i = scenes.shape[1], scenes.shape[2], scenes.shape[4]
    nearest = max(first_i, 1 - first_i - count_i, 0) / px
    terms, columns = total.shape[4], total.shape[5]
    scale, own_r, own_i = np.empty(count_i), np.empty(terms * columns), np.empty(terms * columns)
    # One thread for each row of the photosites' grid: what the rows of a block add to it comes in one order.
    for target in range(first, stop):
        for r in range((target - row) % rows, count_j, rows):
            ky, active = (first_j + r) / py, 0
            lowest = math.hypot(nearest, ky)
            while active < terms and sets.cuts[active] > lowest:
                active += 1
            if active == 0:
                continue
            for c in range(count_i):
                kx = (first_i + c) / px
                square = kx * kx + ky * ky
                scale[c] = 1.0 / (4.0 * math.pi * math.pi * (square if square > 0.0 else 1.0))
            many = active * columns
            for t in range(len(total)):
                for k in range(sets.channel.size):
                    if sets.channel[k] < 0:
                        continue
                    own_r[:columns], own_i[:columns] = 0.0, 0.0
                    for s in range(spectra):
                        weight = sets.weights[t, s, k]
                        if weight != 0.0:
                            real, imaginary = scenes[t, s, r, 0], scenes[t, s, r, 1]
                            for c in range(count_i):
                                own_r[column + c] += weight * scale[c] * real[c]
                                own_i[column + c] += weight * scale[c] * imaginary[c]
                    # All terms in one row of numbers: rows of one term are short.
                    for q in range(1, active):
                        for c in range(columns):
                            own_r[q * columns + c], own_i[q * columns + c] = own_r[c], own_i[c]
                    into_r = total[t, sets.channel[k], target, 0].reshape(-1)[:many]
                    into_i = total[t, sets.channel[k], target, 1].reshape(-1)[:many]
                    x, y = fields[r, k, 0].reshape(-1)[:many], fields[r, k, 1].reshape(-1)[:many]
                    for m in range(many):
                        into_r[m] += own_r[m] * x[m] - own_i[m] * y[m]
                        into_i[m] += own_r[m] * y[m] + own_i[m] * x[m]


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_weighed(terms: F64, shares: F64, down: F64, across: F64, out: F64, first: int, stop: int) -> None:
    """Add terms' images (terms, rows, cols) with weights to rows ``first`` … ``stop`` of an image.

    shares : (terms, y, x) at places;  down: (rows, y) and across: (x, cols) what places weigh at photosites
    """
    cols = terms.shape[2]
    weight = np.empty(cols)
    for r in range(first, stop):
        own = out[r]
        for q in range(len(terms)):
            weight[:] = 0.0
            for b in range(shares.shape[2]):
                share, along = 0.0, across[b]
                for a in range(shares.shape[1]):
                    share += shares[q, a, b] * down[r, a]
                for c in range(cols):
                    weight[c] += share * along[c]
            term = terms[q, r]
            for c in range(cols):
                own[c] += weight[c] * term[c]


@kernel(allocates=True, error_model="numpy")
def fold(own: F64, periods: tuple[int, int], at: tuple[int, int], out: F64, first: int, stop: int) -> None:
    """Fold terms' frequencies (rows, 2, terms, columns) onto those of every second photosite along x and y.

    periods : along x and y, even, of all photosites;  at: column and row of the first that is asked for
    out     : (terms, rows, columns, 2) on half of the periods

    What lies half a period of frequencies farther turns once more from one such photosite to the next: by nothing.
    """
    (px, py), (left, top) = periods, at
    rows, columns = own.shape[0], own.shape[3]
    half = px // 2
    direct, mirrored = min(columns, half // 2 + 1), max(0, min(columns, half) - (half + 1) // 2)
    across, along = np.empty((2, columns)), np.empty((2, columns))
    for i in range(columns):
        turn = 2.0 * math.pi * left * i / px
        across[0, i], across[1, i] = 0.25 * math.cos(turn), 0.25 * math.sin(turn)
    for r in range(rows):
        j = r if 2 * r < rows else r - rows
        c, s = math.cos(2.0 * math.pi * top * j / py), math.sin(2.0 * math.pi * top * j / py)
        for i in range(columns):
            along[0, i], along[1, i] = c * across[0, i] - s * across[1, i], c * across[1, i] + s * across[0, i]
        for q in range(first, stop):
            real, imaginary = own[r, 0, q], own[r, 1, q]
            into = out[q, j % out.shape[1]]
            for i in range(direct):
                into[i, 0] += along[0, i] * real[i] - along[1, i] * imaginary[i]
                into[i, 1] += along[0, i] * imaginary[i] + along[1, i] * real[i]
            if columns > half:
                into[0, 0] += along[0, half] * real[half] - along[1, half] * imaginary[half]
                into[0, 1] += along[0, half] * imaginary[half] + along[1, half] * real[half]
            into = out[q, -j % out.shape[1]]
            for k in range(mirrored):
                i = (half + 1) // 2 + k
                into[half - i, 0] += along[0, i] * real[i] - along[1, i] * imaginary[i]
                into[half - i, 1] -= along[0, i] * imaginary[i] + along[1, i] * real[i]
