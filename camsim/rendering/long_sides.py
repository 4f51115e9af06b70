"""How long sides of a curved outline may be, however they fall: where little light comes from between side and curve.

A side s and its curve, of radius R there, lie no farther than s²/12R apart when the corners lie a little outside.

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
from camsim.rendering.grid import Grid
from camsim.scene import Primitive
from camsim.scene.curves import STRAIGHT, joined
from camsim.scene.side_limits import MOST_TURN, SideLimits
from camsim.scene.stretches import stretches

STEP = 0.25  # of the distance: half a stretch of curve over which it is taken for the same
FAR_PART = 0.2  # of the outlines' share, for sides that are long because they are far away
HALVINGS = 60
NEARER = 0.25  # of the distance: how far a side may come nearer than its curve
NO_LIGHT = 1e-60  # of a Gaussian far out: any side will do there


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LongSides:
    """Sides that are short enough however they fall; lengths in µm.

    off       : distance between a side and its curve that is small enough anywhere
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
        primitives: Sequence[Primitive],
        *,
        limits: SideLimits,
        system: OpticalSystem,
        grid: Grid,
        blur_um: tuple[float, float],
        line_per_um: float,
        allowed: float,
        quiet: float,
    ) -> LongSides:
        """Choose them for all curves of a scene together.

        limits   : of sides that are short enough anyway
        blur_um  : of the lens, shortest and longest;  line_per_um: peak of its line spread
        allowed  : error of a photosite, of full contrast;  quiet: what the pattern's far form may be wrong by
        """
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
            quiet=0.0 if pattern is None else pattern.quiet(quiet) * blur_um[1],
            densest=math.inf if pattern is None else pattern.peak / blur_um[0] ** 2,
        )
        if area > 0.0:
            own = dataclasses.replace(own, densest=min(own.densest, 1.0 / area))
        if pattern is None:
            return own
        return dataclasses.replace(own, factor=own._factor(primitives, limits, FAR_PART * allowed))

    def along(self, place: F64, radius: F64, length: F64) -> F64:
        """Return how long sides may be (n,) about places (n, 2) of curves, µm; see ``SideLimits.longer``."""
        anywhere = self._anywhere(radius)
        if self.factor == 0.0:
            return anywhere
        gap = self._gap(place) - 0.5 * length
        far = self.factor * np.cbrt(radius / np.maximum(self._light(gap), NO_LIGHT))
        # No corner is moved into the frame, however little light comes from where it was; a straight line's stay.
        outside = gap > 0.0
        far = np.minimum(far, np.sqrt(12.0 * NEARER * np.where(outside, radius, 0.0) * np.where(outside, gap, 0.0)))
        longer: F64 = np.maximum(anywhere, far)
        return longer

    def apart(self, place: F64, length: F64) -> F64:
        """Return how long stretches of curve may be (n,) that are taken for equally far away; see ``sides.Apart``."""
        gap = self._gap(place)
        most = 2.0 * STEP * np.maximum(np.abs(gap), self.blur)
        # What lies wholly within the frame is near everywhere.
        return np.where((self.pattern is not None) & (gap + 0.5 * length > 0.0), most, np.inf)

    def _anywhere(self, radius: F64) -> F64:
        longest: F64 = np.sqrt(12.0 * radius * self.off)
        return longest

    def _gap(self, place: F64) -> F64:
        """Return how far places lie outside the frame; below 0 inside."""
        beside = np.abs(place - 0.5 * (self.low + self.high)) - 0.5 * (self.high - self.low)
        gap: F64 = np.hypot(*np.maximum(beside, 0.0).T) + np.minimum(beside.max(axis=1), 0.0)
        return gap

    def _light(self, gap: F64) -> F64:
        """Return the most light per area from places no nearer than that."""
        assert self.pattern is not None
        distance = np.maximum(gap - self.extent, 0.0)
        far = np.maximum(distance, self.quiet) / self.blur
        light: F64 = np.minimum(self.pattern.spread(far) / self.blur**2, self.densest)
        light[distance < self.quiet] = self.densest
        return light

    def _factor(self, primitives: Sequence[Primitive], limits: SideLimits, allowed: float) -> float:
        """Return the factor with which all sides that are longer for it add up to what is allowed."""
        curves = joined([fill.curves for one in primitives for fill in one.fills])
        found = stretches(curves.some(curves.kind != STRAIGHT), self.apart)
        anywhere, most = self._anywhere(found.radius_um), MOST_TURN * found.radius_um
        short = np.maximum(limits.side_um(found.radius_um, True), anywhere)
        found, short, most = found.some(short < most), short[short < most], most[short < most]
        if not short.size:
            return 0.0
        light = self._light(self._gap(found.place_um) - 0.5 * found.length_um)
        shape = np.cbrt(found.radius_um / np.maximum(light, NO_LIGHT))

        def lost(factor: float) -> float:
            side = np.minimum(factor * shape, most)
            longer = side > short
            return float(np.sum((found.length_um * side**2 / (12.0 * found.radius_um) * light)[longer]))

        low, high = float((short / shape).min()), float((most / shape).max())
        if lost(high) <= allowed:
            return high
        for _ in range(HALVINGS):
            between = math.sqrt(low * high)
            low, high = (between, high) if lost(between) <= allowed else (low, between)
        return low
