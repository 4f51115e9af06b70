"""Polygons, rectangles and discs in µm on the sensor: x to the right, y down, origin on the optical axis."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from camsim.arrays import F64
from camsim.spectra.curve import Reflectance
from camsim.typed import Corners, Point, Positive, judge, refusal
from camsim.words import brief

Place: TypeAlias = tuple[float, float]
Longer: TypeAlias = Callable[[tuple[float, float, float]], tuple[F64, F64]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Polygon:
    """A simple polygon: its outline does not cross itself; either direction round.

    points_um : at least three corners (x, y), µm

    >>> Polygon(points_um=[(0, 0), (2, 2), (2, 0), (0, 2)], reflectance=0.0)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: Polygon.points_um: the outline crosses itself at (1, 1); list ...
    """

    points_um: Corners
    reflectance: Reflectance

    __repr__ = brief

    def __post_init__(self) -> None:
        judge(self)
        corners = len(set(self.points_um))
        if corners < 3:
            raise refusal(self, "points_um", f"{corners} different points make no polygon; give at least 3")
        crossing = _self_crossing(self.points_um)
        if crossing is not None:
            where = f"({crossing[0]:.6g}, {crossing[1]:.6g})"
            message = f"the outline crosses itself at {where}; list the corners in order round the shape"
            raise refusal(self, "points_um", message)

    @property
    def circle_um(self) -> tuple[float, float, float] | None:
        """None: its sides are straight."""
        return None

    def outline_um(
        self,
        max_segment_um: float,
        max_wobble_um: float = math.inf,
        max_cut_um2: float = math.inf,
        longer: Longer | None = None,
    ) -> F64:
        """Return the corners (n, 2), µm; what the arguments limit, only curved shapes have."""
        return np.array(self.points_um)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectangle:
    """A rectangle about its centre; ``rotate_deg`` turns it clockwise as displayed (y is down)."""

    width_um: Positive
    height_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    reflectance: Reflectance

    def __post_init__(self) -> None:
        judge(self)

    @property
    def circle_um(self) -> tuple[float, float, float] | None:
        """None: its sides are straight."""
        return None

    def outline_um(
        self,
        max_segment_um: float,
        max_wobble_um: float = math.inf,
        max_cut_um2: float = math.inf,
        longer: Longer | None = None,
    ) -> F64:
        """Return the four corners (4, 2), µm."""
        angle = math.radians(self.rotate_deg)
        across = 0.5 * self.width_um * np.array([math.cos(angle), math.sin(angle)])
        down = 0.5 * self.height_um * np.array([-math.sin(angle), math.cos(angle)])
        corners: F64 = np.array(self.centre_um) + np.array(
            [-across - down, across - down, across + down, -across + down]
        )
        return corners


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc:
    """A round disc; rendered as a polygon of the same area with sides short enough for the tolerance."""

    radius_um: Positive
    centre_um: Point = (0.0, 0.0)
    reflectance: Reflectance

    def __post_init__(self) -> None:
        judge(self)

    @property
    def circle_um(self) -> tuple[float, float, float]:
        """The centre's x and y and the radius, µm."""
        return *self.centre_um, self.radius_um

    def side_um(self, max_segment_um: float, max_wobble_um: float = math.inf, max_cut_um2: float = math.inf) -> float:
        """Return how long the sides of a polygon of the same area may be.

        max_wobble_um : largest root-mean-square distance between the two outlines. For a side s it is s²/(R·√720):
                        the parabola s²/8R less its mean
        max_cut_um2   : largest area between them over a part of a side, which no other part makes up for where another
                        shape cuts the outline: s³/(72·√3·R)
        """
        return min(
            max_segment_um,
            math.sqrt(max_wobble_um * self.radius_um * math.sqrt(720.0)),
            math.cbrt(max_cut_um2 * self.radius_um * 72.0 * math.sqrt(3.0)),
        )

    def outline_um(
        self,
        max_segment_um: float,
        max_wobble_um: float = math.inf,
        max_cut_um2: float = math.inf,
        longer: Longer | None = None,
    ) -> F64:
        """Return a polygon (n, 2) of the same area, µm: its corners lie on radius R·√(θ/sin θ), θ = 2π/n.

        max_segment_um, max_wobble_um, max_cut_um2 : of the sides' lengths (``side_um``)
        longer : angles (m + 1,) all the way round a circle, and the length (m,) up to which sides will do between them
                 whatever those limits say: sides differ there, and θ is the mean of those that meet
        """
        angle, longest_um = np.array([0.0, 2.0 * math.pi]), np.zeros(1)
        if longer is not None:
            angle, longest_um = longer(self.circle_um)
        side_um = np.maximum(longest_um, self.side_um(max_segment_um, max_wobble_um, max_cut_um2))
        side_um = np.minimum(side_um, self.radius_um)  # no limit at all is none to divide by
        sides_until = np.concatenate([[0.0], np.cumsum(self.radius_um * np.diff(angle) / side_um)])
        sides = max(64, math.ceil(sides_until[-1]))
        corner = np.interp(sides_until[-1] / sides * np.arange(sides), sides_until, angle)
        step = np.diff(corner, append=2.0 * math.pi)
        step = 0.5 * (step + np.roll(step, 1))
        corner_radius_um = self.radius_um * np.sqrt(step / np.sin(step))
        direction = np.stack([np.cos(corner), np.sin(corner)], axis=1)
        outline: F64 = np.array(self.centre_um) + corner_radius_um[:, None] * direction
        return outline


Shape: TypeAlias = Polygon | Rectangle | Disc


def _self_crossing(points: Corners) -> Place | None:
    """Return a point where the outline touches or crosses itself, None for a simple outline."""
    import shapely
    from shapely.validation import explain_validity

    polygon = shapely.Polygon(points)
    if polygon.is_valid:
        return None
    where = re.search(r"\[(\S+) (\S+)\]", explain_validity(polygon))
    return (float(where[1]), float(where[2])) if where else (points[0][0], points[0][1])
