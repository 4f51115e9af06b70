"""The decorator that makes a function a chart: validates its parameters and registers its name for files."""

from __future__ import annotations

import functools
import inspect
import itertools
import re
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal, ParamSpec, TypeAlias, TypeVar

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import Point, Positive, Several, check, validate
from camsim.errors import InvalidValueError, UnknownNameError, in_brief
from camsim.scene.primitives import Compound, Outlined, Primitive, Shape, flattened, numbered, turned
from camsim.scene.shapes import Disc, Polygon, Rectangle, Text
from camsim.spectra.curve import Spectrum

Place: TypeAlias = tuple[float, float]

MOST_SHAPES = 1_000_000
"""Most shapes of one chart: a few bytes of a file must not exhaust memory."""

Many: TypeAlias = Annotated[int, Ge(1), Le(100_000)]

_P = ParamSpec("_P")
_R = TypeVar("_R")
_COMMON = {
    "centre_um": "of the chart, from the optical axis",
    "rotate_deg": "of the chart about its centre, clockwise as displayed, degrees",
    "dark": "reflectance of what is dark",
    "light": "reflectance of the card behind it; left out, the scene's own background shows",
    "seed": "same seed, same chart",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart(Compound):
    """A chart: one shape that is painted as many.

    name       : name of the chart, as in files
    parameters : arguments of the chart's function; defaults are filled in
    shapes     : the ordinary shapes, in painter's order

    >>> from camsim.scene.charts import dot_grid
    >>> Chart(name="dot-grid", parameters={"spacing_um": 9, "radius_um": 2}) == dot_grid(spacing_um=9, radius_um=2)
    True
    """

    name: str
    parameters: Mapping[str, Any] = field(hash=False)
    shapes: tuple[Shape, ...] = field(init=False, repr=False, compare=False)
    _painted: tuple[Primitive, ...] | None = field(default=None, init=False, repr=False, compare=False)
    _surfaces: tuple[Any, ...] | None = field(default=None, init=False, repr=False, compare=False)

    if TYPE_CHECKING:

        def __init__(self, *, name: str, parameters: Mapping[str, Any]) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        draw = KNOWN.get(self.name)
        if draw is None:
            raise UnknownNameError("chart", self.name, KNOWN, key="name", stage="Chart")
        kinds = parameters(draw)
        for key in self.parameters:
            if key not in kinds:
                raise UnknownNameError("parameter", key, kinds, stage=draw.__name__)
        signature = inspect.signature(draw)
        try:
            given = signature.bind(**self.parameters)
        except TypeError as error:  # a parameter is missing
            raise InvalidValueError(in_brief(error), stage=draw.__name__) from None
        given.apply_defaults()
        complete = {key: check(value, kinds[key], key, draw.__name__) for key, value in given.arguments.items()}
        for key, others in INSTEAD.get(draw.__name__, {}).items():
            for other in others if complete[key] is not None else ():
                if complete[other] != signature.parameters[other].default:
                    raise refused(draw, other, f"does nothing together with {key!r}; leave one of them out")
        object.__setattr__(self, "parameters", complete)
        object.__setattr__(self, "shapes", tuple(draw(**complete)))
        self._count(self.shapes, deeper=0)

    def __reduce__(self) -> tuple[Any, tuple[()]]:
        """Return its parameters for pickling: workers redraw it, faster than unpickling thousands of shapes."""
        return functools.partial(Chart, name=self.name, parameters=self.parameters), ()

    @property
    def surfaces(self) -> tuple[Spectrum, ...]:
        """Distinct reflectances in painter's order; cached, as light and outlines both ask for them."""
        if self._surfaces is None:
            plain = all(issubclass(kind, Outlined) for kind in {*map(type, self.shapes)})
            parts: Iterable[Any] = self.shapes if plain else self.primitives()
            object.__setattr__(self, "_surfaces", numbered([one.reflectance for one in parts])[0])
        return self._surfaces or ()

    def primitives(self) -> Iterator[Primitive]:
        """Return the primitives of its shapes; cached, as spectra, outlines and the check all use them."""
        if self._painted is None:
            object.__setattr__(self, "_painted", tuple(flattened(self.shapes)))
        return iter(self._painted or ())


KNOWN: dict[str, Callable[..., Iterable[Shape]]] = {}
"""The functions that yield the shapes of each chart, by the names that files use."""


INSTEAD: dict[str, Mapping[str, tuple[str, ...]]] = {}
"""For each chart's function, parameters that make others meaningless."""


def instead(**others: tuple[str, ...]) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Declare which parameters of a chart's function must not be given together with another one."""

    def said(draw: Callable[_P, _R]) -> Callable[_P, _R]:
        INSTEAD[draw.__name__] = others
        return draw

    return said


def chart(draw: Callable[_P, Iterable[Shape]]) -> Callable[_P, Chart]:
    """Make a chart of a function that yields shapes in painter's order: parameters are validated by their types."""
    name = draw.__name__.replace("_", "-")
    KNOWN[name] = draw

    @functools.wraps(draw)
    def drawn(*_: _P.args, **given: _P.kwargs) -> Chart:
        return Chart(name=name, parameters=given)

    return drawn


@functools.cache
def parameters(draw: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a chart's parameters, with their limits."""
    kinds = typing.get_type_hints(inspect.unwrap(draw), include_extras=True)
    return {key: kind for key, kind in kinds.items() if key != "return"}


def meanings(draw: Callable[..., Any]) -> dict[str, str]:
    """Return what a chart's documentation says of each parameter (``name : what it is``).

    >>> from camsim.scene.charts import checkerboard
    >>> meanings(checkerboard)["side_um"]
    'side of a square'
    """
    found = dict(_COMMON)
    for line in re.sub(r"\n {6,}", " ", inspect.getdoc(draw) or "").splitlines():
        if said := re.match(r"(\w+(?:, \w+)*) +: +(.*)", line):
            found |= dict.fromkeys(said[1].split(", "), said[2])
    return {key: found[key] for key in parameters(draw)}


def refused(draw: Callable[..., Any], key: str, message: str) -> InvalidValueError:
    """Return the error of a chart about one of its parameters."""
    return InvalidValueError(message, key=key, stage=draw.__name__)


def with_densities(draw: Callable[..., Any], **fractions: float) -> None:
    """Raise for a reflectance of 0, which has no density."""
    for key, fraction in fractions.items():
        if fraction <= 0.0:
            raise refused(draw, key, "is 0, whose density has no end; give a fraction above 0")


def counted(draw: Callable[..., Any], key: str, shapes: float) -> None:
    """Raise for a chart with more shapes than memory holds."""
    if shapes > MOST_SHAPES:
        raise refused(draw, key, f"makes {shapes:.3g} shapes; a chart has at most {MOST_SHAPES}")


def periods(
    draw: Callable[..., Any],
    lp_per_mm: Several[Positive] | None,
    periods_um: Several[Positive] | None,
    keys: tuple[str, str] = ("lp_per_mm", "periods_um"),
) -> tuple[float, ...]:
    """Return the lengths of line pairs in µm, from frequencies or from periods, whichever is given."""
    if (lp_per_mm is None) == (periods_um is None):
        said = "missing" if lp_per_mm is None else "given twice"
        raise refused(draw, keys[0], f"{said}; give one of {keys[0]} and {keys[1]}")
    return tuple(1e3 / frequency for frequency in lp_per_mm or ()) if periods_um is None else tuple(periods_um)


def grid(rows: int, cols: int, step_x_um: float, step_y_um: float) -> Iterator[tuple[int, int, Place]]:
    """Yield row, column and centre of each place of a grid about 0, row by row."""
    for row, col in itertools.product(range(rows), range(cols)):
        yield row, col, ((col - 0.5 * (cols - 1)) * step_x_um, (row - 0.5 * (rows - 1)) * step_y_um)


@dataclass(frozen=True, slots=True)
class Card:
    """Placement of a chart: rotation about its centre, and translation."""

    centre_um: Point
    rotate_deg: float = 0.0

    def placed_um(self, points: Any) -> F64:
        """Return points (n, 2) of the chart as points of the scene."""
        placed: F64 = turned(np.asarray(points, np.float64), self.rotate_deg) + np.array(self.centre_um)
        return placed

    def polygon(self, points: Any, reflectance: Spectrum) -> Polygon:
        """Return a polygon by its corners."""
        return Polygon(points_um=self.placed_um(points), reflectance=reflectance)

    def rectangle(
        self, width_um: float, height_um: float, at_um: Place, reflectance: Spectrum, rotate_deg: float = 0.0
    ) -> Rectangle:
        """Return a rectangle about ``at_um``, turned by ``rotate_deg`` on the card."""
        (centre_um,) = self.placed_um([at_um])
        return Rectangle(
            width_um=width_um,
            height_um=height_um,
            centre_um=centre_um,
            rotate_deg=self.rotate_deg + rotate_deg,
            reflectance=reflectance,
        )

    def behind(self, width_um: float, height_um: float, reflectance: Spectrum | None) -> Iterator[Rectangle]:
        """Yield the card itself, if it has a reflectance."""
        if reflectance is not None:
            yield self.rectangle(width_um, height_um, (0.0, 0.0), reflectance)

    def cell(self, left_um: float, top_um: float, right_um: float, bottom_um: float, reflectance: Spectrum) -> Polygon:
        """Return a rectangle by its sides, so that neighbouring cells share the exact numbers of a common side."""
        corners = [(left_um, top_um), (right_um, top_um), (right_um, bottom_um), (left_um, bottom_um)]
        return self.polygon(corners, reflectance)

    def text(
        self, text: str, size_um: float, at_um: Place, align: Literal["left", "centre", "right"], reflectance: Spectrum
    ) -> Text:
        """Return a line of text whose middle, from top to bottom, lies at ``at_um``."""
        (placed_um,) = self.placed_um([at_um])
        return Text(
            text=text,
            size_um=size_um,
            at_um=placed_um,
            align=align,
            vertical="middle",
            rotate_deg=self.rotate_deg,
            reflectance=reflectance,
        )

    def disc(self, radius_um: float, at_um: Place, reflectance: Spectrum) -> Disc:
        """Return a disc about ``at_um``."""
        (centre_um,) = self.placed_um([at_um])
        return Disc(radius_um=radius_um, centre_um=centre_um, reflectance=reflectance)
