"""Optical stages of one's own, as docs/developers.md has them: one for every place of a camera."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

import camsim


@dataclass(frozen=True, kw_only=True)
class Blurred:
    """A diffraction-limited lens behind a round Gaussian haze."""

    place: ClassVar = "lens"

    sigma_um: float
    f_number: float = 8.0
    transmission: float = 0.9

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        haze = np.exp(-2.0 * (np.pi * self.sigma_um) ** 2 * (np.square(fx_per_um) + np.square(fy_per_um)))
        return haze * camsim.Airy(f_number=self.f_number).otf(fx_per_um, fy_per_um, wavelength_nm)

    def cutoff_per_um(self, wavelength_nm):
        return camsim.Airy(f_number=self.f_number).cutoff_per_um(wavelength_nm)


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A camera that moved evenly along x while it exposed."""

    length_um: float

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return np.sinc(self.length_um * np.asarray(fx_per_um)) * np.ones_like(fy_per_um)


@dataclass(frozen=True, kw_only=True)
class SixSpotOlpf:
    """Six spots on a circle."""

    place: ClassVar = "olpf"

    radius_um: float

    def spots_um(self):
        angle = np.arange(6) * np.pi / 3.0
        return self.radius_um * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        phase = np.multiply.outer(fx_per_um, self.spots_um()[:, 0]) + np.multiply.outer(
            fy_per_um, self.spots_um()[:, 1]
        )
        return np.cos(2.0 * np.pi * phase).mean(axis=-1)


@dataclass(frozen=True, kw_only=True)
class Diamond:
    """A square photosite that stands on a corner."""

    place: ClassVar = "photosite"

    half_um: float

    @property
    def area_um2(self):
        return 2.0 * self.half_um**2

    @property
    def half_extent_um(self):
        return self.half_um, self.half_um

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        fx, fy = np.asarray(fx_per_um), np.asarray(fy_per_um)
        return np.sinc(self.half_um * (fx + fy)) * np.sinc(self.half_um * (fx - fy))


OWN_OPTICS = {
    "a lens of one's own": Blurred(sigma_um=1.0),
    "a blur of one's own": Motion(length_um=3.0),
    "an OLPF of one's own": SixSpotOlpf(radius_um=1.5),
    "a photosite of one's own": Diamond(half_um=2.0),
}
