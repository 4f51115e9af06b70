"""Sums of waves from any places, on even lattices: light is spread over a lattice twice as fine, and transformed (FFT).

What a place is spread by is exp(β(√(1 − z²) − 1)) over as many cells as digits are asked for; its own transform, by a
Gauss rule, is divided out again. With 16 cells that leaves 1e-14 of the sum of all light's size.
"""

from __future__ import annotations

import functools
import math

import numba as nb
import numpy as np
from scipy import fft, special

BETA = 2.3  # per cell


def of_rows(places, light, first, step, count, digits=16.0):
    """Σ_q light[k, q]·exp(i·places[k, q]·(first + step·m)) as (k, m), m = 0 … count − 1."""
    middle = count // 2
    offset = first + step * middle
    if abs(offset) > 1e-15 * abs(first):
        light = light * np.exp(1j * offset * places)
    fine, powers, one = _rule(count, digits)
    spread = _spread_rows(places, -step / (2.0 * np.pi), light, fine, powers)
    found = fft.fft(spread, axis=1, overwrite_x=True)
    return np.concatenate([found[:, fine - middle :], found[:, : count - middle]], axis=1) / one


def of_columns(places, light, first, step, count, digits=16.0):
    """Σ_k exp(i·places[k]·(first + step·n))·light[k, m] as (n, m), n = 0 … count − 1."""
    middle = count // 2
    light = light * np.exp(1j * (first + step * middle) * places)[:, None]
    fine, powers, one = _rule(count, digits)
    spread = _spread_columns(places * (-step / (2.0 * np.pi)), light, fine, powers)
    found = fft.fft(spread, axis=0, overwrite_x=True)
    return np.concatenate([found[fine - middle :], found[: count - middle]]) / one[:, None]


def over_the_plane(places, light, step, count, digits=16.0):
    """Σ light·exp(−2πi k·x), light real, at k = step·(0 … count/2, fftfreq): (ky, kx); ``count`` is even."""
    fine, powers, one = _rule(count, digits)
    spread = _spread_plane(places * step, np.ascontiguousarray(light), fine, powers)
    half = count // 2
    found = fft.fft(fft.rfft(spread, axis=0)[: half + 1], axis=1, overwrite_x=True)
    found = np.concatenate([found[:, :half], found[:, fine - half :]], axis=1)
    return found / fft.ifftshift(one) / np.append(one[half:], one[0])[:, None]


@functools.lru_cache(64)
def _rule(count, digits):
    """Cells of the finer lattice, powers, and the spreading function's transform at m = −count//2 … of ``count``."""
    powers = _powers(digits)
    width = powers.shape[1]
    fine = fft.next_fast_len(2 * max(count, width))
    z, w = special.roots_legendre(64)
    phases = np.pi * width / fine * np.outer(np.arange(count) - count // 2, z)
    return fine, powers, 0.5 * width * np.cos(phases) @ (w * _spreading(z, width))


def _spreading(z, width):
    return np.exp(BETA * width * (np.sqrt(np.maximum(1.0 - z * z, 0.0)) - 1.0))


@functools.cache
def _powers(digits):
    """The spreading function on each of its cells as a polynomial of −1 … 1, (power from the highest, cell)."""
    width = min(max(math.ceil(digits + 2.0), 6), 16)
    width += width % 2
    degree = width - 2
    t, cells = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1)), np.arange(width)
    values = _spreading((cells - 0.5 * width + 0.5 * (1.0 + t[:, None])) * 2.0 / width, width)
    chebyshev = np.polynomial.chebyshev.chebfit(t, values, degree)
    return np.stack([np.polynomial.chebyshev.cheb2poly(chebyshev[:, j])[::-1] for j in cells], axis=1)


@nb.njit(cache=True, fastmath=True)
def _weights(place, cells, powers, weights):
    """What cells get of a place in periods, and which is the first, half a width on."""
    at = (place - math.floor(place)) * cells
    first = math.ceil(at)  # half a width after the first, which is even
    t = 2.0 * (first - at) - 1.0
    weights[:] = powers[0]
    for p in range(1, len(powers)):
        one = powers[p]
        for j in range(weights.size):
            weights[j] = weights[j] * t + one[j]
    return first


@nb.njit(cache=True, fastmath=True)
def _spread_rows(places, periods, light, cells, powers):
    """(k, cells) with a margin of half a width before."""
    width = powers.shape[1]
    half, spread = width // 2, np.empty((len(places), cells), np.complex128)
    weights, real, imaginary = np.empty(width), np.empty(cells + width), np.empty(cells + width)
    for k in range(len(places)):
        real[:] = 0.0
        imaginary[:] = 0.0
        for q in range(places.shape[1]):
            first = _weights(periods * places[k, q], cells, powers, weights)
            re, im = real[first : first + width], imaginary[first : first + width]
            for j in range(width):
                re[j] += weights[j] * light[k, q].real
                im[j] += weights[j] * light[k, q].imag
        for row in (real, imaginary):
            row[half : 2 * half] += row[cells + half :]
            row[cells : cells + half] += row[:half]
        for c in range(cells):
            spread[k, c] = complex(real[c + half], imaginary[c + half])
    return spread


@nb.njit(cache=True, fastmath=True)
def _spread_columns(places, light, cells, powers):
    width = powers.shape[1]
    spread, weights = np.zeros((cells, light.shape[1]), np.complex128), np.empty(width)
    for k in range(len(places)):
        first = _weights(places[k], cells, powers, weights)
        for j in range(width):
            row = spread[(first + j - width // 2) % cells]
            for m in range(light.shape[1]):
                row[m] += weights[j] * light[k, m]
    return spread


@nb.njit(cache=True, fastmath=True)
def _spread_plane(places, light, cells, powers):
    width = powers.shape[1]
    wide, half = np.zeros((cells, cells + width)), width // 2
    across, down = np.empty(width), np.empty(width)
    for q in range(len(light)):
        col = _weights(places[q, 0], cells, powers, across)
        row = _weights(places[q, 1], cells, powers, down)
        for i in range(width):
            one, line = down[i] * light[q], wide[(row + i - half) % cells, col : col + width]
            for j in range(width):
                line[j] += one * across[j]
    spread = wide[:, half : half + cells].copy()
    spread[:, cells - half :] += wide[:, :half]
    spread[:, :half] += wide[:, half + cells :]
    return spread
