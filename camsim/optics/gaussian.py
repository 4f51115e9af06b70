"""A lens whose pattern is a round Gaussian: the usual stand-in when only an MTF50 is known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaussian:
    """A lens with a Gaussian pattern, the same at every wavelength.

    sigma_um     : standard deviation along each axis, µm
    f_number     : sets the exposure only, not the blur
    transmission : fraction of the light that passes, a number or a curve over wavelength

    >>> half = Gaussian.from_mtf50(0.25)  # cycles/µm
    >>> float(half.otf(np.array(0.25), np.array(0.0), 550.0).round(12))
    0.5
    """

    place: ClassVar[str] = "lens"
    fades: ClassVar[bool] = True

    sigma_um: float
    f_number: float = 8.0
    transmission: Spectrum = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.sigma_um) and self.sigma_um > 0):
            raise InvalidValueError(f"sigma_um: {self.sigma_um!r} is not a standard deviation; give µm above 0")
        if not (math.isfinite(self.f_number) and self.f_number > 0):
            raise InvalidValueError(f"f_number: {self.f_number!r} is not a lens; give a finite number above 0")

    @classmethod
    def from_mtf50(cls, mtf50_per_um: float) -> Gaussian:
        """Return the Gaussian whose transfer is one half at ``mtf50_per_um`` cycles/µm."""
        return cls(sigma_um=math.sqrt(math.log(2.0) / 2.0) / (math.pi * mtf50_per_um))

    def blur_um(self, wavelength_nm: float) -> float:
        """The pattern's own length, µm: σ."""
        return self.sigma_um

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function exp(−2π²σ²f²) at (fx, fy) cycles/µm."""
        square = np.square(fx_per_um) + np.square(fy_per_um)
        otf: F64 = np.exp(-2.0 * (math.pi * self.sigma_um) ** 2 * square)
        return otf

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` (µm) of the centre: 1 − exp(−r²/2σ²)."""
        energy: F64 = -np.expm1(-0.5 * np.square(np.asarray(r_um, float) / self.sigma_um))
        return energy
