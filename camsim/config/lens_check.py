"""Difference between a lens file's OTFs and those of its rays."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from camsim.config.lens_rays import Prescription
from camsim.core.arrays import F64
from camsim.errors import InputError, UnsupportedError
from camsim.numerics.zernike import cosines, orders
from camsim.optics.field_lens import FieldLens

GOLDEN = math.pi * (3.0 - math.sqrt(5.0))  # golden angle, which covers the pupil uniformly
CHECK_RAYS = 2500  # for the check of transfer functions
CHECK_STEP = 0.02  # lattice step for their interpolation, in pupil radii
RIM = 1.06  # of the pupil's radius: extent of rays, to locate its rim
CHECKED = (0.0, 0.35, 0.5, 0.7, 0.85, 1.0)  # of the field
CYCLES_PER_MM = (10.0, 20.0, 40.0)
CHECKED_NM = (450.0, 550.0, 650.0)
MOST_ORDER, MORE = 20, 4  # largest order of path polynomials, and excess over the file's


def even_disc(count: int, radius: float = 1.0) -> F64:
    """Return points (2, n) of equal areas over a disc."""
    number: F64 = np.arange(count, dtype=float)
    distance, angle = radius * np.sqrt((number + 0.5) / count), GOLDEN * number
    return np.stack([distance * np.cos(angle), distance * np.sin(angle)])


def least_squares(rows: F64, values: F64) -> F64:
    """Return least-squares coefficients of minimal norm in poorly determined directions."""
    found: F64 = np.asarray(np.linalg.lstsq(rows, values, rcond=1e-6)[0], float)
    return found


def compared(stated: Prescription, full_rad: float, found: FieldLens, name: str) -> tuple[F64, tuple[float, ...]]:
    """Return by how much a file's transfer functions exceed those of the rays, and the places compared.

    Raises InputError if a wavefront of the file is too steep to sample.

    Those of the rays are autocorrelations of the real, vignetted pupil, with the path lengths of the rays.
    """
    lens, disc = stated.of_wavelengths(CHECKED_NM), even_disc(CHECK_RAYS, RIM)
    beams = lens.beams([share * full_rad for share in CHECKED], disc)
    frequencies = np.array(CYCLES_PER_MM)
    differences = np.empty((len(CHECKED), len(CHECKED_NM), 2, frequencies.size))
    order = min(max(orders(index)[0] for index in found.zernike) + MORE, MOST_ORDER)
    middle_of = stated.of_wavelengths((stated.middle_nm,))
    chief = middle_of.beams([share * full_rad for share in CHECKED], np.empty((2, 0)))
    places_um = [min(1e3 * abs(float(at.chief_mm[0])), found.height_um[-1]) for at in chief]
    for k in reversed(range(len(CHECKED))):  # from the rim, where wavefronts are steepest
        beam, placed = beams[k], found.at(places_um[k], 0.0)
        for w, nm in enumerate(CHECKED_NM):
            share = np.maximum(beam.share[w], np.hypot(*disc))
            right = _transfers(beam.pupil[:, w], beam.path_mm[w], share, nm / 1e6, frequencies, order)
            per_um, none = frequencies / 1e3, 0.0 * frequencies
            try:
                one = np.stack([np.abs(placed.otf(per_um, none, nm)), np.abs(placed.otf(none, per_um, nm))])
            except UnsupportedError:
                smaller = f"a smaller field (--field-mm {places_um[k - 1] / 1e3:.4g}), " if k > 1 else ""
                raise InputError(
                    f"{name!r} has a wavefront {places_um[k] / 1e3:.4g} mm from the axis that is too steep at its "
                    f"pupil's rim to be sampled at {nm:g} nm; give it {smaller}a smaller pupil, or the surfaces that "
                    "cut light their apertures (CLAP 0 RADIUS)"
                ) from None
            differences[k, w] = one - right
    return differences, tuple(places_um)


def _transfers(pupil: F64, path_mm: F64, share: F64, wave_mm: float, per_mm: F64, order: int) -> F64:
    """Return sizes of transfers along x and across, at multiples of the first frequency.

    order : order of the polynomials that approximate the path

    From rays over the pupil and beyond its rim, where ``share`` exceeds 1. The frequencies shift the pupil by whole
    cells of a lattice; a cell at the rim counts by its open fraction.
    """
    known = np.isfinite(pupil[0] + path_mm + share)
    pupil, path_mm, share = pupil[:, known], path_mm[known], share[known]
    seen = share <= 1.0
    low, high = pupil[:, seen].min(axis=1), pupil[:, seen].max(axis=1)
    middle, half = 0.5 * (low + high)[:, None], 0.55 * (high - low)[:, None]
    shift = float(per_mm[0]) * wave_mm
    step = shift / math.ceil(shift / (CHECK_STEP * float(half.min())))
    x, y = np.meshgrid(*(np.arange(a, b, step) for a, b in zip(low - 2 * step, high + 2 * step, strict=True)))
    near = LinearNDInterpolator(pupil.T, share)(x, y)
    # In cells, from the rim inwards: in the overlap of two copies, the nearer rim counts.
    # Closed beyond all rays.
    inside = np.nan_to_num((1.0 - near) / np.maximum(np.hypot(*np.gradient(near)), 1e-9), nan=-9.0)
    there = inside > -1.0

    def rows(at: F64) -> F64:
        values: F64 = cosines(order, *((at - middle) / half))[1]
        return values

    phase = np.zeros(x.shape)
    coefficients = least_squares(rows(pupil[:, seen]), path_mm[seen])
    phase[there] = 2.0 * np.pi / wave_mm * (rows(np.stack([x[there], y[there]])) @ coefficients)
    area = np.clip(0.5 + inside, 0.0, 1.0).sum()
    sizes = np.zeros((2, per_mm.size))
    for k, (phases, deep) in enumerate(((phase, inside), (phase.T, inside.T))):
        for n, frequency in enumerate(per_mm.tolist()):
            by = round(frequency * wave_mm / step)
            first, second = slice(None, max(deep.shape[1] - by, 0)), slice(by, None)
            overlap = np.clip(0.5 + np.minimum(deep[:, first], deep[:, second]), 0.0, 1.0)
            sizes[k, n] = abs((overlap * np.exp(1j * (phases[:, first] - phases[:, second]))).sum()) / area
    return sizes
