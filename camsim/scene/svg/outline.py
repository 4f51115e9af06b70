"""Elements to outlines: path data and the basic shapes as segments, transforms as matrices, lengths as user units."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from camsim.errors import InvalidValueError
from camsim.scene.svg.xml import Element

Segment: TypeAlias = tuple[Any, ...]
Matrix: TypeAlias = tuple[float, float, float, float, float, float]

IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_UNITS = {"": 1.0, "px": 1.0, "pt": 4.0 / 3.0, "pc": 16.0, "mm": 96.0 / 25.4, "cm": 96.0 / 2.54, "in": 96.0}
_ANGLES = {"": 1.0, "deg": 1.0, "grad": 0.9, "rad": 180.0 / math.pi, "turn": 360.0}
_WORDS = {
    "moveTo": "move",
    "lineTo": "line",
    "qCurveTo": "quadratic",
    "curveTo": "cubic",
    "arcTo": "arc",
    "closePath": "close",
}
_OF_TRANSFORM = {"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewX": (1,), "skewY": (1,)}


def length(text: str, whole: float | None = None) -> float:
    """Return a length in user units.

    whole : the length that is 100 %

    >>> length("1in"), length("50%", 20.0)
    (96.0, 10.0)
    """
    match = re.fullmatch(rf"({NUMBER})\s*([a-zA-Z]*|%)", text.strip())
    if match is None or (match[2] == "%" and whole is None) or (match[2] != "%" and match[2].lower() not in _UNITS):
        raise InvalidValueError(f"{text[:40]!r} is no length; give a number, or one of px, pt, pc, mm, cm, in")
    return float(match[1]) * (whole or 0.0) / 100.0 if match[2] == "%" else float(match[1]) * _UNITS[match[2].lower()]


def numbers(text: str) -> list[float]:
    """Return the numbers of a list, such as a polygon's points.

    >>> numbers("0,0 1-2.5e1")
    [0.0, 0.0, 1.0, -25.0]
    """
    if re.sub(rf"{NUMBER}|[\s,]", "", text, flags=re.ASCII):
        raise InvalidValueError(f"{text[:40]!r} holds something that is no number")
    if comma := _stray_comma(text):
        raise InvalidValueError(f"{text[:40]!r} has a comma that parts no numbers: {comma!r}")
    return [float(number) for number in re.findall(NUMBER, text)]


def share(text: str) -> float:
    """Return a number or a percentage, such as an opacity, as a number.

    >>> share("0.5"), share("50%")
    (0.5, 0.5)
    """
    match = re.fullmatch(rf"({NUMBER})(%?)", text.strip())
    if match is None:
        raise InvalidValueError(f"{text[:40]!r} must be one number, or a percentage")
    return float(match[1]) * (0.01 if match[2] else 1.0)


def _stray_comma(text: str) -> str:
    """Return a comma at which other programs stop reading, with the text before it; empty if none."""
    found = re.search(r"(?:^|[,A-DF-Za-df-z])\s*,", text)
    return found[0].strip() if found else ""


def times(one: Matrix, two: Matrix) -> Matrix:
    """Return the matrix that applies ``two`` first and then ``one``."""
    a, b, c, d, e, f = one
    p, q, r, s, t, u = two
    return a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, a * t + c * u + e, b * t + d * u + f


def matrix_of(text: str, *, styled: bool = False) -> Matrix:
    """Return the matrix of a transform attribute, or of a style.

    styled : angles and lengths need units, which attributes do not have; other programs ignore violations

    >>> matrix_of("translate(5) scale(2, 3)")
    (2.0, 0.0, 0.0, 3.0, 5.0, 0.0)
    """
    found, done = IDENTITY, re.sub(r"(\w+)\s*\(([^()]*)\)|[\s,]", "", text)
    if text.strip() == "none":
        return IDENTITY
    if done:
        raise InvalidValueError(f"the transform {text[:60]!r} is not understood")
    for name, inside in re.findall(r"(\w+)\s*\(([^()]*)\)", text):
        given = re.findall(rf"({NUMBER})([a-zA-Z%]*)", inside)
        values = [
            float(number) * _of_transform(name, k, styled).get(unit, 0.0 if float(number) == 0.0 else math.nan)
            for k, (number, unit) in enumerate(given)
        ]
        strange = re.sub(rf"{NUMBER}[a-zA-Z%]*|[\s,]", "", inside) or re.search(r"(?:^|,)\s*,|,\s*$", inside)
        if strange or len(given) not in _OF_TRANSFORM.get(name, ()) or not all(map(math.isfinite, values)):
            units = "; in a style angles and lengths have units, as 20deg and 3px, in an attribute they have none"
            why = units if any(map(math.isnan, values)) else ""
            raise InvalidValueError(f"the transform {name}({inside[:40]}) is not understood{why}")
        found = times(found, _transform(name, values))
    return found


def _of_transform(name: str, place: int, styled: bool) -> Mapping[str, float]:
    """Return the units that a number of a transform may have."""
    if name in ("matrix", "scale") or not styled:
        return {"": 1.0}
    units = _UNITS if name == "translate" or place > 0 else _ANGLES
    return {unit: size for unit, size in units.items() if unit}


def flattens(matrix: Matrix) -> bool:
    """Return whether a matrix is singular, so that nothing is painted.

    >>> flattens(matrix_of("scale(0)")), flattens(matrix_of("scale(1e-9)"))
    (True, False)
    """
    a, b, c, d, _, _ = matrix
    return not abs(a * d - b * c) > 1e-12 * (abs(a * d) + abs(b * c))


def _transform(name: str, given: Sequence[float]) -> Matrix:
    """Return the matrix of one function; numbers that it may do without are filled in."""
    if name == "matrix":
        a, b, c, d, e, f = given
        return a, b, c, d, e, f
    first, second, third = (*given, given[0] if name == "scale" else 0.0, 0.0)[:3]
    if name == "translate":
        return 1.0, 0.0, 0.0, 1.0, first, second
    if name == "scale":
        return first, 0.0, 0.0, second, 0.0, 0.0
    angle = math.radians(first)
    if name != "rotate":
        shear = math.tan(angle)
        return 1.0, shear * (name == "skewY"), shear * (name == "skewX"), 1.0, 0.0, 0.0
    turn = (math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle), second, third)
    return times(turn, (1.0, 0.0, 0.0, 1.0, -second, -third))


def path_segments(data: str) -> list[Segment]:
    """Return the segments of path data.

    >>> path_segments("M0 0h2a1 1 0 01-2 0z")
    [('move', 0.0, 0.0), ('line', 2.0, 0.0), ('arc', 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0), ('close',)]
    """
    from fontTools.pens.recordingPen import RecordingPen
    from fontTools.svgLib.path.parser import parse_path

    if strange := re.search(r"[^\sMmZzLlHhVvCcSsQqTtAaEe\d.,+-]|[Ee](?![-+]?\d)", data, flags=re.ASCII):
        raise InvalidValueError(f"the path data hold {strange[0]!r}")
    if comma := _stray_comma(data):
        raise InvalidValueError(f"the path data hold {comma!r}, a comma that parts no numbers")
    # fontTools knows neither leading zeros (but of an arc, where 01 may be two flags) nor lines between flags.
    plain = re.sub(r"\s+", " ", data)
    parts = re.split(r"([Aa][^A-DF-Za-df-z]*)", plain)
    parts[::2] = [re.sub(r"(?<![\d.])0+(?=\d)", "", part) for part in parts[::2]]
    pen = RecordingPen()
    pen.arcTo = lambda *arc: pen.value.append(("arcTo", (map(float, arc[:-1]), arc[-1])))
    try:
        parse_path("".join(parts), pen)
    except (ValueError, IndexError, OverflowError):
        raise InvalidValueError(f"the path data {plain[:40]!r} … are cut short or damaged") from None
    return [(_WORDS[word], *itertools.chain(*points)) for word, points in pen.value if word in _WORDS]


def segments_of(element: Element, whole: tuple[float, float]) -> list[Segment]:
    """Return the outline of a basic shape or path, in its user units; empty if it draws nothing.

    whole : width and height of the view, for percentages
    """
    diagonal = math.hypot(*whole) / math.sqrt(2.0)

    def of(key: str, percent_of: float, default: float = 0.0) -> float:
        text = element.attributes.get(key)
        return default if text is None or text == "auto" else length(text, percent_of)

    tag = element.tag
    if tag == "path":
        return path_segments(element.attributes.get("d", ""))
    if tag in ("polyline", "polygon"):
        values = numbers(element.attributes.get("points", ""))
        if len(values) % 2:
            raise InvalidValueError(f"its {len(values)} numbers are no points")
        corners = [("line" if i else "move", values[i], values[i + 1]) for i in range(0, len(values), 2)]
        return [*corners, ("close",)] if tag == "polygon" and corners else list(corners)
    if tag == "line":
        x1, x2 = of("x1", whole[0]), of("x2", whole[0])
        return [("move", x1, of("y1", whole[1])), ("line", x2, of("y2", whole[1]))]
    rx, ry = of("rx", whole[0], -1.0), of("ry", whole[1], -1.0)
    rx, ry = (ry if rx < 0.0 else rx), (rx if ry < 0.0 else ry)
    if tag == "rect":
        wide, high = of("width", whole[0]), of("height", whole[1])
        return _rectangle(of("x", whole[0]), of("y", whole[1]), wide, high, (rx, ry))
    if tag == "circle":
        rx = ry = of("r", diagonal)
    x, y = of("cx", whole[0]), of("cy", whole[1])
    if rx <= 0.0 or ry <= 0.0:
        return []
    half = ("arc", rx, ry, 0.0, 0.0, 1.0)
    return [("move", x + rx, y), (*half, x - rx, y), (*half, x + rx, y), ("close",)]


def _rectangle(x: float, y: float, wide: float, high: float, radii: tuple[float, float]) -> list[Segment]:
    if wide <= 0.0 or high <= 0.0:
        return []
    rx, ry = min(max(radii[0], 0.0), 0.5 * wide), min(max(radii[1], 0.0), 0.5 * high)
    right, bottom = x + wide, y + high
    if rx == 0.0 or ry == 0.0:
        return [("move", x, y), ("line", right, y), ("line", right, bottom), ("line", x, bottom), ("close",)]
    bend = ("arc", rx, ry, 0.0, 0.0, 1.0)
    return [
        *(("move", x + rx, y), ("line", right - rx, y), (*bend, right, y + ry), ("line", right, bottom - ry)),
        *((*bend, right - rx, bottom), ("line", x + rx, bottom), (*bend, x, bottom - ry), ("line", x, y + ry)),
        *((*bend, x + rx, y), ("close",)),
    ]


def dashes_of(style: Mapping[str, str], diagonal: float) -> tuple[list[float], float]:
    """Return the lengths of a stroke's dashes and gaps, empty if solid, and the offset."""
    said = style["stroke-dasharray"]
    given = [] if said == "none" else [length(part, diagonal) for part in re.split(r"[\s,]+", said.strip())]
    # A negative length is an error that SVG ignores.
    return ([] if min(given, default=0.0) < 0.0 else given), length(style["stroke-dashoffset"], diagonal)
