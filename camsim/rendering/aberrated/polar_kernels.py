"""Zernike coefficients, patterns and their transfers over radius and angle; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel
from camsim.optics.bessel import FAR, bessel_j0_j1
from camsim.quintics import quintic_cells
from camsim.rendering.angular import six_points, turns

UP_TO = FAR  # from where on Hankel's series are taken
PER_UNIT = 64.0  # cells of J0 and J1 up to UP_TO: 7e-14
TERMS = 6  # of each of Hankel's series: 1e-14 from there on
BELOW = 10  # orders more, and 9·∛ of the last one, from which Miller's recurrence comes down: 1e-16


class Bessels(NamedTuple):
    """J0 and J1: quintics (2, cells, 6) up to UP_TO, beyond coefficients (2, 2, TERMS) of Hankel's P and Q."""

    near: F64
    far: F64


def _hankel() -> F64:
    """Return coefficients in 1/x² of P, and in 1/x² of x·Q (DLMF 10.17.3)."""
    out = np.zeros((2, 2, TERMS))
    for order in range(2):
        a = 1.0
        for k in range(2 * TERMS):
            out[order, k % 2, k // 2] = a if k % 4 < 2 else -a
            a *= (4 * order**2 - (2 * k + 1) ** 2) / (8 * (k + 1))
    return out


_PLACES = np.abs(np.arange(-2.0, UP_TO * PER_UNIT + 4.0)) / PER_UNIT
_SIGN = np.where(np.arange(_PLACES.size) < 2, -1.0, 1.0)  # J1 is odd
BESSELS = Bessels(quintic_cells(np.stack([bessel_j0_j1(_PLACES)[0], _SIGN * bessel_j0_j1(_PLACES)[1]])), _hankel())


@kernel(forceinline=True)
def _first_two(x: float, bessels: Bessels) -> tuple[float, float]:
    """Return J0 and J1."""
    if x < UP_TO:
        cell = int(x * PER_UNIT)
        t = x * PER_UNIT - cell
        p, q = bessels.near[0, cell], bessels.near[1, cell]
        j0 = p[0] + t * (p[1] + t * (p[2] + t * (p[3] + t * (p[4] + t * p[5]))))
        return j0, q[0] + t * (q[1] + t * (q[2] + t * (q[3] + t * (q[4] + t * q[5]))))
    cos, sin, size = math.cos(x), math.sin(x), 1.0 / math.sqrt(math.pi * x)
    square = 1.0 / (x * x)
    p0, q0, p1, q1 = 0.0, 0.0, 0.0, 0.0
    for k in range(TERMS - 1, -1, -1):
        p0 = p0 * square + bessels.far[0, 0, k]
        q0 = q0 * square + bessels.far[0, 1, k]
        p1 = p1 * square + bessels.far[1, 0, k]
        q1 = q1 * square + bessels.far[1, 1, k]
    q0, q1 = q0 / x, q1 / x
    return size * (p0 * (sin + cos) - q0 * (sin - cos)), size * (p1 * (sin - cos) + q1 * (sin + cos))


@kernel(forceinline=True)
def _bessel_row(x: float, bessels: Bessels, out: F64) -> None:
    """Write J0, J1 … at x > 0."""
    last = out.size - 1
    if x >= last:
        # Upwards errors grow only where the order is beyond x.
        out[0], above = _first_two(x, bessels)
        if last >= 1:
            out[1] = above
        twice = 2.0 / x
        for n in range(1, last):
            out[n + 1] = n * twice * out[n] - out[n - 1]
        return
    n = last + BELOW + int(9.0 * float(last) ** (1.0 / 3.0))
    value, above, total, twice = 1e-300, 0.0, 0.0, 2.0 / x
    n += n % 2
    while n >= 0:
        if n <= last:
            out[n] = value
        if n % 2 == 0:
            total += value if n == 0 else 2.0 * value  # J0 + 2·J2 + 2·J4 + … = 1
        value, above = n * twice * value - above, value
        n -= 1
        if abs(value) > 1e200:
            value, above, total = value * 1e-200, above * 1e-200, total * 1e-200
            for k in range(n + 1, last + 1):
                out[k] *= 1e-200
    for k in range(last + 1):
        out[k] /= total


@kernel(forceinline=True)
def _next_radial(rho: float, n: int, m: int, own: F64, before: F64, last: F64) -> None:
    """Write R_n^m = ρ·(R_{n−1}^|m−1| + R_{n−1}^{m+1}) − R_{n−2}^m (Shakibaei & Paremesran, Opt. Lett. 38, 2013)."""
    if n == 0:
        own[m] = 1.0
    else:
        own[m] = rho * (before[abs(m - 1)] + before[m + 1]) - (last[m] if m <= n - 2 else 0.0)


@kernel(allocates=True)
def add_terms(rho: F64, weights: F64, around: C128, terms: C128) -> None:
    """Add to Zernike coefficients (n, 2·degree + 1) what harmonics (radii, angles) on a disc have of them.

    weights : of a rule in ρ² on 0 … 1
    """
    degree = len(terms) - 1
    rows = np.zeros((3, degree + 2))
    for k in range(rho.size):
        rows[:] = 0.0
        for n in range(degree + 1):
            own, before, last = rows[n % 3], rows[(n + 2) % 3], rows[(n + 1) % 3]
            for m in range(n % 2, n + 1, 2):
                _next_radial(rho[k], n, m, own, before, last)
                share = (n + 1.0) * weights[k] * own[m]
                terms[n, degree + m] += share * around[k, m]
                if m:
                    terms[n, degree - m] += share * around[k, around.shape[1] - m]
            if n + 1 <= degree:
                own[n + 1] = 0.0


@kernel(allocates=True)
def add_series(rho: F64, angle_rad: F64, terms: C128, out: C128) -> None:
    """Add to values (points,) a series' on a disc; terms: (n, 2·most + 1)."""
    degree, most = len(terms) - 1, terms.shape[1] // 2
    rows, turns = np.zeros((3, degree + 2)), np.empty(most + 1, np.complex128)
    for k in range(rho.size):
        rows[:] = 0.0
        for m in range(most + 1):
            turns[m] = math.cos(m * angle_rad[k]) + 1j * math.sin(m * angle_rad[k])
        for n in range(degree + 1):
            own, before, last = rows[n % 3], rows[(n + 2) % 3], rows[(n + 1) % 3]
            for m in range(n % 2, n + 1, 2):
                _next_radial(rho[k], n, m, own, before, last)
                if m <= most:
                    out[k] += own[m] * terms[n, most + m] * turns[m]
                if 0 < m <= most:
                    out[k] += own[m] * terms[n, most - m] * np.conj(turns[m])
            if n + 1 <= degree:
                own[n + 1] = 0.0


class Waves(NamedTuple):
    """Phase factors at several wavelengths.

    turning : (j,) z of a radius of 1;  around: γ (j, discs, n, 2, angles) over half a circle
    obstruction : 0 … 1;  weights: (sets, j), of a pattern in pitches
    """

    turning: F64
    around: F64
    obstruction: float
    weights: F64


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_patterns(radius: F64, waves: Waves, bessels: Bessels, out: F64, first: int, stop: int) -> None:
    """Add differences from the round pattern at some radii: (sets, radii, 2, angles).

    What is even and what is odd under half a turn: an amplitude's parts of even and of odd degree are.
    """
    discs, count, _, angles = waves.around.shape[1:]
    row = np.empty(count + 1)
    real, imaginary = np.empty((2, angles)), np.empty((2, angles))
    for i in range(first, stop):
        for j in range(waves.turning.size):
            real[:], imaginary[:] = 0.0, 0.0
            plain = 0.0
            for disc in range(discs):
                z = waves.turning[j] * radius[i] * (1.0 if disc == 0 else waves.obstruction)
                size = 1.0 if disc == 0 else -waves.obstruction * waves.obstruction
                _bessel_row(z, bessels, row)
                plain += size * row[1] / z
                for n in range(count):
                    share, part = size * row[n + 1] / z, n % 2
                    re, im = waves.around[j, disc, n, 0], waves.around[j, disc, n, 1]
                    for a in range(angles):
                        real[part, a] += share * re[a]
                        imaginary[part, a] += share * im[a]
            for s in range(len(out)):
                weight = waves.weights[s, j]
                if weight == 0.0:
                    continue
                even, odd = out[s, i, 0], out[s, i, 1]
                for a in range(angles):
                    square = real[0, a] * real[0, a] + imaginary[0, a] * imaginary[0, a]
                    square += real[1, a] * real[1, a] + imaginary[1, a] * imaginary[1, a]
                    even[a] += weight * (square - plain * plain)
                    odd[a] += weight * 2.0 * (real[0, a] * real[1, a] + imaginary[0, a] * imaginary[1, a])


class Profiles(NamedTuple):
    """Functions of the radius: values (columns · sets) at even steps of the angle whose cosine runs over 0 … outer.

    values : (cells, columns · sets), three more at either end;  per_rad: cells
    order  : (columns,) harmonics;  sets: patterns side by side in each column
    """

    values: F64
    per_rad: float
    outer: float
    order: I64
    sets: int


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def project(profiles: Profiles, step_x: float, step_y: float, out: F64, first: int, stop: int) -> None:
    """Write sums over y of profile × cos mφ at some of x = 0, step_x …: (x, columns · sets)."""
    sets, outer = profiles.sets, profiles.outer
    cos, sin, weight = np.empty(profiles.order.max() + 1), np.empty(profiles.order.max() + 1), np.empty(6)
    sums = np.empty(out.shape[1])
    for i in range(first, stop):
        out[i] = 0.0
        x = i * step_x
        for n in range(int(math.sqrt(max(outer * outer - x * x, 0.0)) / step_y) + 1):
            y = n * step_y
            u = math.acos(min(2.0 * math.sqrt(x * x + y * y) / outer - 1.0, 1.0)) * profiles.per_rad + 0.5
            cell = int(u)
            six_points(u - cell, weight)
            sums[:] = 0.0
            for k in range(6):
                own = profiles.values[cell + k]
                for q in range(sums.size):
                    sums[q] += weight[k] * own[q]
            turns(x, y, cos, sin)
            share = step_y if n == 0 else 2.0 * step_y
            for c in range(profiles.order.size):
                turn = share * cos[profiles.order[c]]
                for q in range(c * sets, (c + 1) * sets):
                    out[i, q] += turn * sums[q]
