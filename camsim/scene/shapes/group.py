"""Shapes together: moved, turned, scaled and mirrored, clipped, or repeated on a grid or a ring."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import Count, Number, Place, Point, Positive, Several, Truth, Whole, refusal, validate
from camsim.scene.curves import joined
from camsim.scene.primitives import Compound, Fill, Primitive, Shape, flattened, turned

Matrix = tuple[float, float, float, float, float, float]
Finite = Annotated[float, Ge(-1e6), Le(1e6)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Group(Compound):
    """Shapes that are mirrored, scaled, turned and moved together, in this order, all about the origin.

    mirror    : "left-right" or "up-down"
    scale     : factors along x and along y
    turn_deg  : rotation, clockwise as displayed
    move_um   : displacement to the right and down
    matrix    : instead of all these, (a, b, c, d, e, f) as in SVG: x, y → a·x + c·y + e, b·x + d·y + f, µm
    clip      : nothing outside this shape is painted; it moves with the group, and its reflectance plays no part

    >>> from camsim.scene import Disc
    >>> Group(shapes=[Disc(radius_um=5.0, reflectance=0.1)], scale=(2.0, 1.0), move_um=(10.0, 0.0)).shapes[0].radius_um
    5.0
    """

    shapes: Several[Shape]
    mirror: Literal["left-right", "up-down"] | None = None
    scale: Positive | tuple[Positive, Positive] = 1.0
    turn_deg: Finite = 0.0
    move_um: Point = (0.0, 0.0)
    matrix: Matrix | None = None
    clip: Shape | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            shapes: Several[Shape],
            mirror: Literal["left-right", "up-down"] | None = None,
            scale: Number | tuple[Number, Number] = 1.0,
            turn_deg: Number = 0.0,
            move_um: Place = (0.0, 0.0),
            matrix: Several[Number] | None = None,
            clip: Shape | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        self._count((*self.shapes, *(() if self.clip is None else (self.clip,))))
        if self.matrix is not None:
            a, b, c, d, _, _ = self.matrix
            if (self.mirror, self.scale, self.turn_deg, tuple(self.move_um)) != (None, 1.0, 0.0, (0.0, 0.0)):
                raise refusal(self, "matrix", "given together with mirror, scale, turn_deg or move_um; leave one out")
            if not abs(a * d - b * c) > 1e-12 * (abs(a * d) + abs(b * c)):
                raise refusal(self, "matrix", "flattens all shapes to a line; its first four numbers must not")
        if self.clip is not None and any(len(primitive.layers) > 1 for primitive in self.clip.primitives()):
            raise refusal(self, "clip", "is clipped itself; clip this group in another group")

    def primitives(self) -> Iterator[Primitive]:
        """Return the primitives of the transformed shapes."""
        matrix = self._matrix
        clip: tuple[tuple[Fill, ...], ...] = ()
        if self.clip is not None:
            clip = (tuple(fill for primitive in self.clip.primitives() for fill in primitive.fills),)
            if not clip[0]:
                return  # an empty clip removes everything
        for primitive in flattened(self.shapes):
            clipped = primitive._replace(layers=primitive.layers + clip) if clip else primitive
            yield clipped if matrix is None else clipped.moved(matrix)

    @property
    def _matrix(self) -> F64 | None:
        """The linear map (2, 3); None for the identity."""
        if self.matrix is not None:
            return np.array(self.matrix).reshape(3, 2).T
        x, y = self.scale if isinstance(self.scale, tuple) else (self.scale, self.scale)
        x, y = (-x if self.mirror == "left-right" else x), (-y if self.mirror == "up-down" else y)
        matrix = np.column_stack([_turn(self.turn_deg) * [x, y], self.move_um])
        return None if np.array_equal(matrix, np.eye(2, 3)) else matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatOnGrid(Compound):
    """Shapes repeated in rows and columns, row by row, about where they are given.

    step_um : distance from one column to the next, and from one row to the next

    >>> from camsim.scene import Disc
    >>> RepeatOnGrid(shapes=[Disc(radius_um=5.0, reflectance=0.1)], rows=2, cols=3, step_um=(20.0, 20.0)).cols
    3
    """

    shapes: Several[Shape]
    cols: Count = 1
    rows: Count = 1
    step_um: Point

    if TYPE_CHECKING:

        def __init__(self, *, shapes: Several[Shape], cols: Whole = 1, rows: Whole = 1, step_um: Place) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        self._count(self.shapes, copies=self.cols * self.rows)

    def primitives(self) -> Iterator[Primitive]:
        """Return all copies."""
        each = flattened(self.shapes)
        for row in range(self.rows):
            for col in range(self.cols):
                place = (col - 0.5 * (self.cols - 1), row - 0.5 * (self.rows - 1))
                by_um = np.array(self.step_um) * place
                yield from (primitive.shifted(by_um) for primitive in each)


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatOnRing(Compound):
    """Shapes repeated on a ring: copies, evenly turned about a centre, the first as it is given.

    upright : copies keep their direction: they are translated with the centre of their bounding box

    >>> from camsim.scene import Disc
    >>> RepeatOnRing(shapes=[Disc(radius_um=5.0, centre_um=(40.0, 0.0), reflectance=0.1)], count=6).count
    6
    """

    shapes: Several[Shape]
    count: Count
    centre_um: Point = (0.0, 0.0)
    upright: bool = False

    if TYPE_CHECKING:

        def __init__(
            self, *, shapes: Several[Shape], count: Whole, centre_um: Place = (0.0, 0.0), upright: Truth = False
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        self._count(self.shapes, copies=self.count)

    def primitives(self) -> Iterator[Primitive]:
        """Return all copies."""
        each = flattened(self.shapes)
        centre = np.array(self.centre_um)
        middle = self._middle(each) if self.upright else centre
        for copy in range(self.count):
            turn = _turn(360.0 * copy / self.count)
            orientation = np.eye(2) if self.upright else turn
            # Translate ``middle`` to its rotated position.
            moved = centre + np.einsum("ij,j->i", turn, middle - centre) - np.einsum("ij,j->i", orientation, middle)
            yield from (primitive.moved(np.column_stack([orientation, moved])) for primitive in each)

    @staticmethod
    def _middle(each: list[Primitive]) -> F64:
        """Centre of the bounding box of the repeated shapes; of clipped ones, of the intersection of boxes."""
        boxes = []
        for one in each:
            layers = np.array([joined([fill.curves for fill in layer]).extent for layer in one.layers])
            low, high = layers[:, :2].max(axis=0), layers[:, 2:].min(axis=0)
            if (low <= high).all():
                boxes.append([low, high])
        if not boxes:
            return np.zeros(2)
        middle: F64 = 0.5 * (np.min(boxes, axis=0)[0] + np.max(boxes, axis=0)[1])
        return middle


def _turn(degrees: float) -> F64:
    """Return the matrix of a rotation clockwise as displayed."""
    return turned(np.eye(2), degrees).T
