"""The check's own wavelengths: signals made from the curves themselves, and few nodes for many."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.arrays import F64, I64, same_rows
from camsim.products import product
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum, spectrum_at

FEWEST, MORE = 20, 10  # nodes: at the least, and beyond half a node for every radian


def densities(
    spectra: Sequence[Spectrum | Component], response: F64, wavelength_nm: F64, *, full: F64 | None = None
) -> tuple[F64, F64]:
    """Return the wavelengths (n,) that carry signal, and (spectra, channels, n) what each gives, of full scale.

    response : (channels, m) signal of a perfect diffuser, quadrature weight included
    full     : (channels,) scale, where it is not that of these spectra
    """
    seen = (response != 0.0).any(axis=0)
    if not seen.any():
        seen = np.arange(wavelength_nm.size) == 0
    density = np.stack([spectrum_at(s, wavelength_nm[seen]) for s in spectra])[:, None] * response[None, :, seen]
    if full is None:
        full = np.maximum(response.sum(axis=1), density.sum(axis=2).max(axis=0))
    return wavelength_nm[seen], density / np.where(full > 0.0, full, 1.0)[:, None]


DIGITS = 12  # by which pairs of colours are the same but for a factor


def condensed_to(count: int, *, phase: float, allowed: float) -> int:
    """Return to how many nodes so many wavelengths are moved; see ``condensed``."""
    return min(count, max(FEWEST, math.ceil(0.5 * phase + MORE - 3.0 * math.log10(allowed))))


def condensed(wavelength_nm: F64, density: F64, *, phase: float, allowed: float) -> tuple[F64, F64]:
    """Move signals to Chebyshev nodes, so that they weigh every polynomial of that degree as before.

    phase : what a wave that matters turns by over the spectrum, radians;  allowed: what that may lose of it
    """
    count = condensed_to(wavelength_nm.size, phase=phase, allowed=allowed)
    if wavelength_nm.size == count:
        return wavelength_nm, density
    low, high = float(wavelength_nm.min()), float(wavelength_nm.max())
    angle = math.pi * (np.arange(count) + 0.5) / count
    nodes = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(angle)
    # ℓ_j(x) = (2/n) Σ' T_k(x_j)·T_k(x): sums of cosines, no differences of neighbours.
    place = np.arccos(np.clip((low + high - 2.0 * wavelength_nm) / (high - low), -1.0, 1.0))
    degree = np.arange(count)
    at_nodes, at_places = np.cos(np.outer(degree, angle)), np.cos(np.outer(degree, place))
    at_places[0] *= 0.5
    moved = (2.0 / count) * product(product(density.reshape(-1, place.size), at_places.T), at_nodes)
    return nodes, moved.reshape(*density.shape[:-1], count)


def widest(weights: F64) -> tuple[F64, I64, F64]:
    """Return the weights (k, channels, n) of which all (pairs, channels, n) are multiples, which of them, and by what.

    The factor is from −1 to 1: of greys the two that differ most stand for all.
    """
    flat = weights.reshape(len(weights), -1)
    size = np.take_along_axis(flat, np.abs(flat).argmax(axis=1)[:, None], axis=1)[:, 0]
    unit = flat / np.where(size == 0.0, 1.0, size)[:, None]
    first, which = same_rows(np.round(unit, DIGITS) + 0.0)
    most = np.zeros(len(first))
    np.maximum.at(most, which, np.abs(size))
    kept = unit[first] * most[:, None]
    return kept.reshape(-1, *weights.shape[1:]), which, size / np.where(most == 0.0, 1.0, most)[which]
