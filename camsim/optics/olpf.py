"""Optical low-pass filter: birefringent plates split every ray."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.typed import NonNegative, judge, refusal


@dataclass(frozen=True, slots=True, kw_only=True)
class FourSpotOlpf:
    """Equal spots on the corners of a rectangle: two crossed plates, or one plate where a split is 0.

    split_um   : the full distance between two neighbouring spots along x, µm (never half of it)
    split_y_um : the same along y; None: as along x; 0: one plate, two spots
    rotate_deg : turns the spots clockwise as displayed

    >>> FourSpotOlpf(split_um=4.0).spots_um()
    array([[-2., -2.],
           [ 2., -2.],
           [-2.,  2.],
           [ 2.,  2.]])
    >>> FourSpotOlpf(split_um=4.0, split_y_um=0.0).spots_um()
    array([[-2.,  0.],
           [ 2.,  0.]])
    """

    place: ClassVar[str] = "olpf"

    split_um: NonNegative
    split_y_um: NonNegative | None = None
    rotate_deg: float = 0.0

    def __post_init__(self) -> None:
        judge(self)
        if self.split_um == 0.0 and self.split_down_um == 0.0:
            raise refusal(self, "split_um", "must be a number above 0, not 0; leave the OLPF out for no split at all")

    @property
    def split_down_um(self) -> float:
        """The distance between neighbouring spots along y before they are turned, µm."""
        return self.split_um if self.split_y_um is None else self.split_y_um

    @property
    def separable(self) -> bool:
        """Whether the transfer is a product of one function of fx and one of fy."""
        return self.rotate_deg == 0.0

    def spots_um(self) -> F64:
        """Return the offsets (2 or 4, 2) of the spots as x, y in µm; each carries the same light."""
        half_x, half_y = 0.5 * self.split_um, 0.5 * self.split_down_um
        across = [-half_x, half_x] if half_x else [0.0]
        down = [-half_y, half_y] if half_y else [0.0]
        spots = np.array([[x, y] for y in down for x in across])
        if self.rotate_deg == 0.0:
            return spots
        angle = math.radians(self.rotate_deg)
        turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        turned: F64 = spots @ turn
        return turned

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function cos(π·d·fx)·cos(π·d·fy), fx and fy along the splits; first zero at 1/(2d) along each."""
        angle = math.radians(self.rotate_deg)
        along = fx_per_um * math.cos(angle) + fy_per_um * math.sin(angle)
        across = fy_per_um * math.cos(angle) - fx_per_um * math.sin(angle)
        otf: F64 = np.cos(np.pi * self.split_um * along) * np.cos(np.pi * self.split_down_um * across)
        return otf
