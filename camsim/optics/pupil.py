"""The pupil of a lens: its outline, the overlap of two shifted copies, and quadrature rules over either.

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
from camsim.core.errors import InvalidValueError
from camsim.core.typed import Number, Whole, refusal, validate
from camsim.numerics.quadrature import even_rule, gauss_legendre

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
    def corners(self) -> F64:
        """The corners (n, 2) of a polygon, in positive order; none of a circle."""
        if self.shape == "circular":
            return np.empty((0, 2))
        turn = math.radians(self.rotate_deg)
        count, radius, first = (
            (4, math.sqrt(2.0), 0.25 * math.pi) if self.shape == "square" else (self.blades, 1.0, 0.0)
        )
        angle = first + turn + 2.0 * math.pi * np.arange(count) / count
        return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)

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
        way = edge - self.obstruction
        radius = self.obstruction + np.multiply.outer(t, way)
        return (
            (radius * np.cos(angle)).ravel(),
            (radius * np.sin(angle)).ravel(),
            (radius * share[:, None] * way * weight).ravel(),
        )

    def holds(self, x: F64, y: F64) -> np.ndarray:
        """Return a mask of the points that lie in the pupil."""
        square = x * x + y * y
        inside = (square <= self.outer_radius**2) & (square >= self.obstruction**2)
        if self.shape != "circular":
            for normal in self.normals():
                inside &= x * math.cos(normal) + y * math.sin(normal) <= self.inner_radius
        return inside

    def overlap(self, shift: float, angle_rad: float, nodes: int) -> tuple[F64, F64, F64]:
        """Return a quadrature rule over the overlap of two copies that are ``shift`` apart along a direction.

        returns : x, y (from the midpoint between the copies) and weights; exact boundaries, nodes for waves within them

        On lines parallel to the shift each copy is one interval, or two next to the obstruction. The rule is divided
        where their ends change order, and cosine-spaced in between, to resolve the square roots of circles.
        """
        cuts = sorted({*self._cuts(shift, angle_rad)})
        cos, sin = math.cos(angle_rad), math.sin(angle_rad)
        # t = middle − half·cos(u), with weight half·sin(u). Gauss nodes are dense at the ends, where small shifts have
        # roots.
        x, w = gauss_legendre(nodes)
        u = 0.5 * np.pi * (1.0 + x)
        spaced, slope = -np.cos(u), 0.5 * np.pi * np.sin(u) * w
        t, v = _from_0(nodes)
        low, high = np.array(cuts[:-1]), np.array(cuts[1:])
        wide = high - low > 1e-15
        low, high = low[wide], high[wide]
        across = (0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * spaced).ravel()
        share = (0.5 * (high - low)[:, None] * slope).ravel()
        begin, end = self._chord(across, angle_rad)
        hole = np.sqrt(np.maximum(self.obstruction**2 - across * across, 0.0))
        # Beyond the obstruction there is one interval, and the second is empty.
        pieces = [(begin, np.where(hole > 0.0, -hole, end)), (np.where(hole > 0.0, hole, end), end)]
        xs, ys, weights = [], [], []
        for a in pieces:
            for b in pieces:
                left = np.maximum(a[0] - 0.5 * shift, b[0] + 0.5 * shift)
                length = np.minimum(a[1] - 0.5 * shift, b[1] + 0.5 * shift) - left
                there = length > 0.0
                along = left[there, None] + length[there, None] * t
                level = np.broadcast_to(across[there, None], along.shape)
                xs.append((along * cos - level * sin).ravel())
                ys.append((along * sin + level * cos).ravel())
                weights.append((share[there, None] * length[there, None] * v).ravel())
        return np.concatenate(xs), np.concatenate(ys), np.concatenate(weights)

    def _chord(self, across: F64, angle: float) -> tuple[F64, F64]:
        """Return where lines along ``angle``, at distances ``across`` from the centre, enter and leave the outline."""
        if self.shape == "circular":
            half = np.sqrt(np.maximum(1.0 - across * across, 0.0))
            return -half, half
        begin, end = np.full(across.shape, -np.inf), np.full(across.shape, np.inf)
        for normal in self.normals():
            # Inside: cos·s − sin·t ≤ distance to the side, in the rotated axes.
            along = math.cos(normal - angle)
            bound = self.inner_radius - across * math.sin(normal - angle)
            if along > 1e-12:
                end = np.minimum(end, bound / along)
            elif along < -1e-12:
                begin = np.maximum(begin, bound / along)
        return np.minimum(begin, end), end

    def normals(self) -> Iterator[float]:
        """Yield the direction of the normal of every side of a polygon, radians."""
        count, first = (4, 0.0) if self.shape == "square" else (self.blades, math.pi / max(self.blades, 1))
        for k in range(count):
            yield first + math.radians(self.rotate_deg) + 2.0 * math.pi * k / count

    def _cuts(self, shift: float, angle: float) -> Iterator[float]:
        """Yield every distance across the shift at which ends of intervals begin, end or meet."""
        radii = [self.obstruction] if self.obstruction else []
        lines: list[tuple[float, float]] = []  # s = c0 + c1·t along each side
        if self.shape == "circular":
            radii.append(1.0)
            extent = 1.0
        else:
            turned = self.corners @ np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
            yield from turned[:, 1].tolist()
            extent = float(np.abs(turned[:, 1]).max())
            for normal in self.normals():
                along = math.cos(normal - angle)
                if abs(along) > 1e-12:
                    lines.append((self.inner_radius / along, -math.sin(normal - angle) / along))
        found: list[float] = [value for radius in radii for value in (-radius, radius)]
        for i, a in enumerate(radii):
            for b in radii[i:]:
                # √(b² − t²) ± √(a² − t²) = shift
                larger = 0.5 * (shift + (b * b - a * a) / shift) if shift else 0.0
                if 0.0 < larger < b:
                    found += [-math.sqrt(b * b - larger * larger), math.sqrt(b * b - larger * larger)]
        for c0, c1 in lines:
            for d0, d1 in lines:
                if abs(c1 - d1) > 1e-12:
                    found.append((shift - c0 + d0) / (c1 - d1))
            for radius in radii:
                # (c0 + c1·t ∓ shift)² = radius² − t²
                for level in (c0 - shift, c0 + shift):
                    half, free = c1 * level / (1.0 + c1 * c1), (level * level - radius * radius) / (1.0 + c1 * c1)
                    if half * half > free:
                        root = math.sqrt(half * half - free)
                        found += [-half - root, -half + root]
        # Between two that differ only by rounding the rule has negligible weight.
        yield from (value for value in found if abs(value) <= extent)


def _from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a rule for waves."""
    nodes, weights = even_rule(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights
