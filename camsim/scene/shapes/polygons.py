"""Shapes with straight sides: polygons, rectangles, regular polygons and stars."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import Corners, Number, Place, Point, Positive, Several, Whole, refusal, validate
from camsim.core.words import brief
from camsim.numerics.rotations import cosine_and_sine
from camsim.scene.curves import joined, through
from camsim.scene.primitives import Primitive, Shape, one
from camsim.spectra.curve import NumberOrCurve, Reflectance

Sides = Annotated[int, Ge(3), Le(100_000)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Polygon(Shape):
    """A simple polygon, whose outline does not cross itself; it may run in either direction.

    points_um : at least three corners (x, y), µm
    holes_um  : outlines of holes in the polygon, which neither cross nor leave it

    >>> Polygon(points_um=[(0, 0), (2, 2), (2, 0), (0, 2)], reflectance=0.0)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    camsim.core.errors.InvalidValueError: Polygon.points_um: the outline crosses itself at (1, 1); list ...
    """

    depth: ClassVar[int] = 0

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

    def primitives(self) -> Iterator[Primitive]:
        """Return the polygon as one outline with holes."""
        outlines = [through(np.array(outline, float)) for outline in (self.points_um, *self.holes_um)]
        yield one(joined(outlines), self.reflectance, rule="evenodd", simple=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectangle(Shape):
    """A rectangle about its centre; ``rotate_deg`` turns it clockwise as displayed (y is down).

    >>> Rectangle(width_um=60.0, height_um=40.0, rotate_deg=4.0, reflectance=0.05)
    Rectangle(width_um=60.0, height_um=40.0, centre_um=(0.0, 0.0), rotate_deg=4.0, reflectance=0.05)
    """

    depth: ClassVar[int] = 0
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

    def __post_init__(self) -> None:
        validate(self)

    @property
    def corners_um(self) -> F64:
        """The four corners (4, 2)."""
        c, s = cosine_and_sine(self.rotate_deg)
        x, y = 0.5 * self.width_um * c, 0.5 * self.width_um * s  # half its width
        u, v = 0.5 * self.height_um * -s, 0.5 * self.height_um * c  # and down
        corners: F64 = np.array(self.centre_um) + np.array(
            [[-x - u, -y - v], [x - u, y - v], [x + u, y + v], [-x + u, -y + v]]
        )
        return corners

    def primitives(self) -> Iterator[Primitive]:
        """Return the outline."""
        yield one(through(self.corners_um), self.reflectance, simple=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class RegularPolygon(Shape):
    """A polygon of equal sides and angles; its first corner lies to the right of its centre before it is turned.

    radius_um : distance from the centre to a corner

    >>> RegularPolygon(sides=6, radius_um=30.0, reflectance=0.2)
    RegularPolygon(sides=6, radius_um=30.0, centre_um=(0.0, 0.0), rotate_deg=0.0, reflectance=0.2)
    """

    depth: ClassVar[int] = 0

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

    def __post_init__(self) -> None:
        validate(self)

    @property
    def pieces(self) -> int:
        """Number of sides."""
        return self.sides

    def primitives(self) -> Iterator[Primitive]:
        """Return the outline."""
        corners = _round(np.full(self.sides, self.radius_um), self.rotate_deg)
        yield one(through(np.array(self.centre_um) + corners), self.reflectance, simple=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Star(Shape):
    """A star of ``tips`` tips; the first lies to the right of its centre before it is turned.

    radius_um, inner_radius_um : distances from the centre to the tips, and to the corners between them

    >>> Star(tips=5, radius_um=30.0, inner_radius_um=12.0, reflectance=0.2)
    Star(tips=5, radius_um=30.0, inner_radius_um=12.0, centre_um=(0.0, 0.0), rotate_deg=0.0, reflectance=0.2)
    """

    depth: ClassVar[int] = 0

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

    def __post_init__(self) -> None:
        validate(self)

    @property
    def pieces(self) -> int:
        """Number of sides."""
        return 2 * self.tips

    def primitives(self) -> Iterator[Primitive]:
        """Return the outline."""
        corners = _round(np.tile([self.radius_um, self.inner_radius_um], self.tips), self.rotate_deg)
        yield one(through(np.array(self.centre_um) + corners), self.reflectance, simple=True)


def _round(radii: F64, rotate_deg: float) -> F64:
    """Return points at distances (n,) from the origin, at uniform angles."""
    angle = math.radians(rotate_deg) + math.tau * np.arange(len(radii)) / len(radii)
    corners: F64 = radii[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return corners


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
