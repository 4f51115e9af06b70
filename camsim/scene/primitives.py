"""Primitives of shapes: closed outlines with a fill rule, and a spectrum."""

from __future__ import annotations

import abc
import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.typed import refusal, validate
from camsim.errors import InvalidValueError
from camsim.numerics.rotations import cosine_and_sine
from camsim.scene.curves import Curves
from camsim.spectra.curve import Spectrum

MOST_PIECES = 5_000_000
"""Most sides and curves of a scene; more are refused before memory is allocated."""

MOST_DEPTH = 64
"""Most levels of nested groups."""

FillRule = Literal["nonzero", "evenodd"]


class Fill(NamedTuple):
    """The interior of loops, where the winding number is not zero or, by the other rule, odd.

    simple : whether no loop crosses itself or another one, and all but the first are holes in the first
    """

    curves: Curves
    rule: FillRule = "nonzero"
    simple: bool = False


class Primitive(NamedTuple):
    """One painted area: the points that lie in a fill of every layer, where the layers are a shape and its clips."""

    layers: tuple[tuple[Fill, ...], ...]
    reflectance: Spectrum

    def moved(self, matrix: F64) -> Primitive:
        """Return the primitive transformed by a linear map (2, 3)."""
        return self._changed(lambda curves: curves.moved(matrix))

    def shifted(self, by_um: F64) -> Primitive:
        """Return the primitive translated by a vector."""
        return self._changed(lambda curves: curves.shifted(by_um))

    def _changed(self, change: Callable[[Curves], Curves]) -> Primitive:
        layers = [tuple(fill._replace(curves=change(fill.curves)) for fill in layer) for layer in self.layers]
        return self._replace(layers=tuple(layers))

    @property
    def fills(self) -> Iterator[Fill]:
        """All fills, layer by layer."""
        return (fill for layer in self.layers for fill in layer)

    @property
    def simple(self) -> bool:
        """Whether the primitive is one outline with holes, without crossings."""
        return len(self.layers) == 1 and len(self.layers[0]) == 1 and self.layers[0][0].simple


class Paints(Protocol):
    """Protocol of objects that can be painted."""

    def primitives(self) -> Iterator[Primitive]:
        """Return the primitives in painter's order; lengths in µm."""
        ...


class Shape(Paints, Protocol):
    """Protocol of the parts that a scene is made of.

    depth, pieces : nesting of groups, and number of sides and curves; a shape counts them before it makes them
    """

    __slots__ = ()

    @property
    def depth(self) -> int: ...  # noqa: D102 (above)

    @property
    def pieces(self) -> int: ...  # noqa: D102


class Outlined(Shape):
    """A shape of one outline, which may have holes, in one colour."""

    __slots__ = ()

    depth: ClassVar[int] = 0

    reflectance: Any

    def __post_init__(self) -> None:
        validate(self)

    @property
    def pieces(self) -> int:
        """Sides and curves."""
        return len(self._outline().kind)

    def primitives(self) -> Iterator[Primitive]:
        """Return its outline."""
        yield one(self._outline(), self.reflectance, rule="evenodd", simple=True)

    @abc.abstractmethod
    def _outline(self) -> Curves: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Compound(Shape):
    """A shape that is made of others."""

    depth: int = field(init=False, repr=False, compare=False)
    pieces: int = field(init=False, repr=False, compare=False)

    def _count(self, shapes: Iterable[Shape], *, copies: int = 1, deeper: int = 1) -> None:
        try:
            depth, pieces = counted(shapes, copies=copies, deeper=deeper)
        except InvalidValueError as error:
            raise refusal(self, "shapes", error.message) from None
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "pieces", pieces)


def flattened(shapes: Iterable[Paints]) -> list[Primitive]:
    """Return the primitives of shapes in painter's order; no groups, repeats or transforms are left.

    >>> from camsim.scene import Disc, Group
    >>> group = Group(shapes=[Disc(radius_um=1.0, reflectance=0.0)], move_um=(3.0, 0.0), scale=2.0)
    >>> [primitive] = flattened([group])
    >>> primitive.layers[0][0].curves.boxes
    array([[ 1., -2.,  5.,  2.]])
    """
    painted: list[Primitive] = []
    for kind, alike in itertools.groupby(shapes, type):
        same, together = list(alike), getattr(kind, "together", None)  # thousands of discs are converted together
        painted.extend(together(same) if together else (one for shape in same for one in shape.primitives()))
    return painted


def numbered(spectra: Sequence[Spectrum]) -> tuple[tuple[Spectrum, ...], I64]:
    """Return the distinct spectra in order, and the index of each.

    >>> numbered([0.5, 0.2, 0.5])
    ((0.5, 0.2), array([0, 1, 0]))
    """
    distinct: dict[Spectrum, int] = {}
    objects = [*map(id, spectra)]
    each = dict(zip(objects, spectra, strict=True))  # curves are hashed by content: each object once
    known = {number: distinct.setdefault(spectrum, len(distinct)) for number, spectrum in each.items()}
    return tuple(distinct), np.fromiter(map(known.__getitem__, objects), np.int64, len(objects))


def counted(shapes: Iterable[Shape], *, copies: int = 1, deeper: int = 0) -> tuple[int, int]:
    """Return depth and pieces of some shapes together; raises InvalidValueError where there are too many."""
    shapes = tuple(shapes)
    depth = deeper + max((shape.depth for shape in shapes), default=0)
    pieces = copies * sum(shape.pieces for shape in shapes)
    if depth > MOST_DEPTH:
        raise InvalidValueError(f"groups lie {depth} deep in one another; the most is {MOST_DEPTH}", key="shapes")
    if pieces > MOST_PIECES:
        raise InvalidValueError(f"makes {pieces} sides and curves; the most is {MOST_PIECES}", key="shapes")
    return depth, pieces


def one(curves: Curves, reflectance: Spectrum, *, rule: FillRule = "nonzero", simple: bool = False) -> Primitive:
    """Return a primitive of one fill."""
    return Primitive(((Fill(curves, rule, simple),),), reflectance)


def turned(points: F64, rotate_deg: float) -> F64:
    """Return points or vectors (n, 2) rotated about the origin, clockwise as displayed."""
    c, s = cosine_and_sine(rotate_deg)
    matrix = np.array([[c, -s], [s, c]])
    turned_points: F64 = np.einsum("ij,nj->ni", matrix, points)
    return turned_points
