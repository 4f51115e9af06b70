"""A lens with aberrations at one place of the frame: path differences over a circular pupil, by wavelength."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, runtime_checkable

import numpy as np

from camsim.core.arrays import F64
from camsim.numerics.splines import spline
from camsim.numerics.zernike import orders, zernike_sum
from camsim.optics.airy import NM_PER_UM
from camsim.optics.of_pupil import ACROSS, OfPupil
from camsim.optics.protocols import Varies
from camsim.optics.pupil import Pupil

TILTS = 2  # OSA indices up to this one are piston and tilts
STEPS = 6  # wavelengths between which the path difference is assumed to be monotonic


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedLens(OfPupil):
    """A field-varying lens at one place of the frame.

    wavelength_nm : (w,) increasing
    zernike       : (k,) OSA/ANSI indices
    path_nm       : (w, k) root mean square path difference of each at each wavelength, nm; interpolated by a spline

    Signs and directions as in ``Wavefront``.
    """

    f_number: float
    wavelength_nm: tuple[float, ...]
    zernike: tuple[int, ...]
    path_nm: tuple[tuple[float, ...], ...]
    pupil: Pupil

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of D/2."""
        return zernike_sum(self.zernike, _waves(self, wavelength_nm), x, y)

    def coefficients(self, wavelength_nm: F64) -> F64:
        """Return the coefficients (n, k) at wavelengths, waves."""
        waves: F64 = _spline(self)(wavelength_nm) / wavelength_nm[:, None]
        return waves

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """Return the change of the path difference over the pupil between two wavelengths, in waves."""
        x, y, _ = self.pupil.nodes(ACROSS, ACROSS)
        each = [self.waves(x, y, float(nm)) for nm in np.linspace(low_nm, high_nm, STEPS)]
        return float(sum(np.ptp(after - before) for before, after in pairwise(each)))

    def waves_rms(self, wavelength_nm: float) -> float:
        """Return the root mean square of the path difference over the pupil in waves, without piston and tilt."""
        path = _spline(self)(wavelength_nm)
        displayed = [p for index, p in zip(self.zernike, path, strict=True) if index > TILTS]
        return math.hypot(*displayed) / wavelength_nm

    @property
    def _symmetric(self) -> bool:
        """Whether the PSF is symmetric under rotation by 180°, so that its transfer is real."""
        return all(
            orders(index)[0] % 2 == 0
            for index, paths in zip(self.zernike, zip(*self.path_nm, strict=True), strict=True)
            if any(paths)
        )


@runtime_checkable
class Revolves(Varies, Protocol):
    """A lens of revolution, given along one radius; its pupil is circular, without an obstruction."""

    @property
    def f_number(self) -> float: ...  # noqa: D102 (above)

    @property
    def turns(self) -> bool:
        """Whether it is a lens of revolution."""
        ...

    @property
    def height_um(self) -> Sequence[float]:
        """Heights along the radius at which it is given; splines in between."""
        ...

    @property
    def wavelength_nm(self) -> Sequence[float]:
        """Wavelengths at which it is given; splines in between."""
        ...

    def at(self, x_um: float, y_um: float) -> PlacedLens:
        """Return the lens for a photosite at a place."""
        ...


@functools.lru_cache(maxsize=4096)
def _waves(lens: PlacedLens, wavelength_nm: float) -> tuple[float, ...]:
    """Return the coefficients at a wavelength, waves."""
    return tuple(lens.coefficients(np.array([wavelength_nm]))[0].tolist())


@functools.lru_cache(maxsize=1024)
def _spline(lens: PlacedLens) -> Callable[..., F64]:
    """Return the path differences (k,) as a function of the wavelength."""
    return spline(lens.wavelength_nm, np.array(lens.path_nm).reshape(len(lens.wavelength_nm), -1))


def defocus_nm(focus_um: float, f_number: float) -> float:
    """Return the coefficient of Zernike 4 that a focus shift adds, nm: δ/(8N²)·r² is δ/(16√3·N²)·Z₄ and a constant."""
    return focus_um * NM_PER_UM / (16.0 * math.sqrt(3.0) * f_number**2)
