"""Lenses with a Gaussian PSF, circular or elliptical: the usual model when only an MTF50 is known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import Number, Positive, check, refusal, validate
from camsim.optics.pattern import Pattern, of_unit
from camsim.spectra.curve import NumberOrCurve, Transmission

HIGHEST = 1.37  # cycles per σ: exp(−2π²·1.37²) is 8e-17


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaussian:
    """A lens with a Gaussian PSF, the same at every wavelength.

    sigma_um     : standard deviation along each axis, µm
    f_number     : sets the exposure only, not the blur
    transmission : fraction of the light that passes, a number or a curve over wavelength

    >>> half = Gaussian.from_mtf50(0.25)  # cycles/µm
    >>> float(half.otf(np.array(0.25), np.array(0.0), 550.0).round(12))
    0.5
    """

    place: ClassVar[str] = "lens"
    fades: ClassVar[bool] = True
    chromatic: ClassVar[bool] = False

    sigma_um: Positive
    f_number: Positive = 8.0
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(self, *, sigma_um: Number, f_number: Number = 8.0, transmission: NumberOrCurve = 1.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def from_mtf50(cls, mtf50_per_um: Number) -> Gaussian:
        """Return the Gaussian whose transfer is one half at ``mtf50_per_um`` cycles/µm."""
        check(mtf50_per_um, Positive, "mtf50_per_um", cls.__name__)
        return cls(sigma_um=math.sqrt(math.log(2.0) / 2.0) / (math.pi * mtf50_per_um))

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF, µm: σ."""
        return self.sigma_um

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which less than 1e-16 passes, cycles/µm."""
        return HIGHEST / self.sigma_um

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return the radius beyond which ``lost_fraction`` of the light falls, µm."""
        return self.sigma_um * math.sqrt(-2.0 * math.log(lost_fraction))

    def pattern(self) -> Pattern:
        """Return the pattern for the boundary engine."""
        return _PATTERN

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` (µm) from a point of unit power, 1/µm²."""
        irradiance: F64 = np.exp(-0.5 * np.square(np.asarray(r_um, float) / self.sigma_um))
        irradiance /= 2.0 * math.pi * self.sigma_um**2
        return irradiance

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function exp(−2π²σ²f²) at (fx, fy) cycles/µm."""
        square = np.square(fx_per_um) + np.square(fy_per_um)
        otf: F64 = np.exp(-2.0 * (math.pi * self.sigma_um) ** 2 * square)
        return otf

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` (µm) of the centre: 1 − exp(−r²/2σ²)."""
        energy: F64 = -np.expm1(-0.5 * np.square(np.asarray(r_um, float) / self.sigma_um))
        return energy


@dataclass(frozen=True, slots=True, kw_only=True)
class EllipticalGaussian:
    """A lens with an elliptical Gaussian PSF in any direction, the same at every wavelength.

    covariance_um2 : ((xx, xy), (xy, yy)), µm²; positive definite
    f_number       : sets the exposure only, not the blur
    transmission   : fraction of the light that passes, a number or a curve over wavelength

    >>> lens = EllipticalGaussian.from_axes(sigma_um=3.0, sigma_across_um=1.0, rotate_deg=90.0)
    >>> np.array(lens.covariance_um2).round(12).tolist()
    [[1.0, 0.0], [0.0, 9.0]]
    """

    place: ClassVar[str] = "lens"
    chromatic: ClassVar[bool] = False
    fades: ClassVar[bool] = True

    covariance_um2: tuple[tuple[float, float], tuple[float, float]]
    f_number: Positive = 8.0
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            covariance_um2: tuple[tuple[Number, Number], tuple[Number, Number]],
            f_number: Number = 8.0,
            transmission: NumberOrCurve = 1.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        (xx, xy), (yx, yy) = self.covariance_um2
        if xy != yx or xx <= 0 or xx * yy <= xy * xy:
            message = "must be ((xx, xy), (xy, yy)) in µm² with xx and yy above 0 and xy² below xx·yy"
            raise refusal(self, "covariance_um2", f"{message}, not {self.covariance_um2!r}")

    @classmethod
    def from_axes(
        cls,
        *,
        sigma_um: Number,
        sigma_across_um: Number,
        rotate_deg: Number,
        f_number: Number = 8.0,
        transmission: NumberOrCurve = 1.0,
    ) -> EllipticalGaussian:
        """Return the Gaussian with standard deviations along two axes, the first turned clockwise from x."""
        sigma_um = check(sigma_um, Positive, "sigma_um", cls.__name__)
        sigma_across_um = check(sigma_across_um, Positive, "sigma_across_um", cls.__name__)
        rotate_deg = check(rotate_deg, float, "rotate_deg", cls.__name__)
        cos, sin = math.cos(math.radians(rotate_deg)), math.sin(math.radians(rotate_deg))
        a, b = sigma_um**2, sigma_across_um**2
        xy = (a - b) * cos * sin
        return cls(
            covariance_um2=((a * cos * cos + b * sin * sin, xy), (xy, a * sin * sin + b * cos * cos)),
            f_number=f_number,
            transmission=transmission,
        )

    @property
    def axes_um(self) -> tuple[float, float]:
        """The standard deviations along the principal axes, µm, the shorter one first."""
        (xx, xy), (_, yy) = self.covariance_um2
        middle, spread = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
        # The determinant over the larger one; a difference would cancel.
        return math.sqrt((xx * yy - xy * xy) / (middle + spread)), math.sqrt(middle + spread)

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF, µm: the shorter σ."""
        return self.axes_um[0]

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which less than 1e-16 passes in any direction, cycles/µm."""
        return HIGHEST / self.axes_um[0]

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius beyond which at most ``lost_fraction`` of the light falls, µm."""
        return self.axes_um[1] * math.sqrt(-2.0 * math.log(lost_fraction))

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function exp(−2π² f·C·f) at f = (fx, fy) cycles/µm."""
        (xx, xy), (_, yy) = self.covariance_um2
        form = xx * np.square(fx_per_um) + 2.0 * xy * np.multiply(fx_per_um, fy_per_um) + yy * np.square(fy_per_um)
        otf: F64 = np.exp(-2.0 * math.pi**2 * form)
        return otf


_ENERGY, _OTF = of_unit(Gaussian(sigma_um=1.0))
_PATTERN = Pattern(
    energy=_ENERGY,
    otf=_OTF,
    breaks=(1.37,),
    powers=(0.0, 0.0, 0.0),
    rings=(),
    signed=False,
    quiet=lambda allowed: math.sqrt(2.0 * math.log(1.0 / allowed)),
    finest=1e-9,
)
