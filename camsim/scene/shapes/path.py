"""A path: straight lines, Bézier curves and elliptical arcs, filled by one of two rules."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from camsim.core.annotations import After, Called
from camsim.core.number_kinds import Misfit, number
from camsim.core.typed import Several, refusal, validate
from camsim.core.words import DECIMAL_POINT
from camsim.errors import InvalidValueError
from camsim.scene.curves import Curves, Pen
from camsim.scene.primitives import MOST_PIECES, FillRule, Outlined, Primitive, one
from camsim.spectra.curve import NumberOrCurve, Reflectance

Segment = tuple[Any, ...]

NUMBERS: Mapping[str, int] = {"move": 2, "line": 2, "quadratic": 4, "cubic": 6, "arc": 7, "close": 0}
"""Count of numbers after each word; the last two are the end point, those of an arc are in SVG's order."""

_COORDINATE = number(float, ())
_FLAGS = 4, 5  # indices of an arc's flags: large arc, and sweep direction


def segments(given: Sequence[Any]) -> tuple[Segment, ...]:
    """Return a path's segments in canonical form; raises InvalidValueError with the index of a wrong one."""
    if len(given) > MOST_PIECES:
        raise InvalidValueError(f"{len(given)} segments; the most is {MOST_PIECES}", key="segments_um")
    made = tuple(_segment(index, segment) for index, segment in enumerate(given))
    if made and made[0][0] != "move":
        raise InvalidValueError(f"begins with {made[0][0]!r}; a path begins with ('move', x, y)", key="segments_um")
    return made


def _segment(index: int, given: Any) -> Segment:
    words = f"a segment such as ('line', x, y): one of {', '.join(NUMBERS)}, and its numbers"
    if not isinstance(given, list | tuple) or not given or given[0] not in NUMBERS:
        raise Misfit(words, given, item=str(index))
    word, *numbers = given
    count = NUMBERS[word]
    if len(numbers) != count:
        hint = DECIMAL_POINT if count and len(numbers) == 2 * count else ""
        raise Misfit(f"{word!r} and {count} numbers", given, item=str(index), hint=hint)
    flags = _FLAGS if word == "arc" else ()
    return (word, *(_number(value, f"{index}.{k}", flag=k in flags) for k, value in enumerate(numbers, 1)))


def _number(given: Any, item: str, *, flag: bool) -> float:
    """Return one of a segment's numbers; texts are refused, as lengths of a file are already scaled."""
    truth = flag and isinstance(given, bool | np.bool_)
    try:
        value: float = _COORDINATE.take(float(given) if truth else given)
    except Misfit as error:
        raise Misfit(error.words, given, item=item, hint=error.hint) from None
    if flag and value not in (0.0, 1.0):
        raise Misfit("0 or 1, as the flags of an arc are", value, item=item)
    return value


Segments = Annotated[Several[Any], Called("a list of segments"), After(segments)]


class Drawn(Outlined):
    """A filled drawing of a pen."""

    __slots__ = ()

    _curves: Curves

    def _outline(self) -> Curves:
        return self._curves

    def primitives(self) -> Iterator[Primitive]:
        """Return the enclosed area."""
        if self.pieces:
            yield one(self._curves, self.reflectance, rule=getattr(self, "fill_rule", "nonzero"))

    def _keep(self, pen: Pen, what: str) -> None:
        curves = pen.curves()
        if not math.isfinite(float(abs(curves.points).sum())):
            raise refusal(self, "segments_um", f"its numbers are too far apart to draw {what} through them")
        object.__setattr__(self, "_curves", curves)


@dataclass(frozen=True, slots=True, kw_only=True)
class Path(Drawn):
    """The area enclosed by outlines; each begins with a ``move`` and is closed by a straight line.

    segments_um : ("move", x, y), ("line", x, y), ("quadratic", x1, y1, x, y), ("cubic", x1, y1, x2, y2, x, y),
                  ("arc", rx, ry, rotate_deg, large, sweep, x, y), ("close",), µm
    fill_rule   : "nonzero": inside is where the outlines wind about a place; "evenodd": where they do so an odd number
                  of times

    >>> Path(segments_um=[("line", 1, 0)], reflectance=0.0)
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: Path.segments_um: begins with 'line'; a path begins with ('move', x, y)
    """

    segments_um: Segments
    fill_rule: FillRule = "nonzero"
    reflectance: Reflectance
    _curves: Curves = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:

        def __init__(
            self, *, segments_um: Segments, fill_rule: FillRule = "nonzero", reflectance: NumberOrCurve
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        pen = Pen()
        for word, *numbers in self.segments_um:
            getattr(pen, word)(*numbers)
        self._keep(pen, "an arc")

    @classmethod
    def of(cls, area: Any, *, reflectance: NumberOrCurve, fill_rule: FillRule = "evenodd") -> Path:
        """Return what an area covers: a polygon or multipolygon of Shapely's, or corners (n, 2), µm.

        Holes stay holes; an outline of corners may cross itself.

        >>> import shapely
        >>> Path.of(shapely.box(0, 0, 2, 1), reflectance=0.5).pieces
        4
        """
        return cls(segments_um=_segments_of(area), fill_rule=fill_rule, reflectance=reflectance)


def _segments_of(area: Any) -> list[Segment]:
    kind = getattr(area, "geom_type", None)
    if kind is None:
        rings = [np.asarray(area, dtype=object)]
    else:
        import shapely

        whole = shapely.polygons(area) if kind == "LinearRing" else area
        parts = shapely.get_parts(whole)
        if not len(parts) or any(part.geom_type != "Polygon" or part.is_empty for part in parts):
            what = f"an empty {kind}" if area.is_empty else f"a {kind} of Shapely's"
            raise InvalidValueError(
                f"must be a Polygon, MultiPolygon or LinearRing, not {what}; give lines a width by .buffer",
                key="area",
                stage="Path.of",
            )
        rings = [shapely.get_coordinates(ring)[:-1] for part in parts for ring in (part.exterior, *part.interiors)]
    segments: list[Segment] = []
    for ring in rings:
        if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3:
            message = f"must be at least 3 corners (n, 2), or an area of Shapely's, not an array of shape {ring.shape}"
            raise InvalidValueError(message, key="area", stage="Path.of")
        segments += [("line" if number else "move", x, y) for number, (x, y) in enumerate(ring.tolist())]
        segments.append(("close",))
    return segments
