"""Shapes with straight sides: polygons, rectangles, regular polygons and stars."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import Corners, Number, Place, Point, Positive, Several, Whole, refusal, validate
from camsim.core.words import brief
from camsim.scene.curves import Curves, joined, through
from camsim.scene.primitives import Outlined, turned
from camsim.spectra.curve import NumberOrCurve, Reflectance

Sides = Annotated[int, Ge(3), Le(100_000)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Polygon(Outlined):
    """A simple polygon: its outline does not cross itself; either direction round.

    points_um : at least three corners (x, y), µm
    holes_um  : outlines of holes in the polygon, which neither cross nor leave it

    >>> Polygon(points_um=[(0, 0), (2, 2), (2, 0), (0, 2)], reflectance=0.0)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: Polygon.points_um: the outline crosses itself at (1, 1); list ...
    """

    points_um: Corners
    holes_um: Several[Corners] = ()
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self, *, points_um: Several[Place], holes_um: Several[Several[Place]] = (), reflectance: NumberOrCurve
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        for key, outline in (("points_um", self.points_um), *(("holes_um", hole) for hole in self.holes_um)):
            corners = len(set(outline))
            if corners < 3:
                raise refusal(self, key, f"{corners} different points make no polygon; give at least 3")
            if (place := _fault((outline,))) is not None:
                message = f"the outline crosses itself at {place[1]}; list the corners in order round the shape"
                raise refusal(self, key, message)
        if self.holes_um and (place := _fault((self.points_um, *self.holes_um))) is not None:
            what = "a hole lies outside" if place[0].startswith("Hole") else "outlines of holes cross or share sides"
            raise refusal(self, "holes_um", f"{what} at {place[1]}; a path takes outlines that cross")

    @property
    def pieces(self) -> int:
        """Number of sides."""
        return len(self.points_um) + sum(map(len, self.holes_um))

    def _outline(self) -> Curves:
        return joined([through(np.array(outline, float)) for outline in (self.points_um, *self.holes_um)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectangle(Outlined):
    """A rectangle about its centre; ``rotate_deg`` turns it clockwise as displayed (y is down).

    >>> Rectangle(width_um=60.0, height_um=40.0, rotate_deg=4.0, reflectance=0.05)
    Rectangle(width_um=60.0, height_um=40.0, centre_um=(0.0, 0.0), rotate_deg=4.0, reflectance=0.05)
    """

    pieces: ClassVar[int] = 4

    width_um: Positive
    height_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            width_um: Number,
            height_um: Number,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            reflectance: NumberOrCurve,
        ) -> None: ...

    @property
    def corners_um(self) -> F64:
        """The four corners (4, 2)."""
        across, down = turned(0.5 * np.diag([self.width_um, self.height_um]), self.rotate_deg)
        return np.array([-across - down, across - down, across + down, down - across]) + self.centre_um

    def _outline(self) -> Curves:
        return through(self.corners_um)


@dataclass(frozen=True, slots=True, kw_only=True)
class RegularPolygon(Outlined):
    """A polygon of equal sides and angles; its first corner lies to the right of its centre before it is turned.

    radius_um : distance from the centre to a corner

    >>> RegularPolygon(sides=6, radius_um=30.0, reflectance=0.2)
    RegularPolygon(sides=6, radius_um=30.0, centre_um=(0.0, 0.0), rotate_deg=0.0, reflectance=0.2)
    """

    sides: Sides
    radius_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            sides: Whole,
            radius_um: Number,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            reflectance: NumberOrCurve,
        ) -> None: ...

    def _outline(self) -> Curves:
        return _round(self, np.full(self.sides, self.radius_um))


@dataclass(frozen=True, slots=True, kw_only=True)
class Star(Outlined):
    """A star of ``tips``; the first lies to the right of its centre before it is turned.

    radius_um, inner_radius_um : distances from the centre to the tips, and to the corners between them

    >>> Star(tips=5, radius_um=30.0, inner_radius_um=12.0, reflectance=0.2)
    Star(tips=5, radius_um=30.0, inner_radius_um=12.0, centre_um=(0.0, 0.0), rotate_deg=0.0, reflectance=0.2)
    """

    tips: Sides
    radius_um: Positive
    inner_radius_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            tips: Whole,
            radius_um: Number,
            inner_radius_um: Number,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            reflectance: NumberOrCurve,
        ) -> None: ...

    def _outline(self) -> Curves:
        return _round(self, np.tile([self.radius_um, self.inner_radius_um], self.tips))


def _round(shape: RegularPolygon | Star, radii: F64) -> Curves:
    """Return the polygon of corners at distances (n,) from a shape's centre, at uniform angles."""
    angle = math.radians(shape.rotate_deg) + math.tau * np.arange(len(radii)) / len(radii)
    corners = radii[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return through(np.array(shape.centre_um) + corners)


def _fault(outlines: tuple[Corners, ...]) -> tuple[str, str] | None:
    """Return the fault of an outline and its holes, and its place; None if none touch or cross."""
    import shapely
    from shapely.validation import explain_validity

    polygon = shapely.Polygon(outlines[0], outlines[1:])
    if polygon.is_valid:
        return None
    said = explain_validity(polygon)
    where = re.search(r"\[(\S+) (\S+)\]", said)
    x, y = (float(where[1]), float(where[2])) if where else outlines[0][0]
    return said, f"({x:.6g}, {y:.6g})"
