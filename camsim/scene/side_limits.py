"""How long the sides of a polygon may be that stands for a curved outline."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError

MOST_TURN = 2.0 * math.pi / 64.0
"""Of a side, radians."""

MOST_SIDES = 20_000_000  # of all curves
NOTHING = 1e-100

Longest = Callable[[F64, F64, F64], F64]


class SideLimits(NamedTuple):
    """How long a side may be where a curve's radius is R.

    segment_um : at most
    wobble_um  : root-mean-square distance between side and curve: s²/(R·√720), the parabola s²/8R less its mean
    cut_um2    : area between them that no other side makes up for: what one leaves at a corner, whose place is kept,
                 s³/24R, and over a part of a side where another shape cuts the outline, s³/(72·√3·R). Both are
                 taken for the first: an arc then has the sides of the circle that it lies on
    moment_um3 : that a side leaves where the next one is longer or shorter: s⁴/96R
    shift_um   : by how much a long part of an outline may be moved
    longer     : lengths (n,) that will do whatever those limits say, by places (n, 2), radii (n,) and the lengths (n,)
                 of curve about each place
    textured   : there are pictures behind the outlines, edges of whose samples may cut any of them anywhere
    """

    segment_um: float = math.inf
    wobble_um: float = math.inf
    cut_um2: float = math.inf
    moment_um3: float = math.inf
    shift_um: float = math.inf
    longer: Longest | None = None
    textured: bool = False

    @property
    def grows(self) -> bool:
        """Whether sides that differ in length have to grow: not those that are only drawn."""
        return math.isfinite(self.moment_um3)

    def side_um(self, radius_um: F64, cut: np.ndarray | bool) -> F64:
        """Return the longest sides (n,) of one length but for ``longer``; cut: whether another outline may cut there.

        Where none does they are those of all of a circle.
        """
        side = np.minimum(self.segment_um, np.sqrt(self.wobble_um * radius_um * math.sqrt(720.0)))
        if math.isfinite(self.cut_um2):
            short = np.minimum(np.cbrt(24.0 * self.cut_um2 * radius_um), self._end_um(96.0, radius_um))
            side = np.where(cut, np.minimum(side, short), side)
        return np.minimum(side, MOST_TURN * radius_um)

    def end_um(self, radius_um: F64) -> F64:
        """Return the longest sides (n,) of an arc that ends; see ``rim_sides``."""
        return np.minimum(self._end_um(360.0, radius_um), self.side_um(radius_um, False))

    def first_um(self, radius_um: F64) -> F64:
        """Return sides (n,) that may begin at once: half as long as what may follow a side of another length."""
        return self._end_um(6.0, radius_um)

    def growing_um(
        self, curvature_per_um: F64, changes_per_um2: F64, bends_per_um3: F64, from_start_um: F64, from_end_um: F64
    ) -> F64:
        """Return the longest sides (...) of a part that no other outline cuts, so far from its two ends.

        curvature_per_um : signed, and its first and second derivatives along the curve

        Sides s that grow leave what all of them together are off by: as if the outline were moved by (κ·s⁴)″/288 (each
        has its curve's area, but its ends are off by as much as those beside them, so that it is tilted). So κ·s⁴ rises
        from the ends as a parabola, whose slope and bend keep within what may be cut and moved, beginning with what may
        begin at once; and where κ changes by itself it keeps that bend as well. One limit gives way to another as
        smoothly: a step in s⁴ is a step, however small it looks. About an inflection sides turn one way and the other.
        """
        curved = np.abs(curvature_per_um)
        over = NOTHING + (curved / MOST_TURN) ** 4 + (2.0 * changes_per_um2 / MOST_TURN) ** 2
        over += self.segment_um**-4.0 + (curved / self.wobble_um) ** 2 / 720.0
        radius = 1.0 / np.maximum(curved, NOTHING)
        first = np.minimum(self.first_um(radius) ** 4, (24.0 * self.cut_um2 * radius) ** (4.0 / 3.0))
        for away in (from_start_um, from_end_um):
            over += 1.0 / (first + 72.0 * radius * away * (self.cut_um2 + self.shift_um * away))
        # Along a curve that bends less and less wobbles end where its sides are as long as they may be at all.
        least = self.wobble_um * math.sqrt(720.0) / self.segment_um**2
        of_wobbles = 2.0 * changes_per_um2**2 / np.hypot(curvature_per_um, least)
        over += np.hypot(bends_per_um3, of_wobbles) / (144.0 * self.shift_um)
        longest: F64 = over**-0.25
        return longest

    def _end_um(self, times: float, radius_um: F64) -> F64:
        longest: F64 = np.sqrt(np.sqrt(times * self.moment_um3 * radius_um))
        return longest


def judge_sides(total: float) -> None:
    """Refuse more sides than memory holds."""
    if total > MOST_SIDES:
        raise InvalidValueError(
            f"curves of the scene would take {total:.3g} sides at this tolerance; the most is {MOST_SIDES:g}: "
            "give a coarser one, or draw less of them",
            key="shapes",
            stage="Scene",
        )
