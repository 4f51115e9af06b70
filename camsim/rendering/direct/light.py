"""The check's own wavelengths: signals made from the curves themselves, and few nodes for many."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.arrays import F64
from camsim.products import product
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum, spectrum_at

FEWEST, MORE = 12, 8  # nodes: at the least, and beyond half a node for every radian


def densities(
    spectra: Sequence[Spectrum | Component], response: F64, wavelength_nm: F64, full: F64 | None = None
) -> tuple[F64, F64, F64]:
    """Return the wavelengths (n,) that carry signal, (spectra, channels, n) what each gives, and full scale (channels,).

    response : (channels, m) signal of a perfect diffuser, quadrature weight included
    full     : of a scene of which these spectra are a part
    """
    seen = (response != 0.0).any(axis=0)
    if not seen.any():
        seen = np.arange(wavelength_nm.size) == 0
    density = np.stack([spectrum_at(s, wavelength_nm[seen]) for s in spectra])[:, None] * response[None, :, seen]
    if full is None:
        full = np.maximum(response.sum(axis=1), density.sum(axis=2).max(axis=0))
        full = np.where(full > 0.0, full, 1.0)
    return wavelength_nm[seen], density / full[:, None], full


def count_of(count: int, phase: float, allowed: float) -> int:
    """Return to how many nodes so many wavelengths are moved; see ``condensed``."""
    return min(count, max(FEWEST, math.ceil(0.5 * phase + math.cbrt(phase) + MORE - 3.0 * math.log10(allowed))))


def condensed(wavelength_nm: F64, count: int) -> tuple[F64, F64]:
    """Return Chebyshev nodes (count,) and a matrix (n, count): signals times it weigh every polynomial as before."""
    if wavelength_nm.size == count:
        return wavelength_nm, np.eye(count)
    low, high = float(wavelength_nm.min()), float(wavelength_nm.max())
    angle = math.pi * (np.arange(count) + 0.5) / count
    nodes = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(angle)
    # ℓ_j(x) = (2/n) Σ' T_k(x_j)·T_k(x): sums of cosines, no differences of neighbours.
    place = np.arccos(np.clip((low + high - 2.0 * wavelength_nm) / (high - low), -1.0, 1.0))
    degree = np.arange(count)
    at_nodes, at_places = np.cos(np.outer(degree, angle)), np.cos(np.outer(degree, place))
    at_places[0] *= 0.5
    return nodes, (2.0 / count) * product(np.ascontiguousarray(at_places.T), at_nodes)
