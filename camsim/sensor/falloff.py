"""Relative illumination over the frame: cos⁴ and vignetting, applied to the mean."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import Fraction, NonNegative, Number, Positive, Several, check, refusal, validate
from camsim.core.words import brief


@dataclass(frozen=True, slots=True, kw_only=True)
class Cos4Falloff:
    """The natural fall-off of a lens without vignetting: cos⁴ of the angle under which the exit pupil is seen.

    exit_pupil_mm : distance from the sensor to the exit pupil; for a lens focused far away and symmetric, its focal
                    length

    >>> Cos4Falloff(exit_pupil_mm=20.0).relative(np.array([0.0, 20.0]))
    array([1.  , 0.25])
    """

    exit_pupil_mm: Positive

    if TYPE_CHECKING:

        def __init__(self, *, exit_pupil_mm: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def relative(self, radius_mm: F64) -> F64:
        """Return the light at a distance from the axis, relative to that on the axis."""
        squared_cosine = 1.0 / (1.0 + (radius_mm / self.exit_pupil_mm) ** 2)
        relative: F64 = squared_cosine**2
        return relative


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialFalloff:
    """A measured fall-off, cos⁴ and vignetting together: straight between its points, held beyond.

    radius_mm : (n,) distances from the optical axis on the sensor, increasing, the first 0
    values    : (n,) light there relative to the axis, fractions; the first is 1

    >>> RadialFalloff(radius_mm=[0.0, 10.0], values=[1.0, 0.6])
    RadialFalloff(radius_mm=(0.0, 10.0), values=(1.0, 0.6))
    """

    radius_mm: Several[NonNegative]
    values: Several[Fraction]

    if TYPE_CHECKING:

        def __init__(self, *, radius_mm: Several[Number], values: Several[Number]) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if len(self.radius_mm) != len(self.values) or len(self.values) < 2:
            message = f"{len(self.values)} for {len(self.radius_mm)} of radius_mm; give two or more of each"
            raise refusal(self, "values", message)
        if self.radius_mm[0] != 0.0 or any(after <= before for before, after in pairwise(self.radius_mm)):
            raise refusal(self, "radius_mm", f"{list(self.radius_mm)}; must begin at 0 and increase")
        if self.values[0] != 1.0:
            raise refusal(self, "values", f"{list(self.values)}; must begin with 1, the light on the axis")

    def relative(self, radius_mm: F64) -> F64:
        """Return the light at a distance from the axis, relative to that on the axis."""
        relative: F64 = np.interp(radius_mm, self.radius_mm, self.values)
        return relative


Falloff: TypeAlias = Cos4Falloff | RadialFalloff

Magnification: TypeAlias = Annotated[float, Ge(0), Le(100)]
"""Image size over object size; 0: far away."""


def falloff_at(falloff: Falloff, *, shape: tuple[int, int], first_centre: tuple[float, float], pitch_um: float) -> F64:
    """Return (rows, cols) of a window's relative light.

    first_centre : x, y of its first photosite in pitches from the optical axis
    """
    x = first_centre[0] + np.arange(shape[1])
    y = first_centre[1] + np.arange(shape[0])
    radius_mm = np.hypot(x[None, :], y[:, None])
    radius_mm *= pitch_um / 1e3
    return falloff.relative(radius_mm)


def working_f_number(f_number: float, magnification: float) -> float:
    """Return N·(1 + m), m the magnification (image size over object size) of a lens with pupils of equal size.

    >>> working_f_number(4.0, 1.0)
    8.0
    """
    check(magnification, Magnification, "magnification")
    return f_number * (1.0 + magnification)
