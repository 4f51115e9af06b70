"""A diffraction-limited lens with a circular aperture: the Airy pattern of every wavelength."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import Number, Positive, validate
from camsim.numerics.bessel import bessel_j0_j1, jinc
from camsim.optics.pattern import POWERS, RING, SEVENTH, Pattern, of_unit
from camsim.spectra.curve import NumberOrCurve, Transmission

NM_PER_UM = 1e3


def airy_otf(freq_per_um: F64, *, f_number: float, wavelength_nm: float) -> F64:
    """OTF of an aberration-free circular pupil in incoherent light.

    freq_per_um : (...) radial frequency at the sensor, cycles/µm
    returns     : (...) 1 at zero, exactly 0 past 1/(λN)

    Source: Goodman, Introduction to Fourier Optics, eq. 6-30 (the overlap of two circles).

    >>> airy_otf(np.array([0.0, 0.5, 1.0]) * 1e3 / (550 * 8), f_number=8.0, wavelength_nm=550.0).round(4)
    array([1.   , 0.391, 0.   ])
    """
    u = np.minimum(np.abs(freq_per_um) * (f_number * wavelength_nm / NM_PER_UM), 1.0)
    otf: F64 = (2.0 / np.pi) * (np.arccos(u) - u * np.sqrt((1.0 - u) * (1.0 + u)))
    return otf


class DiffractionLimit:
    """Mixin of lenses with an ``f_number``. It has no fields."""

    __slots__ = ()

    f_number: float

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF without aberrations, µm: λN, wavelength × f-number."""
        return self.f_number * wavelength_nm / NM_PER_UM

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, 1/(λN), cycles/µm."""
        return 1.0 / self.blur_um(wavelength_nm)


@dataclass(frozen=True, slots=True, kw_only=True)
class Airy(DiffractionLimit):
    """A diffraction-limited lens.

    f_number     : focal length over aperture diameter, dimensionless
    transmission : fraction of the light that passes, a number or a curve over wavelength

    >>> round(Airy(f_number=8.0).cutoff_per_um(550.0), 4)
    0.2273
    >>> first_dark_ring_um = 1.2196698912665045 * 0.55 * 8
    >>> float(Airy(f_number=8.0).encircled_energy(np.array(first_dark_ring_um), 550.0).round(4))
    0.8378
    """

    place: ClassVar[str] = "lens"

    f_number: Positive
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(self, *, f_number: Number, transmission: NumberOrCurve = 1.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def pattern(self) -> Pattern:
        """Return the pattern for the boundary engine."""
        return AIRY

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius beyond which at most ``lost_fraction`` of the light falls, µm.

        The light beyond r is J0² + J1² ≤ (2/πx)(1 + 1/(2x)), x = πr/(λN).
        """
        return self.blur_um(wavelength_nm) * (4.0 / (math.pi**2 * lost_fraction) + 1.0)

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` (µm) from a point of unit power, 1/µm²: π/(λN)²·(J1(x)/x)², x = πr/(λN)."""
        blur_um = self.blur_um(wavelength_nm)
        irradiance: F64 = math.pi / blur_um**2 * jinc((math.pi / blur_um) * np.asarray(r_um, float)) ** 2
        return irradiance

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm; real, because the PSF is symmetric."""
        return airy_otf(np.hypot(fx_per_um, fy_per_um), f_number=self.f_number, wavelength_nm=wavelength_nm)

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` of the centre: 1 − J0²(x) − J1²(x), x = πr/(λN) (Rayleigh, 1881)."""
        j0, j1 = bessel_j0_j1(np.pi * np.asarray(r_um, float) / self.blur_um(wavelength_nm))
        energy: F64 = 1.0 - j0**2 - j1**2
        return energy


_ENERGY, _OTF = of_unit(Airy(f_number=1.0))
AIRY = Pattern(
    energy=_ENERGY,
    otf=_OTF,
    breaks=(1.0,),
    powers=POWERS,  # DLMF 10.18.17
    rings=((1.0, RING, 2.5),),
    signed=False,
    quiet=lambda allowed: max(5.0, (SEVENTH / allowed) ** (1.0 / 7.0)),
    finest=1e-11,
)
