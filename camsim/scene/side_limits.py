"""Limits of the sides of polygons that approximate curved outlines."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import InvalidValueError

ROUGH_TURN = 2.0 * math.pi / 64.0
"""Turn of a side for display only, radians: it deviates by a thousandth of the radius."""

MOST_SIDES = 20_000_000  # most sides of all curves
NEARLY_STRAIGHT = 1e200  # a radius, µm: products of larger ones overflow


class SideLimits(NamedTuple):
    """Limits of a side's length s where a curve's radius is R.

    segment_um : largest length
    wobble_um  : root-mean-square distance between side and curve: s²/(R·√720), the parabola s²/8R less its mean
    cut_um2    : area between them that no other side compensates: s³/24R at a corner, which is kept in place, and
                 s³/(72·√3·R) over a part of a side where another shape cuts the outline. The first is used for both: an
                 arc then has the sides of its circle
    moment_um3 : moment that remains where the next side is longer or shorter: s⁴/96R
    off_um     : distance between them that is always negligible: s²/12R, with ends slightly outside
    turn_rad   : turn of the curve over a side
    longer_um  : radii (k,) and lengths there, which replace ``segment_um`` where longer
    textured   : pictures are behind the outlines, whose sample edges may cut them anywhere
    """

    segment_um: float = math.inf
    wobble_um: float = math.inf
    cut_um2: float = math.inf
    moment_um3: float = math.inf
    off_um: float = 0.0
    turn_rad: float = ROUGH_TURN
    longer_um: tuple[F64, F64] | None = None
    textured: bool = False

    def side_um(self, radius_um: F64, cut: np.ndarray | bool) -> F64:
        """Return the longest sides (n,) allowed; cut: for outlines that another may cut, or of varying radius.

        Otherwise those of a full circle.
        """
        radius_um = np.minimum(radius_um, NEARLY_STRAIGHT)
        side = self._even_um(radius_um)
        if math.isfinite(self.cut_um2):
            short = np.minimum(np.cbrt(24.0 * self.cut_um2 * radius_um), self._end_um(96.0, radius_um))
            side = np.where(cut, np.minimum(side, short), side)
        return self._at_least_um(side, radius_um)

    def end_um(self, radius_um: F64) -> F64:
        """Return the longest sides (n,) of an open arc; see ``rims.sides_of``."""
        side = np.minimum(self._end_um(360.0, radius_um), self._even_um(radius_um))
        return self._at_least_um(side, radius_um)

    def _even_um(self, radius_um: F64) -> F64:
        longest = self.segment_um if self.longer_um is None else np.interp(radius_um, *self.longer_um)
        return np.minimum(longest, np.sqrt(self.wobble_um * radius_um * math.sqrt(720.0)))

    def _at_least_um(self, side_um: F64, radius_um: F64) -> F64:
        anywhere = np.maximum(side_um, np.sqrt(12.0 * self.off_um * radius_um))
        return np.minimum(anywhere, self.turn_rad * radius_um)

    def _end_um(self, times: float, radius_um: F64) -> F64:
        return np.sqrt(np.sqrt(times * self.moment_um3 * radius_um))


def validate_sides(total: float) -> None:
    """Raise if there are more sides than memory holds."""
    if total > MOST_SIDES:
        raise InvalidValueError(
            f"curves of the scene would take {total:.3g} sides at this tolerance; the most is {MOST_SIDES:g}: "
            "give a coarser one, or draw less of them",
            key="shapes",
            stage="Scene",
        )
