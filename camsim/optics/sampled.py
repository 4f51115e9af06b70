"""Fast OTFs of lenses with aberrations: the pupil function's autocorrelation on a lattice, interpolated.

``OfPupil.otf`` integrates over the overlap of two pupils at every frequency, to 1e-11. For curves with three or four
digits, one autocorrelation by FFT gives all frequencies and directions of a wavelength.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.core.arrays import C128, F64
from camsim.core.custom import is_custom
from camsim.optics.of_pupil import OfPupil
from camsim.optics.protocols import OpticalStage, Varies
from camsim.optics.pupil import Pupil

ACROSS, PER_EXTENT = 128, 5.0  # points across a pupil: at least, and per λN of the PSF's extent; error 5e-4
SLOPES = 32  # points across a pupil for differences of the wavefront
MOST_ACROSS = 2048  # a gigabyte
FLAT_ACROSS = 1024  # for a polygon without aberrations, once for all wavelengths: error 3e-4
COVERED = 8  # parts along a side of cells that the outline cuts
SMALL_ACROSS = 512  # up to 8 MB each are cached


def sampled_otf(lens: OpticalStage, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64 | C128:
    """Return ``lens.otf`` at (fx, fy) cycles/µm, of any shape, with an error of 1e-3 but in milliseconds.

    ``lens.otf`` itself is used for lenses without a pupil integral, and for wavefronts too steep for a lattice.
    A field-varying lens is evaluated on its axis; use ``lens.at(x_um, y_um)`` for another place.

    >>> from camsim.optics import Wavefront
    >>> coma = Wavefront(f_number=4.0, zernike_waves={8: 0.1})
    >>> f = np.array([0.0, 0.1, 0.2])
    >>> np.abs(sampled_otf(coma, f, 0.0 * f, 550.0)).round(3), np.abs(coma.otf(f, 0.0 * f, 550.0)).round(3)
    (array([1.   , 0.427, 0.228]), array([1.   , 0.427, 0.228]))
    """
    if isinstance(lens, Varies) and not is_custom(lens):
        lens = lens.at(0.0, 0.0)
    if is_custom(lens) or not isinstance(lens, OfPupil):
        return lens.otf(fx_per_um, fy_per_um, wavelength_nm)
    tilt, extent = _tilt_and_extent(lens, wavelength_nm)
    count = scipy.fft.next_fast_len(math.ceil(lens.pupil.outer_radius * max(ACROSS, PER_EXTENT * extent)))
    if count > MOST_ACROSS:
        return lens.otf(fx_per_um, fy_per_um, wavelength_nm)
    fx, fy = np.broadcast_arrays(np.asarray(fx_per_um, float), np.asarray(fy_per_um, float))
    otf = np.zeros(fx.shape, complex)
    inside = np.hypot(fx, fy) < lens.cutoff_per_um(wavelength_nm)
    fx, fy = fx[inside], fy[inside]
    shift = 2.0 * lens.blur_um(wavelength_nm)  # of the pupil per cycle/µm, in half diameters
    bent = (_small if count <= SMALL_ACROSS else _large)(lens, wavelength_nm, count)
    moved = np.exp(-2j * np.pi * shift * (tilt[0] * fx + tilt[1] * fy))
    otf[inside] = moved * (bent(shift * fx, shift * fy) + _flat_otf(lens, fx, fy, wavelength_nm))
    return otf.real.copy() if lens._symmetric else otf


@functools.lru_cache(maxsize=1024)
def _tilt_and_extent(lens: OfPupil, wavelength_nm: float) -> tuple[tuple[float, float], float]:
    """Return the wavefront's mean slopes, waves per half diameter, and the PSF's extent without them, λN.

    A slope of one wave per half diameter displaces a ray by 2λN.
    """
    place, step = _places(lens.pupil, SLOPES)
    x, y = np.meshgrid(place, place)
    inside = lens.pupil.holds(x, y)
    slopes: list[F64] = list(np.gradient(lens.waves(x, y, wavelength_nm), step))
    slope_y, slope_x = (slope[inside] for slope in slopes)
    tilt = float(slope_x.mean()), float(slope_y.mean())
    return tilt, 2.0 * float(np.hypot(slope_x - tilt[0], slope_y - tilt[1]).max())


class _Lattice(NamedTuple):
    """An autocorrelation as coefficients of a periodic spline; step: of shifts, half diameters."""

    coefficients: np.ndarray
    step: float

    def __call__(self, sx: F64, sy: F64) -> F64 | C128:
        places = [sy / self.step, sx / self.step]
        found: F64 | C128 = scipy.ndimage.map_coordinates(
            self.coefficients, places, order=5, prefilter=False, mode="grid-wrap"
        )
        return found


def _bent(lens: OfPupil, wavelength_nm: float, count: int) -> _Lattice:
    """Return the autocorrelation with the wavefront (without its tilt) minus that without it.

    Both have the same cusp at 0, and the same errors at the rim: their difference has neither.
    """
    place, step = _places(lens.pupil, count)
    covered = _covered(lens.pupil, count)
    inside = covered > 0.0
    rows, columns = np.nonzero(inside)
    x, y = place[columns], place[rows]
    (slope_x, slope_y), _ = _tilt_and_extent(lens, wavelength_nm)
    amplitude = np.zeros((count, count), complex)
    phase = 2.0 * np.pi * (lens.waves(x, y, wavelength_nm) - slope_x * x - slope_y * y)
    amplitude[inside] = covered[inside] * np.exp(1j * phase)
    return _spline(_power(amplitude) - _flat_power(lens.pupil, count), lens.pupil, step)


_small = functools.lru_cache(maxsize=64)(_bent)
_large = functools.lru_cache(maxsize=4)(_bent)


def _spline(power: F64, pupil: Pupil, step: float) -> _Lattice:
    """Return the spline coefficients of an autocorrelation from its transform, divided by that of the spline."""
    turn = 2.0 * np.pi * np.arange(len(power)) / len(power)
    one = (66.0 + 52.0 * np.cos(turn) + 2.0 * np.cos(2.0 * turn)) / 120.0  # quintic B-spline: 66, 26, 1 over 120
    scale = step * step / (pupil.area * power.size)
    # The pupil function is paired with its conjugate a shift further on: the transform with the other sign.
    return _Lattice(scipy.fft.fft2((power * scale / one / one[:, None]).astype(np.float32)), step)


def _flat_otf(lens: OfPupil, fx: F64, fy: F64, wavelength_nm: float) -> F64 | C128:
    """Return the transfer without aberrations."""
    if lens.pupil.shape == "circular":
        return lens.round_core().otf(fx, fy, wavelength_nm)
    shift = 2.0 * lens.blur_um(wavelength_nm)
    return _polygon(lens.pupil)(shift * fx, shift * fy)


@functools.lru_cache(maxsize=4)
def _polygon(pupil: Pupil) -> _Lattice:
    step, power = _places(pupil, FLAT_ACROSS)[1], _flat_power(pupil, FLAT_ACROSS)
    missing = pupil.area / (step * step) - power.mean()  # at no shift: cells on the outline count less when squared
    return _spline(power + missing, pupil, step)


@functools.lru_cache(maxsize=4)
def _flat_power(pupil: Pupil, count: int) -> F64:
    return _power(_covered(pupil, count))


def _power(amplitude: F64 | C128) -> F64:
    """Return the power spectrum of an amplitude, zero-padded to twice its size."""
    rows = scipy.fft.fft(amplitude.astype(np.complex64), 2 * len(amplitude), axis=1)
    power: F64 = np.abs(scipy.fft.fft(rows, 2 * len(amplitude), axis=0)) ** 2
    return power


@functools.lru_cache(maxsize=4)
def _covered(pupil: Pupil, count: int) -> F64:
    """Return the fraction of each cell of a lattice that lies in the pupil."""
    place, step = _places(pupil, count)
    corner = np.append(place - 0.5 * step, place[-1] + 0.5 * step)
    held = pupil.holds(*np.meshgrid(corner, corner))
    corners = np.stack([held[:-1, :-1], held[1:, :-1], held[:-1, 1:], held[1:, 1:]])
    covered = corners.all(axis=0).astype(float)
    rows, columns = np.nonzero(corners.any(axis=0) != corners.all(axis=0))
    x, y = np.meshgrid(*2 * [step * ((np.arange(COVERED) + 0.5) / COVERED - 0.5)])
    parts = pupil.holds(place[columns, None] + x.ravel(), place[rows, None] + y.ravel())
    covered[rows, columns] = parts.mean(axis=1)
    return covered


def _places(pupil: Pupil, count: int) -> tuple[F64, float]:
    """Return the centres of cells across the pupil, and their spacing, half diameters."""
    step = 2.0 * pupil.outer_radius / count
    middles: F64 = step * (np.arange(count, dtype=np.float64) + 0.5) - pupil.outer_radius
    return middles, step
