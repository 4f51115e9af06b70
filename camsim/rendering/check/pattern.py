"""A round lens as the check knows it: its encircled energy in a table, and what is smooth of it far out.

Both come from the lens itself: E(r) from its formula, the powers of 1/r from the slopes of its transfer at 0, and how
far out what oscillates is heard from the table, averaged over the footprint as it is. No number of the engines' is
used.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.kernels import kernel, shared
from camsim.optics.protocols import RoundLens
from camsim.optics.radial import RadialOtf
from camsim.products import product
from camsim.quadrature import chebyshev, interpolation
from camsim.quintics import quintic_cells
from camsim.rendering.envelope import Envelope

CELLS_PER_BLUR = 64  # with which quintics leave CELLS_LEAVE of the light: 32 left 3e-10
CELLS_LEAVE = 5e-12
FEWER, SURELY = (8, 16, 32), 4.0  # where these leave so many times less than is allowed
PANEL_BLURS, PANEL_POINTS, EVEN_POINTS = 4, 40, 64  # E/ρ² from so many points in four blurs, and in eight about 0
SLOPE_DEGREE, SLOPE_POINTS, SLOPE_FITS = 12, 64, 3e-14
REFERENCE_NM = 550.0
DIRECTIONS, PER_WAVE, WAVES = 8, 16, 3  # along which, and how finely, rings are averaged over the footprint
PER_CELL, PER_WAVELENGTH, PER_WEIGHT = 3e-8, 8e-9, 1e-9  # seconds of one core, measured
PER_ENERGY, PER_INTEGRAL = 2e-7, 1e-5  # of E at one place, and where it is an integral over a curve
CONTRACTED = 20_000  # weights that one thread takes before another one has begun
WINDOW = 32.0  # blurs to either side, in which a footprint of which only the envelope is known hears them


class Table(NamedTuple):
    """E/r² of every weight set, summed over wavelengths.

    cells : (k, cells, 6) quintics;  step: pitches
    far   : (k, 4) Σw, Σw·c1, Σw·c3, Σw·c5: E = Σw − Σ c/rⁿ + what oscillates
    """

    cells: F64
    step: float
    far: F64


def table_of(lens: RoundLens, blur: F64, weights: F64, radius: float, allowed: float) -> Table:
    """Tabulate a round lens out to ``radius`` (pitches) and a little.

    blur : (j,), pitches;  weights: (k, j);  allowed: what the tables may be wrong by
    """
    per_blur = _per_blur(allowed)
    step = float(blur.min()) / per_blur
    cells = math.ceil(radius / step) + 2 * per_blur
    profile = _profile(lens, 1 << (cells + 4).bit_length(), per_blur)
    values = _contracted(profile, per_blur, blur, weights, step, cells)
    return Table(quintic_cells(values), step, smooth_powers(lens, blur, weights))


def table_seconds(lens: RoundLens, blurs: float, allowed: float, wavelengths: int, sets: int) -> float:
    """Return what a table is expected to take, of one core, out to so many of the shortest blurs."""
    per_energy = PER_INTEGRAL if isinstance(lens, RadialOtf) else PER_ENERGY
    per_blur = _per_blur(allowed)
    cells = blurs * per_blur
    of_cell = PER_CELL * sets + wavelengths * (PER_WAVELENGTH + PER_WEIGHT * sets)
    profile = 1 << math.ceil(cells + 2 * per_blur + 4).bit_length()
    return cells * of_cell + profile * (PER_CELL + per_energy * PANEL_POINTS / (PANEL_BLURS * per_blur))


def _per_blur(allowed: float) -> int:
    """Return how many cells a blur takes: what quintics leave falls as the sixth power of their number."""
    for cells in FEWER:
        if SURELY * CELLS_LEAVE * (CELLS_PER_BLUR / cells) ** 6 <= allowed:
            return cells
    return CELLS_PER_BLUR if allowed >= CELLS_LEAVE else 2 * CELLS_PER_BLUR


def smooth_powers(lens: RoundLens, blur: F64, weights: F64) -> F64:
    """Return (k, 4) the smooth powers of every set; see ``Table``."""
    powers = [c * blur**n for c, n in zip(_far_powers(lens), (1, 3, 5), strict=True)]
    smooth: F64 = weights @ np.stack([np.ones_like(blur), *powers], axis=1)
    return smooth


@functools.lru_cache(maxsize=16)
def _profile(lens: RoundLens, cells: int, per_blur: int) -> F64:
    """E/ρ² as a quintic per cell (cells, 6), even in ρ; ρ in blurs.

    It has no wave shorter than a blur, and E of a curve is an integral: a sixth as many do. The first panel is an even
    one: near 0 E is a difference of ones.
    """
    blur_um, per_panel = lens.blur_um(REFERENCE_NM), PANEL_BLURS * per_blur
    panels, (of_even, of_panel) = math.ceil((cells + 3) / per_panel), _between(per_panel)
    first = chebyshev(EVEN_POINTS)[EVEN_POINTS // 2 :]
    others = np.arange(1, panels)[:, None] + 0.5 * (1.0 + chebyshev(PANEL_POINTS))
    rho = PANEL_BLURS * np.concatenate([first, others.ravel()])
    values = lens.encircled_energy(rho * blur_um, REFERENCE_NM) / rho**2
    near, far = values[: first.size], values[first.size :].reshape(-1, PANEL_POINTS)
    half = np.concatenate([of_even @ np.concatenate([near[::-1], near]), product(far, of_panel.T).ravel()])[: cells + 3]
    profile = quintic_cells(np.concatenate([half[2:0:-1], half]))
    profile.flags.writeable = False
    return profile


@functools.lru_cache(maxsize=4)
def _between(count: int) -> tuple[F64, F64]:
    """Return what interpolates at so many even places of the half panel from 0 on, and of any other panel."""
    place = np.arange(count) / count
    return interpolation(chebyshev(EVEN_POINTS), place), interpolation(chebyshev(PANEL_POINTS), 2.0 * place - 1.0)


@functools.lru_cache(maxsize=16)
def _far_powers(lens: RoundLens) -> tuple[float, float, float]:
    """Return c1, c3, c5 of 1 − E = Σ c_n/ρⁿ + what oscillates.

    A term a·uⁿ of the transfer at 0 leaves a·M/(2πρ)ⁿ of E, M = ∫xⁿ·J1(x) dx = 1, −3, 45 for n = 1, 3, 5 (Abel's sense)
    and 0 for n even. The terms are read off a polynomial through the transfer where it is one: up to its first break.
    """
    per_um = 1.0 / lens.blur_um(REFERENCE_NM)
    angle, degree = np.pi * (np.arange(SLOPE_POINTS) + 0.5) / SLOPE_POINTS, np.arange(SLOPE_DEGREE + 1.0)
    series = np.cos(np.multiply.outer(angle, degree))  # Chebyshev's polynomials at points where least squares are sums
    top = 0.4
    while True:
        values = lens.otf(0.5 * top * (1.0 + np.cos(angle)) * per_um, np.zeros(1), REFERENCE_NM)
        coefficients = values @ series * (2.0 / SLOPE_POINTS)
        coefficients[0] *= 0.5
        if np.abs(series @ coefficients - values).max() <= SLOPE_FITS or top < 1e-3:
            break
        top *= 0.5
    # T_k has the n-th derivative (−1)^(k + n)·Π (k² − m²)/(2m + 1), m = 0 … n − 1, at −1, where u is 0.
    coefficients *= (-1.0) ** degree
    terms, taylor = [], np.ones_like(degree)
    for n in range(1, 6):
        taylor *= -(2.0 / top) / n * (degree**2 - (n - 1) ** 2) / (2 * n - 1)
        terms.append(float(coefficients @ taylor))
    c1, c3, c5 = (-terms[n - 1] * m / math.tau**n for n, m in ((1, 1.0), (3, -3.0), (5, 45.0)))
    return c1, c3, c5


def _contracted(profile: F64, per_blur: int, blur: F64, weights: F64, step: float, cells: int) -> F64:
    """Σ_j w[k, j]·E/r² of λ_j at multiples −2 … cells + 2 of ``step``."""
    values = np.zeros((len(weights), cells + 5))
    work = functools.partial(_contract, profile, float(per_blur), blur, weights, step, values)
    shared(cells + 5, work, least=1 + CONTRACTED // weights.size)
    return values


@kernel()
def _contract(
    profile: F64, per_blur: float, blur: F64, weights: F64, step: float, values: F64, begin: int, end: int
) -> None:
    for m in range(begin, end):
        for j in range(blur.size):
            u = abs(m - 2) * (step * per_blur / blur[j])
            c = profile[int(u)]
            t = u - int(u)
            value = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
            value *= 1.0 / (blur[j] * blur[j])
            for k in range(len(weights)):
                values[k, m] += weights[k, j] * value


def oscillation(lens: RoundLens, blur: F64, weights: F64, radius: F64, allowed: float) -> F64:
    """Return (k, n) what E of every set has at distances (n,) besides its smooth powers.

    blur, weights, allowed : as of ``table_of``
    """
    per_blur = _per_blur(allowed)
    cells = math.ceil(float(radius.max()) / float(blur.min()) * per_blur) + 2 * per_blur
    if radius.size * blur.size < cells:
        # Fewer than the table's: of a curve each is an integral.
        rho_um = np.divide.outer(radius, blur) * lens.blur_um(REFERENCE_NM)
        rest = lens.encircled_energy(rho_um, REFERENCE_NM) @ weights.T
    else:
        profile = _profile(lens, 1 << (cells + 4).bit_length(), per_blur)
        rest = np.zeros((radius.size, len(weights)))
        _contract_at(profile, float(per_blur), blur, np.ascontiguousarray(weights.T), radius, rest)
    powers = np.stack([np.ones_like(radius), -1.0 / radius, -(radius**-3.0), -(radius**-5.0)])
    left: F64 = rest.T - np.einsum("kp,pn->kn", smooth_powers(lens, blur, weights), powers)
    return left


@kernel()
def _contract_at(profile: F64, per_blur: float, blur: F64, of_wavelength: F64, radius: F64, energy: F64) -> None:
    """Add up E of every set (n, k) at distances."""
    for j in range(blur.size):
        for m in range(radius.size):
            u = radius[m] / blur[j]
            c = profile[int(u * per_blur)]
            t = u * per_blur - int(u * per_blur)
            value = (c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))) * u * u
            for k in range(energy.shape[1]):
                energy[m, k] += of_wavelength[j, k] * value


def loudness(
    lens: RoundLens, blur: F64, weights: F64, radius: float, *, longest: float, rule: tuple[F64, F64], allowed: float
) -> float:
    """Return how far E swings about its smooth powers near ``radius``, averaged over the footprint; the loudest set.

    blur, weights, allowed : as of ``table_of``;  longest: blur, pitches
    rule : nodes (m, 2) and weights (m,) over the footprint

    From as far away as this the footprint averages plane waves, in the direction where that takes the least.
    """
    step, (nodes, shares) = longest / CELLS_PER_BLUR, rule
    reach = math.ceil(float(np.hypot(nodes[:, 0], nodes[:, 1]).max()) / step) + 1
    count = 2 * reach + 1 + CELLS_PER_BLUR // PER_WAVE * (WAVES * PER_WAVE - 1)
    places = np.maximum(radius + step * np.arange(-reach, count - reach), 0.1 * radius)
    loudest: float = _loudest(oscillation(lens, blur, weights, places, allowed), reach, step, nodes, shares)
    return loudest


def muffled(
    lens: RoundLens, blur: F64, weights: F64, radius: float, *, longest: float, envelope: Envelope, allowed: float
) -> float:
    """Return the same of any footprint, of which all that is known is what it lets pass of waves at the most.

    Every wave of the swing in a window about ``radius`` is multiplied by that. What a footprint passes is its
    envelope, moved by no more than its extent, and as far the swing is followed anyway.
    """
    step, half = longest / PER_WAVE, math.ceil(PER_WAVE * min(WINDOW, 0.5 * radius / longest))
    window = np.cos(0.5 * np.pi * np.arange(-half, half) / half) ** 2
    places = radius + step * np.arange(-half, half, dtype=np.float64)
    swing = window * oscillation(lens, blur, weights, places, allowed)
    cycles = np.asarray(np.fft.rfftfreq(2 * half, step), np.float64)
    passed = np.fft.rfft(swing, axis=1) * envelope.at(cycles)
    middle = slice(half - WAVES * PER_WAVE // 2, half + WAVES * PER_WAVE // 2)
    return float(np.abs(np.fft.irfft(passed, 2 * half, axis=1)[:, middle]).max())


@kernel(allocates=True)
def _loudest(swing: F64, reach: int, step: float, nodes: F64, weights: F64) -> float:
    """Return the largest average of what sets (k, n) have at places a step apart, over all directions and places."""
    width, steps = 2 * reach + 1, CELLS_PER_BLUR // PER_WAVE
    # What each direction's average takes of places a step apart, straight between them.
    taken, size = np.zeros((width, DIRECTIONS)), 0.0
    for d in range(DIRECTIONS):
        cos, sin = math.cos(math.pi * d / DIRECTIONS), math.sin(math.pi * d / DIRECTIONS)
        for m in range(len(nodes)):
            place = (cos * nodes[m, 0] + sin * nodes[m, 1]) / step + reach
            cell = int(place)
            taken[cell, d] += weights[m] * (cell + 1 - place)
            taken[cell + 1, d] += weights[m] * (place - cell)
    for m in range(len(nodes)):
        size += abs(weights[m])
    most = np.zeros(len(swing))
    for k in range(len(swing)):
        for m in range(swing.shape[1]):
            most[k] = max(most[k], size * abs(swing[k, m]))
    loudest, average = 0.0, np.empty(DIRECTIONS)
    while True:
        # No average is louder than the loudest of what it is made of: few of many sets need be looked at.
        k = 0
        for other in range(len(most)):
            k = other if most[other] > most[k] else k
        if most[k] <= loudest:
            return loudest
        most[k] = 0.0
        for moved in range(0, swing.shape[1] - width + 1, steps):
            for d in range(DIRECTIONS):
                average[d] = 0.0
            for m in range(width):
                for d in range(DIRECTIONS):
                    average[d] += taken[m, d] * swing[k, moved + m]
            for d in range(DIRECTIONS):
                loudest = max(loudest, abs(average[d]))
