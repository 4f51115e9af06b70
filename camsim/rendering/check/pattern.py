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
from camsim.kernels import kernel
from camsim.optics.protocols import RoundLens
from camsim.quadrature import quintic_cells

CELLS_PER_BLUR = 64  # a quintic then errs by CELLS_LEAVE: 32 left 3e-10. Where that is too much, twice as many
CELLS_LEAVE = 5e-12
SLOPE_DEGREE, SLOPE_POINTS, SLOPE_FITS = 12, 64, 3e-14
REFERENCE_NM = 550.0
DIRECTIONS, PER_WAVE, WAVES = 8, 16, 3  # along which, and how finely, rings are averaged over the footprint


class Table(NamedTuple):
    """E/r² of every weight set, summed over wavelengths.

    cells : (k, cells, 6) quintics;  step: pitches
    far   : (k, 4) Σw, Σw·c1, Σw·c3, Σw·c5: E = Σw − Σ c/rⁿ + what oscillates
    """

    cells: F64
    step: float
    far: F64

    def oscillation(self, radius: F64) -> F64:
        """Return (k, n) what E has besides its smooth powers."""
        place = radius / self.step
        cell = np.minimum(place.astype(np.int64), self.cells.shape[1] - 1)
        t = place - cell
        value = np.zeros((len(self.cells), radius.size))
        for power in range(5, -1, -1):
            value = value * t + self.cells[:, cell, power]
        smooth = self.far @ np.stack([np.ones_like(radius), -1 / radius, -(radius**-3.0), -(radius**-5.0)])
        rest: F64 = value * radius**2 - smooth
        return rest


def table_of(lens: RoundLens, blur: F64, weights: F64, radius: float, allowed: float) -> Table:
    """Tabulate a round lens out to ``radius`` (pitches) and a little.

    blur : (j,), pitches;  weights: (k, j);  allowed: what the tables may be wrong by
    """
    per_blur = CELLS_PER_BLUR if allowed >= CELLS_LEAVE else 2 * CELLS_PER_BLUR
    step = float(blur.min()) / per_blur
    cells = math.ceil(radius / step) + 2 * per_blur
    profile = _profile(lens, 1 << (cells + 4).bit_length(), per_blur)
    powers = _far_powers(lens)
    far = weights @ np.stack(
        [np.ones_like(blur), *(c * blur**n for c, n in zip(powers, (1, 3, 5), strict=True))], axis=1
    )
    return Table(quintic_cells(_contracted(profile, per_blur, blur, weights, step, cells)), step, far)


@functools.lru_cache(maxsize=16)
def _profile(lens: RoundLens, cells: int, per_blur: int) -> F64:
    """E/ρ² as a quintic per cell (cells, 6), even in ρ; ρ in blurs."""
    blur_um = lens.blur_um(REFERENCE_NM)
    rho = np.arange(-2, cells + 3) / per_blur
    tiny = np.abs(rho) < 1e-6
    safe = np.where(tiny, 1e-4, np.abs(rho))  # E/ρ² is flat there to 1e-8 of itself, and no difference of ones
    profile = quintic_cells(lens.encircled_energy(safe * blur_um, REFERENCE_NM) / safe**2)
    profile.flags.writeable = False
    return profile


@functools.lru_cache(maxsize=16)
def _far_powers(lens: RoundLens) -> tuple[float, float, float]:
    """Return c1, c3, c5 of 1 − E = Σ c_n/ρⁿ + what oscillates.

    A term a·uⁿ of the transfer at 0 leaves a·M/(2πρ)ⁿ of E, M = ∫xⁿ·J1(x) dx = 1, −3, 45 for n = 1, 3, 5 (Abel's sense)
    and 0 for n even. The terms are read off a polynomial through the transfer where it is one: up to its first break.
    """
    per_um = 1.0 / lens.blur_um(REFERENCE_NM)
    top = 0.4
    while True:
        t = np.cos(np.pi * (np.arange(SLOPE_POINTS) + 0.5) / SLOPE_POINTS)
        u = 0.5 * top * (1.0 + t)
        values = lens.otf(u * per_um, np.zeros(1), REFERENCE_NM)
        fit = np.polynomial.Chebyshev.fit(u, values, SLOPE_DEGREE, domain=[0.0, top])
        if np.abs(fit(u) - values).max() <= SLOPE_FITS or top < 1e-3:
            break
        top *= 0.5
    slopes = fit.convert(kind=np.polynomial.Polynomial).coef[1:6:2]
    terms = [-a * m / (2.0 * math.pi) ** n for a, m, n in zip(slopes, (1.0, -3.0, 45.0), (1, 3, 5), strict=True)]
    return terms[0], terms[1], terms[2]


def _contracted(profile: F64, per_blur: int, blur: F64, weights: F64, step: float, cells: int) -> F64:
    """Σ_j w[k, j]·E/r² of λ_j at multiples −2 … cells + 2 of ``step``."""
    values = np.zeros((cells + 5, len(weights)))  # sets side by side: vectors
    _contract(profile, float(per_blur), blur, np.ascontiguousarray(weights.T), step, values)
    return np.ascontiguousarray(values.T)


@kernel()
def _contract(profile: F64, per_blur: float, blur: F64, of_wavelength: F64, step: float, values: F64) -> None:
    count, sets = values.shape
    for j in range(blur.size):
        scale = step * per_blur / blur[j]
        inverse_square = 1.0 / (blur[j] * blur[j])
        for m in range(count):
            u = abs(m - 2) * scale
            c = profile[int(u)]
            t = u - int(u)
            value = (c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))) * inverse_square
            for k in range(sets):
                values[m, k] += of_wavelength[j, k] * value


def loudness(table: Table, radius: float, blur: float, nodes: F64, weights: F64) -> float:
    """Return how far E swings about its smooth powers near ``radius``, averaged over the footprint; the loudest set.

    blur : the longest, pitches;  nodes (m, 2), weights (m,): a rule over the footprint

    From as far away as this the footprint averages plane waves, in the direction where that takes the least.
    """
    angle = math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ahead = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ nodes.T
    step, steps = blur / CELLS_PER_BLUR, CELLS_PER_BLUR // PER_WAVE
    low = math.floor(float(ahead.min()) / step)
    width = math.ceil(float(ahead.max()) / step) - low + 2
    # What each direction's average takes of places a step apart, straight between them.
    place = ahead / step - low
    cell = place.astype(np.int64)
    first = np.arange(DIRECTIONS)[:, None] * width + cell
    share = weights * (place - cell)
    taken = np.bincount(first.ravel(), (weights - share).ravel(), DIRECTIONS * width)
    taken += np.bincount(first.ravel() + 1, share.ravel(), DIRECTIONS * width)
    taken = taken.reshape(DIRECTIONS, width)
    fine = step * (low + np.arange(width + steps * (WAVES * PER_WAVE - 1)))
    swing = table.oscillation(np.maximum(radius + fine, 0.1 * radius))
    # No average is louder than the loudest of what it is made of: few of many sets need be looked at.
    most = np.abs(swing).max(axis=1) * np.abs(weights).sum()
    loudest = 0.0
    for k in np.argsort(-most):
        if most[k] <= loudest:
            break
        moved = np.lib.stride_tricks.sliding_window_view(swing[k], width)[::steps]
        # Not by a matrix product: threads of BLAS would spin for tens of milliseconds after it.
        loudest = max(loudest, float(np.abs(np.einsum("pc,dc->pd", moved, taken)).max()))
    return loudest
