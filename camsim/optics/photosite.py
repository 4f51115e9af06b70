"""The light-sensitive area of a pixel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError


@dataclass(frozen=True, slots=True, kw_only=True)
class SquarePhotosite:
    """A square that collects light evenly, sides along x and y; ``side_um`` 0 is a point sample.

    >>> SquarePhotosite.from_fill_factor(pitch_um=4.0, fill_factor=0.25).side_um
    2.0
    """

    place: ClassVar[str] = "photosite"
    separable: ClassVar[bool] = True

    side_um: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.side_um) and self.side_um >= 0):
            raise InvalidValueError(f"side_um: {self.side_um!r} is not the side of a photosite; give µm, 0 or above")

    @classmethod
    def from_fill_factor(cls, *, pitch_um: float, fill_factor: float) -> SquarePhotosite:
        """Return the square whose area is ``fill_factor`` (0..1) of the pitch squared."""
        if not 0.0 < fill_factor <= 1.0:
            raise InvalidValueError(
                f"fill_factor: {fill_factor!r} is outside 0..1 (a fraction of the pitch's area; 0.6 means 60 %)"
            )
        return cls(side_um=pitch_um * math.sqrt(fill_factor))

    @property
    def half_extent_um(self) -> tuple[float, float]:
        """How far it reaches from its centre along x and y, µm."""
        return 0.5 * self.side_um, 0.5 * self.side_um

    @property
    def sides_um(self) -> tuple[float, float]:
        """Width and height, µm."""
        return self.side_um, self.side_um

    @property
    def area_um2(self) -> float:
        """Light-collecting area, µm²."""
        return self.side_um * self.side_um

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function sinc(w·fx)·sinc(w·fy), the same at every wavelength."""
        otf: F64 = np.sinc(self.side_um * fx_per_um) * np.sinc(self.side_um * fy_per_um)
        return otf
