"""The pupil of a lens: its outline, and a quadrature rule over it.

Lengths are in units of half the diameter D = focal length / f-number. Circular and polygonal pupils may have a circular
central obstruction. A square circumscribes the circle of diameter D (its side is D, so its transfer ends at 1/(λN)
along its sides); the corners of a bladed iris lie on the circle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.core.annotations import After
from camsim.core.arrays import F64
from camsim.core.typed import Number, Whole, refusal, validate
from camsim.errors import InvalidValueError
from camsim.numerics.quadrature import even_rule

MOST_BLADES = 64
LEAST_OBSTRUCTION, LARGEST_OBSTRUCTION = 1e-3, 0.95


def _none_or_some(obstruction: float) -> float:
    """Refuse an obstruction of less than a millionth of the light, whose ringing would be a thousand λN wide."""
    if 0.0 < obstruction < LEAST_OBSTRUCTION:
        allowed = f"0, or a number from {LEAST_OBSTRUCTION:g} to {LARGEST_OBSTRUCTION:g}"
        raise InvalidValueError(f"must be {allowed}, not {obstruction:g}", key="obstruction")
    return obstruction


Obstruction: TypeAlias = Annotated[float, Ge(0), Le(LARGEST_OBSTRUCTION), After(_none_or_some)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pupil:
    """The shape of a lens's pupil.

    shape       : "circular", "square" or "bladed" (a regular polygon)
    obstruction : diameter of the circular central obstruction over D; 0: none
    blades      : number of blades of a bladed iris
    rotate_deg  : rotation of a square or iris, clockwise as displayed; at 0 a square's sides run along x and y and an
                  iris has a corner at its right

    >>> round(Pupil(obstruction=0.5).area / math.pi, 12)
    0.75
    """

    shape: Literal["circular", "square", "bladed"] = "circular"
    obstruction: Obstruction = 0.0
    blades: Annotated[int, Ge(0), Le(MOST_BLADES)] = 0
    rotate_deg: float = 0.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            shape: Literal["circular", "square", "bladed"] = "circular",
            obstruction: Number = 0.0,
            blades: Whole = 0,
            rotate_deg: Number = 0.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        if self.shape == "bladed" and self.blades < 3:
            raise refusal(self, "blades", f"must be 3 to {MOST_BLADES} of an iris, not {self.blades}")
        if self.shape != "bladed" and self.blades:
            message = f"a {self.shape} pupil has none; leave them out, or make the shape bladed"
            raise refusal(self, "blades", message)
        most = 0.95 * self.inner_radius
        if self.obstruction > most:
            message = f"must be at most {most:.3g}, what leaves an opening of this shape, not {self.obstruction!r}"
            raise refusal(self, "obstruction", message)

    @property
    def inner_radius(self) -> float:
        """Radius of the largest circle inside the outline."""
        return math.cos(math.pi / self.blades) if self.shape == "bladed" else 1.0

    @property
    def outer_radius(self) -> float:
        """Radius of the smallest circle around the outline."""
        return math.sqrt(2.0) if self.shape == "square" else 1.0

    @property
    def area(self) -> float:
        """Area of the opening."""
        hole = math.pi * self.obstruction**2
        if self.shape == "circular":
            return math.pi - hole
        count, radius = (4, 2.0) if self.shape == "square" else (self.blades, 1.0)
        return 0.5 * count * radius * math.sin(2.0 * math.pi / count) - hole

    @property
    def sides(self) -> int:
        """Number of smooth pieces of the outline: 1 for a circle."""
        return self.blades or (4 if self.shape == "square" else 1)

    @property
    def side_length(self) -> float:
        """Length of a polygon's side."""
        return 2.0 * self.inner_radius * math.tan(math.pi / self.sides)

    def nodes(self, along: int, about: int) -> tuple[F64, F64, F64]:
        """Return x, y and weights of a quadrature rule over the pupil, along rays from its centre.

        along : nodes of a ray, from the obstruction on;  about: rays, around a circle or for each side of a polygon
        """
        t, share = _from_0(along)
        if self.shape == "circular":
            angle, weight = 2.0 * np.pi * np.arange(about) / about, np.full(about, 2.0 * np.pi / about)
            edge = np.ones(about)
        else:
            place, weight = _from_0(about)
            side = self.side_length * (place - 0.5)
            edge = np.hypot(self.inner_radius, side)
            angle = np.add.outer(list(self.normals()), np.arctan(side / self.inner_radius)).ravel()
            weight = np.tile(weight * self.side_length * self.inner_radius / edge**2, self.sides)
            edge = np.tile(edge, self.sides)
        length = edge - self.obstruction
        radius = self.obstruction + np.multiply.outer(t, length)
        return (
            (radius * np.cos(angle)).ravel(),
            (radius * np.sin(angle)).ravel(),
            (radius * share[:, None] * length * weight).ravel(),
        )

    def holds(self, x: F64, y: F64) -> np.ndarray:
        """Return a mask of the points that lie in the pupil."""
        square = x * x + y * y
        inside = (square <= self.outer_radius**2) & (square >= self.obstruction**2)
        if self.shape != "circular":
            for normal in self.normals():
                inside &= x * math.cos(normal) + y * math.sin(normal) <= self.inner_radius
        return inside

    def normals(self) -> Iterator[float]:
        """Yield the direction of the normal of every side of a polygon, radians."""
        count, first = (4, 0.0) if self.shape == "square" else (self.blades, math.pi / max(self.blades, 1))
        for k in range(count):
            yield first + math.radians(self.rotate_deg) + 2.0 * math.pi * k / count


def _from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a rule for waves."""
    nodes, weights = even_rule(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights
