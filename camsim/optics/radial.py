"""A lens given by its transfer function over radial frequency, the same at every wavelength."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
import scipy
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, Positive, Several, refusal, validate
from camsim.core.words import brief
from camsim.numerics.hankel import hankel
from camsim.optics.pattern import UNIT_NM, Pattern
from camsim.spectra.curve import NumberOrCurve, Transmission


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialOtf:
    """A lens with a rotationally symmetric PSF, given by its OTF at some radial frequencies.

    freq_per_um  : increasing from 0, cycles/µm
    values       : transfer there, signed, 1 at 0 and 0 at the last
    f_number     : sets the exposure only, not the blur
    transmission : fraction of the light that passes, a number or a curve over wavelength

    In between the curve is a monotone cubic (PCHIP, Fritsch and Carlson 1980), without overshoot or oscillation.

    >>> lens = RadialOtf(freq_per_um=(0.0, 0.1, 0.2), values=(1.0, 0.4, 0.0))
    >>> float(lens.otf(np.array(0.06), np.array(0.08), 550.0).round(12))
    0.4
    """

    place: ClassVar[str] = "lens"
    chromatic: ClassVar[bool] = False

    freq_per_um: Several[NonNegative]
    values: Several[Annotated[float, Ge(-1), Le(1)]]
    f_number: Positive = 8.0
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            freq_per_um: Several[Number],
            values: Several[Number],
            f_number: Number = 8.0,
            transmission: NumberOrCurve = 1.0,
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        frequency, values = self.freq_per_um, self.values
        if len(frequency) != len(values):
            message = f"there are {len(values)} for {len(frequency)} frequencies; every point has one of each"
            raise refusal(self, "values", message)
        if len(values) < 3:
            raise refusal(self, "values", f"{len(values)} points make no curve; give at least 3")
        if frequency[0] != 0.0 or any(after <= before for before, after in pairwise(frequency)):
            raise refusal(self, "freq_per_um", "must start at 0 and increase, each frequency given once")
        if values[0] != 1.0:
            raise refusal(self, "values", f"the first is {values[0]!r}; a lens passes 1 at frequency 0")
        if values[-1] != 0.0:
            message = f"the last is {values[-1]!r}; go on to the frequency where nothing passes, and give 0 there"
            raise refusal(self, "values", message)

    def pattern(self) -> Pattern:
        """Return the pattern for the boundary engine."""
        return _pattern(self)

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF, µm: the inverse of the last frequency."""
        return 1.0 / self.freq_per_um[-1]

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes, cycles/µm."""
        return self.freq_per_um[-1]

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm."""
        radius = np.hypot(fx_per_um, fy_per_um)
        inside = np.minimum(radius, self.freq_per_um[-1])
        otf: F64 = self.curve()(inside)
        return otf

    def curve(self) -> scipy.interpolate.PPoly:
        """Return the transfer over frequency (cycles/µm) as a piecewise cubic."""

        return scipy.interpolate.PchipInterpolator(self.freq_per_um, self.values)

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` (µm) from a point of unit power, 1/µm²: 2π ∫ OTF(f)·J0(2πfr)·f df."""
        return hankel(self.curve(), np.asarray(r_um, float), 0)

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` (µm) of the centre: 2πr ∫ OTF(f)·J1(2πfr) df."""
        r = np.asarray(r_um, float)
        energy: F64 = r * hankel(self.curve(), r, 1)
        return energy


@functools.cache
def _pattern(lens: RadialOtf) -> Pattern:
    """Return the pattern of a piecewise cubic transfer; the blur is the inverse of the last knot.

    A power uⁿ of the transfer at 0 contributes 2πρ·∫uⁿ·J1(2πuρ) du = 1/(2πρ) to E for n = 1, −3/(2πρ)³ for n = 3, and 0
    for even n. A jump J of the m-th derivative at u causes an oscillation of amplitude J/(π√(uρ)·(2πρ)^m), and an
    edge's end perpendicular to the line of sight has 1/(4π√(uρ)) of that.
    """
    last = lens.freq_per_um[-1]
    cubic = lens.curve()
    knots = cubic.x / last
    at_zero = cubic.c[::-1, 0] * last ** np.arange(4)
    rings = []
    for order in (1, 2, 3):
        slope = cubic.derivative(order)
        jumps = np.append(slope.c[-1, 1:], 0.0) - slope(cubic.x[1:] * (1.0 - 1e-12))
        for u, jump in zip(knots[1:], np.abs(jumps) * last**order, strict=True):
            if jump > 1e-9:
                rings.append((float(u), float(jump / (4.0 * math.pi**2 * u * (2.0 * math.pi) ** order)), order + 1.0))
    return Pattern(
        energy=lambda rho: lens.encircled_energy(rho / last, UNIT_NM),
        otf=lambda u: lens.otf(u * last, np.zeros(1), UNIT_NM),
        breaks=tuple(float(u) for u in knots[1:]),
        powers=(float(-at_zero[1] / (2.0 * math.pi)), float(3.0 * at_zero[3] / (2.0 * math.pi) ** 3), 0.0),
        rings=tuple(rings),
        signed=True,
        quiet=lambda allowed: max(5.0, 2.0 / float(knots[1])),
        finest=1e-7,
    )
