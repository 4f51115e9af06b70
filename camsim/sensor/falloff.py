"""Light that falls off towards the corners: cos⁴ and vignetting, on the mean."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.sensor.checked import check_number, check_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Cos4Falloff:
    """The natural fall-off of a lens without vignetting: cos⁴ of the angle under which the exit pupil is seen.

    exit_pupil_mm : distance from the sensor to the exit pupil; for a lens focused far away and symmetric, its focal
                    length

    >>> Cos4Falloff(exit_pupil_mm=20.0).relative(np.array([0.0, 20.0]))
    array([1.  , 0.25])
    """

    exit_pupil_mm: float

    def __post_init__(self) -> None:
        check_positive("Cos4Falloff", "exit_pupil_mm", self.exit_pupil_mm)

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
    """

    radius_mm: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius_mm", tuple(float(r) for r in self.radius_mm))
        object.__setattr__(self, "values", tuple(float(v) for v in self.values))
        if len(self.radius_mm) != len(self.values) or len(self.values) < 2:
            raise InvalidValueError(
                f"{len(self.values)} for {len(self.radius_mm)} of radius_mm; give two or more of each",
                key="values",
                stage="RadialFalloff",
            )
        for radius in self.radius_mm:
            check_number("RadialFalloff", "radius_mm", radius)
        if self.radius_mm[0] != 0.0 or any(after <= before for before, after in pairwise(self.radius_mm)):
            raise InvalidValueError(
                f"{list(self.radius_mm)}; must begin at 0 and increase", key="radius_mm", stage="RadialFalloff"
            )
        for value in self.values:
            check_number("RadialFalloff", "values", value, largest=1.0)
        if self.values[0] != 1.0:
            raise InvalidValueError(
                f"{list(self.values)}; must begin with 1, the light on the axis", key="values", stage="RadialFalloff"
            )

    def relative(self, radius_mm: F64) -> F64:
        """Return the light at a distance from the axis, relative to that on the axis."""
        relative: F64 = np.interp(radius_mm, self.radius_mm, self.values)
        return relative


Falloff: TypeAlias = Cos4Falloff | RadialFalloff


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
    if not (math.isfinite(magnification) and 0.0 <= magnification <= 100.0):
        raise InvalidValueError(f"{magnification}; must be 0 (far away) to 100", key="magnification")
    return f_number * (1.0 + magnification)
