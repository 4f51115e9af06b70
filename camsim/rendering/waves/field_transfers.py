"""Optical transfer functions of a circular pupil at many places and wavelengths at once.

A transfer is an integral over the overlap of the pupil and its shifted copy. Its quadrature nodes depend on the
frequency alone, so the wavefronts of all places share them: at a node each phase is a sum of the same differences of
Zernike polynomials. The integrand is analytic along chords and in the angle that selects the chord: x = u, y = sin α
with |u| ≤ cos α − ρ, |α| ≤ arccos ρ.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from camsim.core.arrays import C128, F64, I64
from camsim.core.kernels import kernel, shared
from camsim.core.kernels.turning import turned
from camsim.errors import UnsupportedError
from camsim.numerics.matrix_products import complex_product, real_product
from camsim.numerics.quadrature import chebyshev, gauss_rules
from camsim.numerics.zernike import layout, orders, zernike
from camsim.optics.placed import PlacedLens
from camsim.optics.protocols import Placed
from camsim.optics.pupil import Pupil
from camsim.optics.transfer_table import radial_matrix, radial_places

NODES = 6, 8, 10, 12, 16, 20, 24, 32, 40, 52, 64, 88, 120, 160, 220, 300  # per axis of an overlap; even
RADII = 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256, 320, 400
DIRECTIONS = 6, 8, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256  # over half a turn
TRIED_RADII, TRIED_DIRECTIONS = np.array([0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]), np.array([0.4, 1.3])
BETWEEN = np.pi * np.array([0.031, 0.173, 0.342, 0.561])  # test directions, on no evenly spaced grid
MANY_RADII, MANY_DIRECTIONS = (24, 60, 120, 240, 480), (24, 48, 96, 320)  # trial samplings, finer than needed
PLANES = 1, 2  # Zernike tilts along y and along x
BLOCK = 32  # nodes at a time
TERMS = 66  # Zernikes to order 10, the first fit of a custom wavefront
MOST_TERMS, FITTED = 231, 1e-4  # and to order 20; largest residual, waves


class Wavefronts:
    """Wavefronts of several places at several wavelengths.

    zernike : (k,) OSA/ANSI indices;  waves: (k, n) coefficients
    """

    def __init__(self, zernike: tuple[int, ...], waves: F64) -> None:
        self.zernike, self.waves = zernike, waves

    @classmethod
    def of(cls, lenses: Sequence[Placed], wavelength_nm: F64) -> Wavefronts:
        """Return the wavefronts of lenses, each at all wavelengths."""
        each = [_coefficients(lens, wavelength_nm) for lens in lenses]
        index = tuple(
            sorted({j for item, values in each for j, one in zip(item, values.T, strict=True) if j and one.any()})
        )
        waves = np.zeros((len(index), len(lenses), wavelength_nm.size))
        for k, (item, values) in enumerate(each):
            for j, value in zip(item, values.T, strict=True):
                if j in index:
                    waves[index.index(j), k] = value
        return cls(index, waves.reshape(len(index), len(lenses) * wavelength_nm.size))

    def less(self, planes_nm: tuple[float, float], wavelength_nm: F64) -> Wavefronts:
        """Return the wavefronts without planes of Zernikes 1 and 2, the path differences that all places share."""
        places = self.waves.shape[1] // wavelength_nm.size
        waves = self.waves.reshape(len(self.zernike), places, wavelength_nm.size).copy()
        for index, path_nm in zip(PLANES, planes_nm, strict=True):
            if index in self.zernike:
                waves[self.zernike.index(index)] -= path_nm / wavelength_nm
        return Wavefronts(self.zernike, waves.reshape(self.waves.shape))

    @property
    def mirrored(self) -> bool:
        """Whether all wavefronts are symmetric about the x axis."""
        return all(orders(j)[1] >= 0 for j in self.zernike)

    def transfers(self, rho: F64, angle: F64, nodes: I64) -> C128:
        """Return transfers (n, places) at ρ = |f|·λN and directions (n,), with ``nodes`` (n,) along each axis."""
        index, norms, steps = layout(self.zernike)
        slots = np.full(steps.shape[0] * 2 * steps.shape[1], -1)
        slots[index] = np.arange(index.size)
        counts, which = np.unique(nodes, return_inverse=True)
        rules = gauss_rules(tuple(counts.tolist()))
        out = np.empty((rho.size, self.waves.shape[1]), complex)
        waves = np.ascontiguousarray(self.waves * norms[:, None])
        shared(
            rho.size,
            functools.partial(_overlaps, rho, angle, waves, slots.reshape(len(steps), 2, -1), steps, rules, which, out),
        )
        return out


def _coefficients(lens: Placed, wavelength_nm: F64) -> tuple[tuple[int, ...], F64]:
    """Return Zernike indices (k,) and coefficients (wavelengths, k), waves, of a lens at a place."""
    if isinstance(lens, PlacedLens):
        return lens.zernike, lens.coefficients(wavelength_nm)
    x, y, _ = Pupil().nodes(40, 40)
    waves = np.stack([lens.waves(x, y, nm) for nm in wavelength_nm.tolist()])
    for count in (TERMS, MOST_TERMS):
        terms = np.stack([zernike(j, x, y) for j in range(count)], axis=1)
        found: F64 = np.asarray(np.linalg.lstsq(terms, waves.T, rcond=None)[0], float)
        if np.abs(terms @ found - waves.T).max() <= FITTED:
            return tuple(range(count)), found.T
    raise UnsupportedError("its wavefront is no polynomial of order 20 or less", key="lens")


@dataclass(frozen=True)
class Rule:
    """Quadrature and sampling of transfers.

    outer : the largest ρ = |f|·λN
    nodes : quadrature nodes along each axis, at the fractions ``TRIED_RADII`` of ``outer``
    radii, directions : samples of a table; directions over half a turn
    """

    outer: float
    nodes: tuple[int, ...]
    radii: int = 0
    directions: int = 0

    @classmethod
    def of(cls, fronts: Wavefronts, allowed: float, outer: float) -> Rule:
        """Return the coarsest rule whose error is at most ``allowed`` for all the wavefronts given."""
        rho, angle = (item.ravel() for item in np.meshgrid(outer * TRIED_RADII, TRIED_DIRECTIONS, indexing="ij"))
        nodes = np.zeros(TRIED_RADII.size, np.int64)
        known = fronts.transfers(rho, angle, np.full(rho.size, NODES[0]))
        for count, finer in pairwise(NODES):
            open_ = np.repeat(nodes == 0, TRIED_DIRECTIONS.size)
            right = known.copy()
            right[open_] = fronts.transfers(rho[open_], angle[open_], np.full(int(open_.sum()), finer))
            off = np.abs(right - known).max(axis=1).reshape(nodes.size, -1).max(axis=1)
            nodes[(nodes == 0) & (off <= 0.3 * allowed)] = count
            if nodes.all():
                break
            known = right
        else:
            raise UnsupportedError("its wavefronts turn too often over the pupil", key="lens")
        first = cls(outer, tuple(nodes.tolist()))
        return replace(first, radii=first._radii(fronts, allowed), directions=first._directions(fronts, allowed))

    def at(self, fronts: Wavefronts, rho: F64, angle: F64) -> C128:
        """Return transfers (n, places)."""
        interval = np.searchsorted(self.outer * TRIED_RADII, rho)
        nodes = np.array(self.nodes)
        last = nodes.size - 1
        item = np.maximum(nodes[np.minimum(interval, last)], nodes[np.clip(interval - 1, 0, last)])
        return fronts.transfers(rho, angle, item)

    def on_lattice(self, fronts: Wavefronts) -> C128:
        """Return angular harmonics (places, radii, 2·directions) of transfers; angles count from the x axis."""
        count = self.directions
        first = count // 2 + 1 if fronts.mirrored else count
        angle = np.pi * np.arange(first) / count
        rho = self.outer * radial_places(self.radii)
        half = self.at(fronts, np.repeat(rho, first), np.tile(angle, self.radii)).reshape(self.radii, first, -1)
        if fronts.mirrored:  # T(ρ, π − θ) is the conjugate of T(ρ, −θ), which is T(ρ, θ)
            half = np.concatenate([half, half[:, count - first : 0 : -1].conj()], axis=1)
        whole = np.concatenate([half, half.conj()], axis=1)
        waves = scipy.fft.fft(whole, axis=1) / (2 * count)
        return np.ascontiguousarray(np.moveaxis(waves, 2, 0))

    def between(self, rho: F64) -> F64:
        """Return the interpolation matrix (n, radii) to ρ (n,), zero beyond ``outer``."""
        matrix = np.zeros((rho.size, self.radii))
        inside = rho < self.outer * (1.0 + 1e-12)
        matrix[inside] = radial_matrix(self.radii, np.minimum(rho[inside] / self.outer, 1.0))
        return matrix

    def _radii(self, fronts: Wavefronts, allowed: float) -> int:
        """Return how many radii suffice for interpolation, from the Chebyshev series along two directions."""
        for count in MANY_RADII:
            rho, angle = self.outer * radial_places(count), np.repeat(TRIED_DIRECTIONS, count)
            values = self.at(fronts, np.tile(rho, 2), angle).reshape(2, count, -1)
            series = np.cos(np.arange(count)[:, None] * np.arccos(chebyshev(count))) * (2.0 / count)
            size = np.abs(real_product(series, values)).max(axis=(0, 2))
            if (fits := _fewest(size, RADII, allowed)) is not None:
                return fits
        raise UnsupportedError("its wavefronts turn too often along the pupil's radius", key="lens")

    def _directions(self, fronts: Wavefronts, allowed: float) -> int:
        """Return how many directions suffice for interpolation, from the harmonics at a few radii.

        Harmonics of a wavefront that is periodic around the pupil can alias onto each other; test directions between
        the samples reveal this.
        """
        rho = self.outer * TRIED_RADII[1::3]
        right = self.at(fronts, np.repeat(rho, BETWEEN.size), np.tile(BETWEEN, rho.size))
        for count in MANY_DIRECTIONS:
            angle, order = np.pi * np.arange(count) / count, np.fft.fftfreq(2 * count, 0.5 / count)
            half = self.at(fronts, np.repeat(rho, count), np.tile(angle, rho.size)).reshape(rho.size, count, -1)
            waves = scipy.fft.fft(np.concatenate([half, half.conj()], axis=1), axis=1) / (2 * count)
            size = np.abs(waves).max(axis=(0, 2))
            size = size[:count] + np.concatenate([[0.0], size[:count:-1]])
            if (fits := _fewest(size, DIRECTIONS, 0.5 * allowed)) is not None:
                retained = np.abs(order) < fits
                turned = np.exp(1j * np.outer(BETWEEN, order[retained]))
                found = np.concatenate([complex_product(turned, one) for one in waves[:, retained]])
                if np.abs(found - right).max() <= allowed:
                    return fits
        raise UnsupportedError("its wavefronts turn too often around the pupil", key="lens")


def _fewest(size: F64, counts: tuple[int, ...], allowed: float) -> int | None:
    """Return the smallest count whose remaining terms sum to at most ``allowed``; None: the series is too short."""
    beyond = np.cumsum(size[::-1])[::-1]
    return next((n for n in counts if n < 0.85 * size.size and beyond[n] <= allowed), None)


@kernel(allocates=True)
def _overlaps(
    rho: F64,
    angle: F64,
    waves: F64,
    slots: I64,
    steps: F64,
    rules: tuple[F64, F64, I64],
    which: I64,
    out: C128,
    begin: int,
    stop: int,
) -> None:
    """Write ∫ exp(2πi(W(x − s/2) − W(x + s/2))) dx over an overlap, over the opening's area: out (n, places).

    waves : (k, places) coefficients of polynomials that are 1 at the rim
    slots : (m, 2, p) row of ``waves`` for each polynomial, cos or sin; −1: none;  steps: see ``zernike.radial_steps``
    """
    nodes, weights, counts = rules
    azimuthal, degrees = len(slots), slots.shape[2]
    places = waves.shape[1]
    # At the opposite node, the differences of polynomials are the same for odd m, and of the other sign for even m.
    even, odd = np.empty((places, BLOCK)), np.empty((places, BLOCK))
    real, imag, weight = np.empty((places, BLOCK)), np.empty((places, BLOCK)), np.empty(BLOCK)
    x0, y0, x1, y1 = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    c0, d0, c1, d1 = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    p0, p1, before0, before1 = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    difference = np.empty(BLOCK)
    for n in range(begin, stop):
        item, count = rho[n], counts[which[n]]
        x, w = nodes[which[n]], weights[which[n]]
        cos, sin = math.cos(angle[n]), math.sin(angle[n])
        widest = math.acos(min(item, 1.0))
        for q in range(places):
            for i in range(BLOCK):
                real[q, i], imag[q, i] = 0.0, 0.0
        for first in range(0, count * count // 2, BLOCK):
            size = min(BLOCK, count * count // 2 - first)
            row = -1
            for i in range(size):
                a = (first + i) // count
                v = first + i - a * count
                if a != row:
                    row, alpha = a, widest * x[a]
                    t, chord = math.sin(alpha), math.cos(alpha)
                    half, along = chord - item, 2.0 * w[a] * widest * chord * (chord - item) / math.pi
                u = half * x[v]
                weight[i] = along * w[v]
                x0[i], y0[i] = (u - item) * cos - t * sin, (u - item) * sin + t * cos
                x1[i], y1[i] = (u + item) * cos - t * sin, (u + item) * sin + t * cos
            for q in range(places):
                for i in range(size):
                    even[q, i], odd[q, i] = 0.0, 0.0
            for m in range(azimuthal):
                _next_power(c0, d0, x0, y0, m, size)  # real and imaginary parts of (x + iy)^m
                _next_power(c1, d1, x1, y1, m, size)
                for p in range(degrees):
                    _next_degree(p0, before0, x0, y0, steps[m, p], p, size)
                    _next_degree(p1, before1, x1, y1, steps[m, p], p, size)
                    for turn in range(2):
                        k = slots[m, turn, p]
                        if k < 0:
                            continue
                        one, other = (c0, c1) if turn == 0 else (d0, d1)
                        for i in range(size):
                            difference[i] = one[i] * p0[i] - other[i] * p1[i]
                        phase = odd if m % 2 else even
                        for q in range(places):
                            _add_times(phase[q], waves[k, q], difference, size)
            for q in range(places):
                for i in range(size):
                    c, d = turned(odd[q, i])
                    both = weight[i] * turned(even[q, i])[0]
                    real[q, i] += both * c
                    imag[q, i] += both * d
        for q in range(places):
            out[n, q] = complex(real[q].sum(), imag[q].sum())


@kernel()
def _next_power(c: F64, d: F64, x: F64, y: F64, m: int, size: int) -> None:
    if m == 0:
        c[:size] = 1.0
        d[:size] = 0.0
        return
    for i in range(size):
        c[i], d[i] = c[i] * x[i] - d[i] * y[i], c[i] * y[i] + d[i] * x[i]


@kernel()
def _next_degree(p: F64, before: F64, x: F64, y: F64, step: F64, degree: int, size: int) -> None:
    if degree == 0:
        p[:size] = 1.0
        before[:size] = 0.0
        return
    a, b, e = step
    for i in range(size):
        p[i], before[i] = (a * (x[i] * x[i] + y[i] * y[i]) + b) * p[i] - e * before[i], p[i]


@kernel(forceinline=True)
def _add_times(total: F64, factor: float, values: F64, size: int) -> None:
    for i in range(size):
        total[i] += factor * values[i]
