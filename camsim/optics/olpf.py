"""Optical low-pass filter: two birefringent plates split every ray into four."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError


@dataclass(frozen=True, slots=True, kw_only=True)
class FourSpotOlpf:
    """Four equal spots on the corners of a square with sides along x and y.

    split_um : the full distance between two neighbouring spots, µm (never half of it)

    >>> FourSpotOlpf(split_um=4.0).spots_um()
    array([[-2., -2.],
           [ 2., -2.],
           [-2.,  2.],
           [ 2.,  2.]])
    """

    place: ClassVar[str] = "olpf"
    separable: ClassVar[bool] = True

    split_um: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.split_um) and self.split_um > 0):
            raise InvalidValueError(
                f"split_um: {self.split_um!r} is not a distance between spots; give µm above 0, or leave the OLPF out"
            )

    def spots_um(self) -> F64:
        """Return the offsets (4, 2) of the spots as x, y in µm; each carries a quarter of the light."""
        half = 0.5 * self.split_um
        return np.array([[-half, -half], [half, -half], [-half, half], [half, half]])

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function cos(π·d·fx)·cos(π·d·fy); first zero at 1/(2d) along each axis."""
        otf: F64 = np.cos(np.pi * self.split_um * fx_per_um) * np.cos(np.pi * self.split_um * fy_per_um)
        return otf
