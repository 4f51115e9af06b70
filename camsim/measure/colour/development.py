"""The development that a file states: its white balance and matrix, as raw developers use them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from camsim.core.arrays import F64
from camsim.measure.picture import Picture
from camsim.sensor.colour_matrix import XYZ_D50, adaptation, fit_white

GREYS = slice(18, 24)
"""Greys of a ColorChecker: white, four greys and black."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Development:
    """White balance and colour matrix of a development.

    neutral : (3,) response to white, by which channels are divided
    to_xyz  : (3, 3) from balanced channels to XYZ under D50; 1, 1, 1 becomes white
    by_greys : whether the white balance is from the chart, as the file states none
    """

    neutral: F64
    to_xyz: F64
    by_greys: bool = False

    def xyz(self, means: F64) -> F64:
        """Return (n, 3) XYZ under D50 of red, green and blue (n, 3)."""
        seen: F64 = (means / self.neutral) @ self.to_xyz.T
        return seen

    def scaled(self, means: F64, greys: F64) -> Development:
        """Return the development scaled so that a chart's patches (24, 3) match the known brightness of its greys (6,).

        So exposure does not count as an error of colour.
        """
        return replace(self, neutral=self.neutral * (self.xyz(means)[GREYS, 1].sum() / greys.sum()))


def development_of(picture: Picture, means: F64) -> Development | None:
    """Return the development stated by a maker's raw file or a DNG; None if it states no matrix.

    means : (24, 3) of the chart's patches, whose greys give the white balance if the file states none
    """
    noted = picture.noted
    if noted is None or len(noted.xyz_to_camera) < 3:
        return None
    to_camera = np.array(noted.xyz_to_camera[:3], np.float64)
    white = fit_white("D65")
    displayed = to_camera @ white
    if not displayed.min() > 0.0 or abs(np.linalg.det(to_camera)) < 1e-9:
        return None
    to_xyz: F64 = adaptation(white, XYZ_D50) @ np.linalg.inv(to_camera / displayed[:, None])
    if len(noted.white_balance) < 3:
        return Development(neutral=means[GREYS].sum(axis=0), to_xyz=to_xyz, by_greys=True)
    return Development(neutral=1.0 / np.array(noted.white_balance[:3], np.float64), to_xyz=to_xyz)
