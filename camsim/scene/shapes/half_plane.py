"""Everything on one side of a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.typed import Number, Place, Point
from camsim.scene.curves import Curves, through
from camsim.scene.primitives import Outlined, turned
from camsim.spectra.curve import NumberOrCurve, Reflectance

REACH_UM = 1e10
"""Its extent: behind an f/8 lens less than 1e-10 of the light comes from beyond."""

STEP = 100.0  # ratio of distances at which its line is cut, for accuracy near the frame
FIRST_UM = 1e4


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfPlane(Outlined):
    """Everything on one side of a line, to a distance of 10 km.

    through_um  : a point of the line
    towards_deg : direction from the line into the half-plane, square to the line, clockwise as displayed from the right

    >>> HalfPlane(through_um=(0.0, 0.0), towards_deg=5.0, reflectance=0.05)
    HalfPlane(through_um=(0.0, 0.0), towards_deg=5.0, reflectance=0.05)
    """

    pieces: ClassVar[int] = 11

    through_um: Point = (0.0, 0.0)
    towards_deg: float = 0.0
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self, *, through_um: Place = (0.0, 0.0), towards_deg: Number = 0.0, reflectance: NumberOrCurve
        ) -> None: ...

    def _outline(self) -> Curves:
        """Return its outline: a square of which the line is one side."""
        count = int(np.ceil(np.log(REACH_UM / FIRST_UM) / np.log(STEP)))
        away = np.minimum(FIRST_UM * STEP ** np.arange(count + 1), REACH_UM)
        along = np.concatenate([-away[::-1], away])
        line = np.stack([np.zeros_like(along), along], axis=1)
        far = np.array([[2.0 * REACH_UM, REACH_UM], [2.0 * REACH_UM, -REACH_UM]])
        corners = np.array(self.through_um) + turned(np.concatenate([line, far]), self.towards_deg)
        return through(corners)
