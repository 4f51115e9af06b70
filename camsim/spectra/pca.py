"""A spectral cube as few planes, with an error bound for every sample at every wavelength."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camsim.core.arrays import F64
from camsim.core.words import LIGHT_NM
from camsim.errors import InvalidValueError
from camsim.spectra.component import Component
from camsim.spectra.curve import ends_where_no_light_is

MOST_BANDS = 1024
_PART = 65_536  # samples at a time


def planes_of_cube(
    cube: NDArray[np.floating], wavelength_nm: F64, *, error: float
) -> tuple[F64, tuple[Component, ...]]:
    """Return the fewest planes (m, rows, cols) and their spectra whose sum is the cube within the error.

    cube  : (rows, cols, bands) reflectances;  wavelength_nm: (bands,) increasing
    error : largest difference of any sample from the cube in any band; 0 keeps every band

    Principal components about 0, so that black is no light; as few as the error allows.
    """
    if cube.ndim != 3 or not cube.size or wavelength_nm.shape != (cube.shape[2],):
        raise InvalidValueError(
            f"must be (rows, cols, bands) with a wavelength for each band, not an array of shape {cube.shape} and "
            f"{wavelength_nm.size} wavelengths",
            key="cube",
        )
    if cube.dtype.kind not in "biuf":
        raise InvalidValueError(f"must hold numbers, not {cube.dtype}", key="cube")
    bands = cube.shape[2]
    if bands > MOST_BANDS:
        raise InvalidValueError(f"{bands} bands; at most {MOST_BANDS} are taken", key="cube")
    if not (np.isfinite(wavelength_nm).all() and wavelength_nm[0] > 0 and (np.diff(wavelength_nm) > 0).all()):
        raise InvalidValueError("must increase, nm above 0, each given once", key="wavelength_nm")
    if wavelength_nm[-1] < LIGHT_NM[0]:
        raise InvalidValueError(ends_where_no_light_is(float(wavelength_nm[-1])), key="wavelength_nm")
    samples = cube.reshape(-1, bands)
    low, high = float(samples.min()), float(samples.max())
    if not (np.isfinite(low) and np.isfinite(high)):
        raise InvalidValueError("holds numbers that are not finite", key="cube")
    if low < -1e-6 or high > 1.0 + 1e-6:
        raise InvalidValueError(
            f"must be reflectances from 0 to 1, not {low if low < 0 else high:g}; divide by the white's",
            key="cube",
        )
    directions = _principal(samples) if error > 0.0 else np.eye(bands)
    count = bands if error <= 0.0 else _fewest(samples, directions, error)
    selected = np.ascontiguousarray(directions[:count])
    planes = np.concatenate([np.einsum("sb,mb->ms", part, selected) for part in _parts(samples)], axis=1)
    return planes.reshape(count, *cube.shape[:2]), tuple(Component(wavelength_nm, row) for row in selected)


def _principal(samples: NDArray[np.floating]) -> F64:
    """Return orthonormal directions (bands, bands), the strongest first, with fixed signs."""
    gram = np.zeros((samples.shape[1],) * 2)
    for part in _parts(samples):
        gram += np.einsum("sa,sb->ab", part, part)
    _, vectors = np.linalg.eigh(gram)
    directions: F64 = np.ascontiguousarray(vectors.T[::-1])
    largest = directions[np.arange(len(directions)), np.abs(directions).argmax(axis=1)]
    directions *= np.sign(largest)[:, None]
    return directions


def _fewest(samples: NDArray[np.floating], directions: F64, error: float) -> int:
    worst = np.zeros(len(directions))
    for part in _parts(samples):
        left = part.astype(np.float64)
        weights = np.einsum("sb,mb->sm", left, directions)
        for m in range(len(directions)):
            left -= weights[:, m, None] * directions[m]
            worst[m] = max(worst[m], float(np.abs(left).max()))
            if worst[m] <= 0.01 * error:
                break
    enough = np.flatnonzero(worst <= error)
    return int(enough[0]) + 1 if enough.size else len(directions)


def _parts(samples: NDArray[np.floating]) -> list[NDArray[np.floating]]:
    return [samples[first : first + _PART] for first in range(0, len(samples), _PART)]
