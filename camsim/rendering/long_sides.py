"""How long the sides of a round outline may be, however they fall: where little light comes from between side and arc.

A side s and its arc, R about the centre, lie no farther than s²/12R apart when the corners lie a little outside.

* Anywhere, a strip so wide takes no more than its width times the peak of the line spread. Where that is little enough,
  sides may be longer than the waves that pass.
* Beyond the photosites, what lies between takes no more than its area, s³/12R, times the most that an area so far away
  gives a photosite. Sides that grow with the distance, so that each adds what the others do for its length, are fewest:
  s ∝ (R/light)^{1/3}, in proportion to the distance of an Airy pattern.

Both hold whether or not another shape cuts the outline, and whatever rings meet.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem, RoundLens
from camsim.optics.pattern import Pattern
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.grid import Grid
from camsim.scene import Disc

MOST_TURN = 2.0 * math.pi / 64.0  # of a side, radians
STEP = 0.25  # of the distance: half an arc over which it is taken for the same
FAR_PART = 0.2  # of the outlines' share, for sides that are long because they are far away
HALVINGS = 60
NO_LIGHT = 1e-60  # of a Gaussian far out: any side will do there

Circle = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LongSides:
    """Sides that are short enough however they fall; lengths in µm.

    off       : distance between a side and its arc that is small enough anywhere
    low, high : corners of the outermost photosites' centres;  extent: how far OLPF and photosite reach from them
    pattern   : of the lens; None when it is not known, and then no distance helps
    blur, quiet : its longest length, and from where on its far form holds
    densest   : the most light that an area gives a photosite, 1/µm²
    factor    : sides are as long as this times (radius/light)^{1/3}
    """

    off: float
    low: F64
    high: F64
    extent: float
    pattern: Pattern | None
    blur: float
    quiet: float
    densest: float
    factor: float = 0.0

    @classmethod
    def of(
        cls,
        discs: Sequence[Disc],
        *,
        limits_um: tuple[float, float, float],
        system: OpticalSystem,
        grid: Grid,
        blur_um: tuple[float, float],
        line_per_um: float,
        budget: ErrorBudget,
    ) -> LongSides:
        """Choose them for all discs of a scene together.

        limits_um   : the longest segment, the largest wobble and the largest cut that are short enough anyway
        blur_um     : of the lens, shortest and longest;  line_per_um: peak of its line spread
        """
        allowed = budget.allowed("outlines")
        pattern = system.lens.pattern() if isinstance(system.lens, RoundLens) and not system.more else None
        half, area = system.photosite.half_extent_um, system.photosite.area_um2
        across = 2.0 * math.hypot(*half)
        low = np.array(grid.first_centre) * grid.pitch_um
        own = cls(
            off=(1.0 - FAR_PART) * allowed / (line_per_um if area == 0.0 else min(line_per_um, across / area)),
            low=low,
            high=low + np.array([grid.cols - 1, grid.rows - 1]) * grid.pitch_um,
            extent=float(np.hypot(*(np.abs(system.spots_um()) + half).T).max()),
            pattern=pattern,
            blur=blur_um[1],
            quiet=0.0 if pattern is None else pattern.quiet(budget.allowed("powers")) * blur_um[1],
            densest=math.inf if pattern is None else pattern.core / math.pi / blur_um[0] ** 2,
        )
        if area > 0.0:
            own = dataclasses.replace(own, densest=min(own.densest, 1.0 / area))
        if pattern is None:
            return own
        return dataclasses.replace(own, factor=own._factor(discs, limits_um, FAR_PART * allowed))

    def along(self, circle: Circle) -> tuple[F64, F64]:
        """Return angles (n + 1,) all the way round a circle, and how long sides may be (n,) between them, µm."""
        radius = circle[2]
        most = MOST_TURN * radius
        anywhere = self._anywhere(radius)
        if anywhere >= most or self.factor == 0.0:
            return np.array([0.0, 2.0 * math.pi]), np.array([min(anywhere, most)])
        angle, light = self._arcs(circle)
        longest = np.maximum(anywhere, self.factor * np.cbrt(radius / np.maximum(light, NO_LIGHT)))
        return angle, np.minimum(longest, most)

    def _anywhere(self, radius: float) -> float:
        return math.sqrt(12.0 * radius * self.off)

    def _arcs(self, circle: Circle) -> tuple[F64, F64]:
        """Return angles (n + 1,) and the most light (n,) per area between them: arcs short for their distance."""
        x, y, radius = circle
        angle = np.linspace(0.0, 2.0 * math.pi, 65)
        middle = 0.5 * (self.low + self.high)
        while True:
            centre, half = 0.5 * (angle[:-1] + angle[1:]), 0.5 * radius * np.diff(angle)
            place = np.stack([x + radius * np.cos(centre), y + radius * np.sin(centre)], axis=1)
            beside = np.abs(place - middle) - 0.5 * (self.high - self.low)
            # Below 0 inside.
            gap = np.hypot(*np.maximum(beside, 0.0).T) + np.minimum(beside.max(axis=1), 0.0)
            long = (half > STEP * np.maximum(np.abs(gap), self.blur)) & (gap + half > 0.0)
            long &= half > 1e-12 * radius
            if not long.any():
                break
            angle = np.sort(np.concatenate([angle, centre[long]]))
        distance = np.maximum(gap - half - self.extent, 0.0)
        return angle, self._light(distance)

    def _light(self, distance: F64) -> F64:
        assert self.pattern is not None
        far = np.maximum(distance, self.quiet) / self.blur
        light: F64 = np.minimum(self.pattern.spread(far) / self.blur**2, self.densest)
        light[distance < self.quiet] = self.densest
        return light

    def _factor(self, discs: Sequence[Disc], limits_um: tuple[float, float, float], allowed: float) -> float:
        """Return the factor with which all sides that are longer for it add up to what is allowed."""
        arcs = []
        for disc in discs:
            radius = disc.radius_um
            short, most = max(disc.side_um(*limits_um), self._anywhere(radius)), MOST_TURN * radius
            if short < most:
                angle, light = self._arcs(disc.circle_um)
                each = np.ones_like(light)
                arcs.append(np.stack([radius * np.diff(angle), light, radius * each, short * each, most * each]))
        if not arcs:
            return 0.0
        length, light, radius_of, short_of, most_of = np.concatenate(arcs, axis=1)
        shape = np.cbrt(radius_of / np.maximum(light, NO_LIGHT))

        def lost(factor: float) -> float:
            side = np.minimum(factor * shape, most_of)
            longer = side > short_of
            return float(np.sum((length * side**2 / (12.0 * radius_of) * light)[longer]))

        low, high = float((short_of / shape).min()), float((most_of / shape).max())
        if lost(high) <= allowed:
            return high
        for _ in range(HALVINGS):
            between = math.sqrt(low * high)
            low, high = (between, high) if lost(between) <= allowed else (low, between)
        return low
