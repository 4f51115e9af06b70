"""The light-sensitive area of a pixel: shapes whose transforms are known exactly."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from annotated_types import Gt, Le

from camsim.core.arrays import F64
from camsim.core.typed import Corners, NonNegative, Number, Place, Positive, Several, check, refusal, validate
from camsim.core.words import brief
from camsim.numerics.bessel import jinc
from camsim.numerics.matrix_products import product
from camsim.numerics.quadrature import gauss_legendre

# Largest |f| over a polygon's inverse size for the quadrature rule, whose phases are then below 0.18 radians, and the
# nodes of each axis of a triangle: they integrate such a wave to rounding.
LOW, NODES = 0.02, 5


class _Rectangle:
    """Mixin of rectangles with ``sides_um``. It has no fields."""

    __slots__ = ()

    @property
    @abstractmethod
    def sides_um(self) -> tuple[float, float]:
        """Width and height, µm."""

    @property
    def half_extent_um(self) -> tuple[float, float]:
        """How far the photosite reaches from its centre along x and y, µm."""
        width, height = self.sides_um
        return 0.5 * width, 0.5 * height

    @property
    def area_um2(self) -> float:
        """Light-collecting area, µm²."""
        return math.prod(self.sides_um)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function sinc(w·fx)·sinc(h·fy), the same at every wavelength."""
        width, height = self.sides_um
        otf: F64 = np.sinc(np.multiply(width, fx_per_um)) * np.sinc(np.multiply(height, fy_per_um))
        return otf


@dataclass(frozen=True, slots=True, kw_only=True)
class SquarePhotosite(_Rectangle):
    """A square that collects light evenly, sides along x and y; ``side_um`` 0 is a point sample.

    >>> SquarePhotosite.from_fill_factor(pitch_um=4.0, fill_factor=0.25).side_um
    2.0
    """

    place: ClassVar[str] = "photosite"
    separable: ClassVar[bool] = True

    side_um: NonNegative

    if TYPE_CHECKING:

        def __init__(self, *, side_um: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def from_fill_factor(cls, *, pitch_um: Number, fill_factor: Number) -> SquarePhotosite:
        """Return the square whose area is ``fill_factor`` (0..1) of the pitch squared."""
        pitch_um = check(pitch_um, Positive, "pitch_um", cls.__name__)
        fill_factor = check(fill_factor, Annotated[float, Gt(0), Le(1)], "fill_factor", cls.__name__)
        return cls(side_um=pitch_um * math.sqrt(fill_factor))

    @property
    def sides_um(self) -> tuple[float, float]:
        """Width and height, µm."""
        return self.side_um, self.side_um


@dataclass(frozen=True, slots=True, kw_only=True)
class RectangularPhotosite(_Rectangle):
    """A rectangle that collects light evenly, sides along x and y.

    >>> RectangularPhotosite(width_um=3.0, height_um=2.0).area_um2
    6.0
    """

    place: ClassVar[str] = "photosite"
    separable: ClassVar[bool] = True

    width_um: Positive
    height_um: Positive

    if TYPE_CHECKING:

        def __init__(self, *, width_um: Number, height_um: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @property
    def sides_um(self) -> tuple[float, float]:
        """Width and height, µm."""
        return self.width_um, self.height_um


@dataclass(frozen=True, slots=True, kw_only=True)
class CircularPhotosite:
    """A disc that collects light evenly.

    >>> disc = CircularPhotosite(diameter_um=4.0)
    >>> bool(abs(disc.otf(np.array(1.2196698912665045 / 4.0), np.array(0.0), 550.0)) < 1e-15)  # its first zero
    True
    """

    place: ClassVar[str] = "photosite"

    diameter_um: Positive

    if TYPE_CHECKING:

        def __init__(self, *, diameter_um: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @property
    def half_extent_um(self) -> tuple[float, float]:
        """How far the photosite reaches from its centre along x and y, µm."""
        return 0.5 * self.diameter_um, 0.5 * self.diameter_um

    @property
    def area_um2(self) -> float:
        """Light-collecting area, µm²."""
        return 0.25 * math.pi * self.diameter_um**2

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function 2·J1(z)/z, z = π·d·f, the same at every wavelength."""
        return 2.0 * jinc(math.pi * self.diameter_um * np.hypot(fx_per_um, fy_per_um))


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundedPhotosite:
    """A rectangle with rounded corners that collects light evenly.

    radius_um : radius of the corners, at most half the shorter side

    >>> round(RoundedPhotosite(width_um=2.0, height_um=2.0, radius_um=1.0).area_um2, 12)  # a disc
    3.14159265359
    """

    place: ClassVar[str] = "photosite"

    width_um: Positive
    height_um: Positive
    radius_um: NonNegative

    if TYPE_CHECKING:

        def __init__(self, *, width_um: Number, height_um: Number, radius_um: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        most = 0.5 * min(self.width_um, self.height_um)
        if self.radius_um > most:
            message = f"must be at most {most:g}, half the photosite's shorter side, not {self.radius_um!r}"
            raise refusal(self, "radius_um", message)

    @property
    def half_extent_um(self) -> tuple[float, float]:
        """How far the photosite reaches from its centre along x and y, µm."""
        return 0.5 * self.width_um, 0.5 * self.height_um

    @property
    def area_um2(self) -> float:
        """Light-collecting area, µm²."""
        return self.width_um * self.height_um - (4.0 - math.pi) * self.radius_um**2

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function, the same at every wavelength: exact rows, with a Gauss rule over the corners' angle.

        The number of rows follows from the highest frequency: accurate to rounding.
        """
        fx, fy = np.asarray(fx_per_um, float), np.asarray(fy_per_um, float)
        width, height, radius = self.width_um, self.height_um, self.radius_um
        flat = height - 2.0 * radius
        total = width * flat * np.sinc(width * fx) * np.sinc(flat * fy)
        highest = float(np.hypot(fx, fy).max(initial=0.0))
        # Over a quarter turn the phase is within ±π²/2 times radius and frequency: half as many nodes, plus a few.
        x, w = gauss_legendre(math.ceil(2.8 * radius * min(highest, 1000.0 / max(radius, 1e-300))) + 20)
        angle = 0.25 * math.pi * (1.0 + x)
        row, level = width - 2.0 * radius * (1.0 - np.cos(angle)), 0.5 * flat + radius * np.sin(angle)
        share = 0.5 * math.pi * radius * w * np.cos(angle) * row

        def rows(part: slice | int) -> tuple[F64, F64]:
            """Return the factors of rows in fx, times their weights, and in fy, for rows above and below the middle."""
            in_x = np.multiply.outer(share[part], np.ones(fx.shape)) * np.sinc(np.multiply.outer(row[part], fx))
            return in_x, np.cos(2.0 * np.pi * np.multiply.outer(level[part], fy))

        if fx.ndim == fy.ndim == 2 and fx.shape[0] == fy.shape[1] == 1:
            in_x, in_y = rows(slice(None))
            total += product(in_y[..., 0].T, in_x[:, 0])
        else:
            for node in range(x.size):
                in_x, in_y = rows(node)
                total = total + in_x * in_y
        otf: F64 = total / self.area_um2
        return otf


@dataclass(frozen=True, slots=True, kw_only=True)
class PolygonPhotosite:
    """Any polygon that collects light evenly, such as an L next to a transistor.

    points_um : at least three corners (x, y) from the photosite's centre, µm, y down; the outline may not cross itself

    >>> corner = PolygonPhotosite(points_um=((-2, -2), (2, -2), (2, 0), (0, 0), (0, 2), (-2, 2)))
    >>> corner.area_um2
    12.0
    """

    place: ClassVar[str] = "photosite"

    points_um: Corners

    if TYPE_CHECKING:

        def __init__(self, *, points_um: Several[Place]) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        points = np.array(self.points_um)
        if len(set(self.points_um)) < 3:
            message = f"{len(set(self.points_um))} different points make no polygon; give at least 3"
            raise refusal(self, "points_um", message)
        crossing = _crossing(points)
        if crossing is not None:
            message = f"sides {crossing[0]} and {crossing[1]} cross; list the corners in order round the shape"
            raise refusal(self, "points_um", message)
        if abs(_doubled_area(points)) < 1e-12 * np.abs(points).max() ** 2:
            raise refusal(self, "points_um", "the polygon has no area; give corners that are not on one line")

    @property
    def half_extent_um(self) -> tuple[float, float]:
        """How far the photosite reaches from its centre along x and y, µm."""
        reach = np.abs(np.array(self.points_um)).max(axis=0)
        return float(reach[0]), float(reach[1])

    @property
    def area_um2(self) -> float:
        """Light-collecting area, µm²."""
        return 0.5 * abs(_doubled_area(np.array(self.points_um)))

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function, the mean of exp(+2πi f·a) over the area; complex, the same at every wavelength.

        The positive sign is due to correlation: a photosite whose area lies to the right of its centre has the image
        shifted to the left. The sum over edges has a closed form; at low frequencies, where it cancels, a quadrature
        rule is used.
        """
        fx, fy = np.broadcast_arrays(np.asarray(fx_per_um, float), np.asarray(fy_per_um, float))
        points = np.array(self.points_um)
        size = float(np.abs(points).max())
        low = (fx * fx + fy * fy) * size * size < LOW**2
        out = np.empty(fx.shape, complex)
        out[~low] = _by_edges(points, fx[~low], fy[~low]) / (0.5 * _doubled_area(points))
        fx, fy = fx[low], fy[low]
        waves = (weight * np.exp(2j * np.pi * (fx * x + fy * y)) for x, y, weight in _rule(points).tolist())
        out[low] = sum(waves)
        return out


def _doubled_area(points: F64) -> float:
    following = np.roll(points, -1, axis=0)
    return float(np.sum(points[:, 0] * following[:, 1] - following[:, 0] * points[:, 1]))


def _by_edges(points: F64, fx: F64, fy: F64) -> F64:
    """Return ∫ exp(2πi f·a) over a positive outline: −(i/2π|f|²) Σ (f × e)·exp(2πi f·m)·sinc(f·e)."""
    total = np.zeros(fx.shape, complex)
    for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
        edge, middle = b - a, 0.5 * (a + b)
        phase = np.exp(2j * np.pi * (fx * middle[0] + fy * middle[1]))
        total += (fx * edge[1] - fy * edge[0]) * phase * np.sinc(fx * edge[0] + fy * edge[1])
    transform: F64 = total * (-1j / (2.0 * np.pi * (fx * fx + fy * fy)))
    return transform


def _rule(points: F64) -> F64:
    """Return x, y and weights (n, 3) of a rule for the mean over a polygon.

    It is a collapsed Gauss rule over the triangles from the first corner, with signed weights.
    """
    x, w = gauss_legendre(NODES)
    x, w = 0.5 * (1.0 + x), 0.5 * w
    u, v = (axis.ravel() for axis in np.meshgrid(x, x, indexing="ij"))
    triangles = []
    for b, c in pairwise(points[1:]):
        p, q = b - points[0], c - points[0]
        nodes = points[0] + u[:, None] * (p + v[:, None] * (q - p))
        triangles.append(np.column_stack([nodes, np.outer(w, w).ravel() * u * (p[0] * q[1] - p[1] * q[0])]))
    rule = np.concatenate(triangles)
    rule[:, 2] /= rule[:, 2].sum()
    return rule


def _crossing(points: F64) -> tuple[int, int] | None:
    """Return two sides (counted from 1) that cross or touch without being neighbours; None if there are none."""
    ends = np.roll(points, -1, axis=0)
    (along_x, along_y), count = (ends - points).T[:, :, None], len(points)

    def left_of_sides(places: F64) -> F64:
        away_x, away_y = (places - points[:, None]).transpose(2, 0, 1)
        left: F64 = along_x * away_y - along_y * away_x
        return left

    straddles = left_of_sides(points) * left_of_sides(ends) <= 0.0
    found = np.argwhere(np.triu(straddles & straddles.T, 2)).tolist()
    return next(((i + 1, j + 1) for i, j in found if (i, j) != (0, count - 1)), None)
