"""Round shapes: discs, ellipses, rings and sectors, as exact curves; engines choose sides by tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from annotated_types import Ge, Gt, Le

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, Place, Point, Positive, refusal, validate
from camsim.scene.curves import ARC, Curves, around, joined
from camsim.scene.primitives import Fill, Outlined, Primitive, turned
from camsim.spectra.curve import NumberOrCurve, Reflectance, Spectrum

Turn = Annotated[float, Gt(0), Le(360)]
Angle = Annotated[float, Ge(-1e6), Le(1e6)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc(Outlined):
    """A round disc.

    >>> Disc(radius_um=30.0, centre_um=(60.0, 0.0), reflectance=0.2)
    Disc(radius_um=30.0, centre_um=(60.0, 0.0), reflectance=0.2)
    """

    pieces: ClassVar[int] = 1

    radius_um: Positive
    centre_um: Point = (0.0, 0.0)
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(self, *, radius_um: Number, centre_um: Place = (0.0, 0.0), reflectance: NumberOrCurve) -> None: ...

    def _outline(self) -> Curves:
        return around(self.centre_um, *(self.radius_um * np.eye(2)))

    @classmethod
    def many(cls, radius_um: F64, centre_um: F64, surfaces: Iterable[Spectrum]) -> Iterator[Disc]:
        """Yield discs of valid arrays (n,) and (n, 2); to validate each takes longer than to render it."""
        give = object.__setattr__
        for radius, centre, reflectance in zip(radius_um.tolist(), centre_um.tolist(), surfaces, strict=True):
            give(disc := cls.__new__(cls), "radius_um", radius)
            give(disc, "centre_um", (*centre,))
            give(disc, "reflectance", reflectance)
            yield disc

    @staticmethod
    def together(discs: Sequence[Disc]) -> list[Primitive]:
        """Return the outlines of many discs, as views of a few arrays."""
        points = np.zeros((len(discs), 1, 4, 2))
        points[:, 0, 1, 0] = points[:, 0, 2, 1] = [disc.radius_um for disc in discs]
        points[:, 0, 0] = points[:, 0, 3] = points[:, 0, 1] + [disc.centre_um for disc in discs]
        turn, kind, first = np.array([math.tau]), np.array([ARC]), np.array([0, 1])
        return [
            Primitive(((Fill(Curves(each, turn, kind, first), "nonzero", True),),), disc.reflectance)
            for each, disc in zip(points, discs, strict=True)
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipse(Outlined):
    """An ellipse; ``rotate_deg`` turns it clockwise as displayed.

    radius_x_um, radius_y_um : half its width and half its height before it is turned

    >>> Ellipse(radius_x_um=30.0, radius_y_um=10.0, rotate_deg=20.0, reflectance=0.2)
    Ellipse(radius_x_um=30.0, radius_y_um=10.0, centre_um=(0.0, 0.0), rotate_deg=20.0, reflectance=0.2)
    """

    pieces: ClassVar[int] = 1

    radius_x_um: Positive
    radius_y_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            radius_x_um: Number,
            radius_y_um: Number,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            reflectance: NumberOrCurve,
        ) -> None: ...

    def _outline(self) -> Curves:
        return around(self.centre_um, *turned(np.diag([self.radius_x_um, self.radius_y_um]), self.rotate_deg))


@dataclass(frozen=True, slots=True, kw_only=True)
class Ring(Outlined):
    """The area between two concentric circles.

    >>> Ring(radius_um=30.0, inner_radius_um=20.0, reflectance=0.2)
    Ring(radius_um=30.0, inner_radius_um=20.0, centre_um=(0.0, 0.0), reflectance=0.2)
    """

    pieces: ClassVar[int] = 2

    radius_um: Positive
    inner_radius_um: Positive
    centre_um: Point = (0.0, 0.0)
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            radius_um: Number,
            inner_radius_um: Number,
            centre_um: Place = (0.0, 0.0),
            reflectance: NumberOrCurve,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        validate_radii(self, self.inner_radius_um, self.radius_um)

    def _outline(self) -> Curves:
        return _circles(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sector(Outlined):
    """Part of a disc, or of a ring where ``inner_radius_um`` is above 0.

    from_deg, turn_deg : direction in which it begins, clockwise as displayed from the right, and angle that it spans

    >>> Sector(radius_um=30.0, from_deg=0.0, turn_deg=90.0, reflectance=0.2)
    Sector(radius_um=30.0, inner_radius_um=0.0, from_deg=0.0, turn_deg=90.0, centre_um=(0.0, 0.0), reflectance=0.2)
    """

    pieces: ClassVar[int] = 4

    radius_um: Positive
    inner_radius_um: NonNegative = 0.0
    from_deg: Angle = 0.0
    turn_deg: Turn
    centre_um: Point = (0.0, 0.0)
    reflectance: Reflectance

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            radius_um: Number,
            inner_radius_um: Number = 0.0,
            from_deg: Number = 0.0,
            turn_deg: Number,
            centre_um: Place = (0.0, 0.0),
            reflectance: NumberOrCurve,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        validate_radii(self, self.inner_radius_um, self.radius_um)

    def _outline(self) -> Curves:
        """Return its outline: forward along the rim, back along the inner one."""
        if self.turn_deg == 360.0:
            return _circles(self)
        turn, outer, inner = math.radians(self.turn_deg), self.radius_um, self.inner_radius_um
        begin, end = (turned(np.eye(2), angle) for angle in (self.from_deg, self.from_deg + self.turn_deg))
        there = [outer * begin[0], outer * begin[0], outer * begin[1], outer * end[0]]
        back = [inner * end[0], inner * end[0], -inner * end[1], inner * begin[0]]
        sides = [[there[3], there[3], back[0], back[0]], [back[3], back[3], there[0], there[0]]]
        rows = [(there, turn, ARC), (sides[0], 0.0, 0), (back, turn, ARC), (sides[1], 0.0, 0)]
        if inner == 0.0:
            del rows[2]
        points, bends, kinds = zip(*rows, strict=True)
        curves = Curves(np.array(points), np.array(bends), np.array(kinds, np.int64), np.array([0, len(rows)]))
        return curves.shifted(np.array(self.centre_um))


def _circles(shape: Ring | Sector) -> Curves:
    """Return the circles of a shape."""
    radii = (shape.radius_um, shape.inner_radius_um)
    return joined([around(shape.centre_um, *(radius * np.eye(2))) for radius in radii if radius > 0.0])


def validate_radii(shape: Any, inner_um: float, outer_um: float) -> None:
    """Raise unless the inner radius is smaller than the outer one."""
    if inner_um >= outer_um:
        raise refusal(shape, "inner_radius_um", f"is {inner_um:g}; it must be below radius_um, {outer_um:g}")
