"""Wavelength nodes: how many a rendering needs, and the weights of every spectrum at each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, distinct, same_rows
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsWaves
from camsim.scene import Arrangement
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum, spectrum_at
from camsim.spectra.integral import lagrange, lumped, whole_nanometres

FEWEST_NODES = 16  # so few cost nothing beside the rest
ALIKE = 12  # digits to which proportional weights agree
ROUNDED_BITS = 48  # rounding of weights, in bits below the largest
PROBED = 16  # stride of the columns that are compared first
FEW_KINDS = 500  # largest number of rows that are compared one by one


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals:
    """Signal of each spectrum in each channel at each wavelength, without optics, in units of the channel's scale.

    wavelength_nm : (n,) wavelengths that carry signal, at which light, filters and surfaces were multiplied; lumped
                    where the curves needed more of them than the optics do
    density       : (spectra, channels, n), quadrature weight included: a sum over n is a mean signal
    scale         : (channels,) the larger of a perfect diffuser and the brightest spectrum, in the caller's unit
    """

    wavelength_nm: F64
    density: F64
    scale: F64

    @classmethod
    def of(cls, arrangement: Arrangement, response: F64, wavelength_nm: F64) -> Signals:
        """Multiply the channels' response (channels, n) to a perfect diffuser by every reflectance."""
        nodes, density = multiplied(arrangement.spectra, response, wavelength_nm)
        scale = np.maximum(response.sum(axis=1), density.sum(axis=2).max(axis=0))
        scale = np.where(scale > 0.0, scale, 1.0)
        return cls(wavelength_nm=nodes, density=density / scale[:, None], scale=scale)


def carrying(response: F64) -> np.ndarray:
    """Return a mask (n,) of the wavelengths with a response (channels, n) in any channel; at least one is True.

    Light to which no channel responds still makes an image, a black one.
    """
    carries: np.ndarray = np.any(response != 0.0, axis=0)
    carries[0] |= not carries.any()
    return carries


def multiplied(spectra: Sequence[Spectrum | Component], response: F64, wavelength_nm: F64) -> tuple[F64, F64]:
    """Return wavelengths (m,) that carry signal, lumped, and the signals (spectra, channels, m) at them."""
    carries = carrying(response)
    wavelength_nm, response = wavelength_nm[carries], response[:, carries]
    parts = []
    for here in whole_nanometres(wavelength_nm):
        reflectance = np.stack([spectrum_at(s, wavelength_nm[here]) for s in spectra])
        parts.append(lumped(wavelength_nm[here], reflectance[:, None, :] * response[None, :, here]))
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts], axis=2)


def multiples(weights: F64) -> tuple[I64, F64]:
    """Return for each row (k, n) the largest row proportional to it, and the factor, −1 to 1; all greys share one row.

    >>> multiples(np.array([[1.0, 2.0], [-2.0, -4.0], [0.0, 1.0]]))
    (array([1, 1, 2]), array([-0.5,  1. ,  1. ]))
    """
    if len(weights) == 1:
        return np.zeros(1, np.int64), np.ones(1)
    order = np.argsort(-np.abs(weights).max(axis=1), kind="stable")
    largest = np.abs(weights).argmax(axis=1)
    size = weights[np.arange(len(weights)), largest]
    shape = np.round(weights / np.where(size == 0.0, 1.0, size)[:, None], ALIKE) + 0.0
    first, group = same_rows(shape[order])
    which = np.empty(len(weights), np.int64)
    which[order] = order[first][group]
    which = _joined(weights, which)
    there = largest[which]
    one, other = weights[np.arange(len(weights)), there], weights[which, there]
    return which, np.where(other == 0.0, 1.0, one / np.where(other == 0.0, 1.0, other))


def different(weights: F64) -> F64:
    """Return the rows (k, n) of which no two are proportional.

    >>> different(np.array([[1.0, 2.0], [-2.0, -4.0], [0.0, 1.0]]))
    array([[-2., -4.],
           [ 0.,  1.]])
    """
    return weights[distinct(multiples(weights)[0])]


def kinds(contrast: F64) -> tuple[F64, F64]:
    """Return the shares of a few basis spectra in every spectrum, the background first, and the basis's contrast.

    contrast : (spectra, channels, j) signals relative to the background

    Greys are proportional, so all their regions are transformed together.
    """
    which, times = multiples(contrast.reshape(len(contrast), -1))
    few = distinct(which)
    shares = np.concatenate([np.zeros((1, few.size)), times[:, None] * (which[:, None] == few)])
    return shares, np.ascontiguousarray(contrast[few])


def _joined(weights: F64, which: I64) -> I64:
    """Return ``which`` (k,) with rows joined that differ only by rounding.

    A weak row, the difference of nearly equal spectra, has fewer correct digits than ``ALIKE``, so that rounding may
    have separated it.
    """
    leaders = distinct(which)
    if not 1 < leaders.size <= FEW_KINDS:
        return which
    size = np.abs(weights[leaders]).max(axis=1)
    leaders = leaders[np.argsort(-size, kind="stable")]
    noise, of = np.ldexp(np.abs(weights).max(), -ROUNDED_BITS), np.arange(len(weights))
    for k, leader in enumerate(leaders.tolist()):
        if of[leader] != leader:
            continue
        one, others = weights[leader], leaders[k + 1 :]
        there = int(np.abs(one).argmax())
        if one[there] != 0.0:
            for columns in (slice(None, None, PROBED), slice(None)):  # most differ in the first columns
                factor = weights[others, there] / one[there]
                rest = weights[others, columns] - factor[:, None] * one[columns]
                others = others[np.abs(rest).max(axis=1) <= noise]
            of[others] = leader
    joined: I64 = of[which]
    return joined


def blur_of(system: OpticalSystem, wavelength_nm: F64, pitch_um: float) -> F64:
    """Return the scale of the lens's PSF (λN) at each wavelength, in pitches."""
    return system.blurs_um(wavelength_nm) / pitch_um


def wavefront_phase(system: OpticalSystem, wavelength_nm: F64) -> float:
    """Return the change of a wavefront's phase over a spectrum, radians; 0 for a lens without a wavefront."""
    if not isinstance(system.lens, KnowsWaves):
        return 0.0
    return 2.0 * math.pi * system.lens.waves_turned(float(wavelength_nm.min()), float(wavelength_nm.max()))


def nodes_that_follow(phase: float, allowed: float) -> int:
    """Return how many polynomial nodes resolve a wave over ``phase`` radians; see ``fuse``."""
    return math.ceil(0.5 * phase + math.cbrt(phase) + 3.5 - 3.0 * math.log10(allowed))


def fuse(signals: Signals, *, phase: float, allowed: float, count: int | None = None) -> tuple[F64, F64]:
    """Return nodes (j,) in nm and weights (spectra, channels, j) on them.

    The optics vary smoothly with wavelength, while light and filters may have any shape. So the curves are integrated
    on their grid against the Lagrange polynomials of the nodes: totals are exact for any number of nodes, and a lamp's
    lines need no nodes at their wavelengths. ``phase`` is the range of 2πr/λN over the spectrum at the largest distance
    that matters; a polynomial resolves it with phase/2 + ∛phase nodes, and gains about a digit for every three more
    (measured on the shipped sensors and CIE F lamps). ``count``: the number of nodes, if it is known.
    """
    wavelength_nm = signals.wavelength_nm
    count = count or max(FEWEST_NODES, nodes_that_follow(phase, allowed))
    if wavelength_nm.size <= count:
        return wavelength_nm, signals.density
    x, gauss_w = gauss_legendre(count)
    low, high = wavelength_nm[0], wavelength_nm[-1]
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * x
    # No BLAS: its order of summation depends on the number of cores.
    return nodes, np.einsum("scn,nj->scj", signals.density, lagrange(wavelength_nm, nodes, x, gauss_w))


def fuse_by_light(signals: Signals, count: int) -> tuple[F64, F64]:
    """Return nodes (j,) in nm and weights as of ``fuse``, with Gauss nodes for the light's spectrum as weight function.

    The ends of a spectrum, where there is little light, get few nodes.
    """
    wavelength_nm = signals.wavelength_nm
    if wavelength_nm.size <= count:
        return wavelength_nm, signals.density
    light = np.abs(signals.density).max(axis=0).sum(axis=0)
    middle, half = 0.5 * (wavelength_nm[0] + wavelength_nm[-1]), 0.5 * (wavelength_nm[-1] - wavelength_nm[0])
    place = (wavelength_nm - middle) / half
    # Lanczos recurrence of the polynomials orthogonal under the light's spectrum: their zeros are the nodes.
    diagonal, off_diagonal = np.zeros(count), np.zeros(count)
    vectors = [np.sqrt(light / light.sum())]
    for k in range(count):
        following = place * vectors[-1]
        diagonal[k] = np.sum(following * vectors[-1])
        for vector in (*vectors, *vectors):
            following = following - np.sum(following * vector) * vector
        off_diagonal[k] = math.sqrt(np.sum(following**2))
        vectors.append(following / off_diagonal[k])
    zeros = np.linalg.eigvalsh(np.diag(diagonal) + np.diag(off_diagonal[:-1], -1))  # scipy.linalg takes long to import

    basis = np.ones((wavelength_nm.size, count))
    for j in range(count):
        for other in range(count):
            if other != j:
                basis[:, j] *= (place - zeros[other]) / (zeros[j] - zeros[other])

    return middle + half * zeros, np.einsum("scn,nj->scj", signals.density, basis)
