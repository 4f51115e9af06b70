"""Conversion of a drawing's elements to shapes in painter's order, and of unsupported ones to faults."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path as File
from typing import Any, TypeVar

from camsim.errors import CamsimError, ConfigError, Fault
from camsim.scene.primitives import FillRule
from camsim.scene.shapes import Group, Line, Path
from camsim.scene.svg import colours
from camsim.scene.svg.outline import (
    IDENTITY,
    NUMBER,
    SHAPES,
    Matrix,
    Segment,
    dashes_of,
    flattens,
    length,
    matrix_of,
    segments_of,
    share,
    times,
)
from camsim.scene.svg.style import CHANGES, GEOMETRY, INHERITED, OF_PAGE, OWN, PLAIN, Rule, rules_of, strange, styled
from camsim.scene.svg.view import View, view_of
from camsim.scene.svg.xml import Element, read_elements
from camsim.spectra.curve import Spectrum

MOST_FAULTS = 20
MOST_NUMBERS = 1_000_000
MOST_ELEMENTS = 100_000
MOST_USES = 20

_GROUPS = ("svg", "g", "a", "use")
_UNSEEN = (
    *("defs", "title", "desc", "metadata", "style", "clipPath", "symbol", "linearGradient", "radialGradient"),
    *("pattern", "mask", "filter", "marker", "font", "view", "cursor", "color-profile"),
)
_CONDITIONS = "systemLanguage", "requiredExtensions"  # conditions for rendering an element
_MOVEMENTS = "animate", "animateTransform", "animateMotion", "set"
_WAYS_OUT = {
    "text": "letters are not supported; turn them into paths (Inkscape: Path > Object to Path)",
    "image": "pictures in a drawing are not supported; a scene takes them as shapes",
    "script": "scripts are not run; save the drawing as it looks",
    "switch": "is not supported; keep what is to be seen",
    "foreignObject": "holds what is no drawing; remove it",
    "opacity": "paint it in the colour that this makes",
    "mask": "use a clip-path",
    "transform-origin": "write the transform as about the origin",
    **dict.fromkeys(("translate", "rotate", "scale", "zoom"), "write it as a transform"),
    **dict.fromkeys(("transform", "clip-path"), "give it to a group of all that is in the page"),
    **dict.fromkeys(("background", "background-color", "background-image"), "draw a rectangle behind all"),
    **dict.fromkeys(_MOVEMENTS, "movements are not shown; save the drawing as it looks"),
    **dict.fromkeys(_CONDITIONS, "keep what is to be seen"),
    **dict.fromkeys(GEOMETRY, "say it by an attribute, not in a style"),
}

T = TypeVar("T")


class Reader:
    """A drawing being read; unsupported content is collected and reported together."""

    def __init__(self, file: File, name: str, palette: Mapping[str, Spectrum]) -> None:
        self.name = name
        self.root = read_elements(file, name)
        self.faults: list[Fault] = []
        self.rules: list[Rule] = rules_of(self.root, self.refuse)
        self.known: dict[str, Element] = {}  # for a duplicate id, the first
        self.around: dict[int, Element] = {}  # parent of every element
        for element in self.root.all():
            self.known.setdefault(element.attributes.get("id", ""), element)
            self.around |= {id(child): element for child in element.children}
        self.known.pop("", None)
        self.palette = {colours.rgb(colour): spectrum for colour, spectrum in palette.items()}
        if found := _too_large(self.root, self.known):
            self.refuse(*found)
            raise ConfigError(self.faults)

    def shapes(self) -> tuple[View, list[Any]]:
        """Return the view, and the painted shapes in its px; raises ConfigError with all unsupported content."""
        view = self._tried(self.root, lambda: view_of(self.root)) or View(1.0, 1.0, IDENTITY, (1.0, 1.0))
        self.view = view
        found = list(self._painted(self.root, view.matrix, {}, ()))
        if self.faults:
            raise ConfigError(self.faults[:MOST_FAULTS])
        return view, found

    def refuse(self, element: Element, message: str) -> None:
        """Record unsupported content of an element."""
        where = f"<{element.tag}>"
        fault = Fault(self.name, element.line, element.column, where, message)
        if fault not in self.faults:
            self.faults.append(fault)

    def _tried(self, element: Element, make: Callable[[], T]) -> T | None:
        """Return the result of ``make``, or None if it is refused."""
        try:
            return make()
        except ConfigError:
            raise
        except CamsimError as error:
            self.refuse(element, error.message)
            return None

    def _painted(
        self, element: Element, matrix: Matrix, above: Mapping[str, str], used: tuple[str, ...]
    ) -> Iterator[Any]:
        """Yield the shapes of an element and its descendants.

        used : ids of the enclosing <use> elements
        """
        if len(self.faults) >= MOST_FAULTS:
            return
        tag = element.tag
        if tag in _UNSEEN and not (used and tag == "symbol"):
            return
        style = styled(element, above, self.rules)
        if style["display"] == "none" or not self._understood(element, style):
            return
        moved = self._moved(element, style)
        if moved is None:
            return
        matrix = times(matrix, moved)
        if flattens(matrix):
            return
        boxed = "viewBox" in element.attributes and element is not self.root
        if boxed or tag not in (*_GROUPS, *SHAPES, "symbol"):
            self.refuse(
                element, _WAYS_OUT.get(tag, f"{'with a viewBox ' if boxed else ''}is not supported; ungroup it")
            )
            return
        inside = list(self._inside(element, matrix, style, used))
        if not inside:
            return
        if style["clip-path"] == "none":
            yield from inside
        elif clip := self._clip(element, style["clip-path"], matrix):
            yield Group(shapes=inside, clip=clip)

    def _inside(
        self, element: Element, matrix: Matrix, style: Mapping[str, str], used: tuple[str, ...]
    ) -> Iterator[Any]:
        if element.tag in SHAPES:
            yield from self._fill_and_stroke(element, matrix, style)
        elif element.tag == "use":
            yield from self._used(element, matrix, style, used)
        elif element.tag == "svg" and element is not self.root:
            self.refuse(element, "a drawing inside a drawing is not supported; ungroup it")
        else:
            for child in element.children:
                yield from self._painted(child, matrix, style, used)

    def _used(self, element: Element, matrix: Matrix, style: Mapping[str, str], used: tuple[str, ...]) -> Iterator[Any]:
        link = element.attributes.get("href", "")
        identity = link.removeprefix("#")
        if not link:
            self.refuse(element, "has no href and shows nothing; remove it")
        elif not link.startswith("#"):
            self.refuse(element, f"refers to {link[:60]!r}, outside this file; a drawing holds all that it shows")
        elif identity not in self.known:
            self.refuse(element, f"refers to {link[:60]!r}, which is not there")
        elif len(used) >= MOST_USES:
            self.refuse(element, f"is used by others more than {MOST_USES} deep")
        elif identity in used:
            self.refuse(element, f"uses itself by way of {link[:60]!r}")
        else:
            found = self.known[identity]
            drawn = list(self._painted(found, matrix, style, (*used, identity)))
            yield from drawn if found.tag != "symbol" else self._within(found, drawn, matrix, element.attributes)

    def _moved(self, element: Element, style: Mapping[str, str]) -> Matrix | None:
        """Return the transform of an element in its parent; it includes x and y of a <use>, and applies to its clip."""
        said, given = style["transform"], element.attributes

        def make() -> Matrix:
            matrix = matrix_of(said, styled=said != given.get("transform", "").strip())
            if element.tag != "use":
                return matrix
            x, y = (length(given.get(key, "0"), whole) for key, whole in zip("xy", self.view.whole, strict=True))
            return times(matrix, (1.0, 0.0, 0.0, 1.0, x, y))

        return self._tried(element, make)

    def _within(self, symbol: Element, drawn: list[Any], matrix: Matrix, given: Mapping[str, str]) -> Iterator[Any]:
        """Yield the visible part of a symbol: clipped to its view unless it may overflow."""
        if any(symbol.attributes.get(key, "0") not in ("0", "0px") for key in "xy"):  # few programs support these
            self.refuse(symbol, "has a position; give x and y to its <use>")
            return
        style = styled(symbol, {}, self.rules)
        if not drawn or style["overflow"] in ("visible", "auto"):
            yield from drawn
            return
        if style["transform"]:  # programs differ on whether its view is transformed too
            self.refuse(symbol, "has a transform, and shows no more than its view; transform its <use>")
            return
        sizes: list[float] = []
        for key, whole in zip(("width", "height"), self.view.whole, strict=True):
            said = given.get(key, symbol.attributes.get(key, "100%"))
            size = self._tried(symbol, functools.partial(length, said, whole))
            if size is not None and size < 0.0:
                self.refuse(symbol, f"is shown with the {key} {said[:40]!r}; give one of 0 or more")
            if size is None or size < 0.0:
                return
            sizes.append(size)
        wide, high = sizes
        corners = [("move", 0.0, 0.0), ("line", wide, 0.0), ("line", wide, high), ("line", 0.0, high), ("close",)]
        yield Group(shapes=drawn, clip=path(corners, "nonzero", 0.0, matrix))

    def _fill_and_stroke(self, element: Element, matrix: Matrix, style: Mapping[str, str]) -> Iterator[Any]:
        if style["visibility"] != "visible":
            return
        segments = self._tried(element, lambda: segments_of(element, self.view.whole))
        if not segments:
            return
        painted = []
        if element.tag != "line" and (fill := self._paint(element, style, "fill")) is not None:
            painted.append(self._tried(element, lambda: path(segments, style["fill-rule"], fill, matrix)))
        if (stroke := self._paint(element, style, "stroke")) is not None:
            line = self._stroked(element, segments, style, stroke)
            painted += [] if line is None else [self._tried(element, lambda: placed(line, matrix))]
        if None in painted:
            return
        order = style["paint-order"].split()
        stroke_first = "stroke" in order and "fill" not in order[: order.index("stroke")]
        yield from reversed(painted) if stroke_first else painted

    def _stroked(
        self, element: Element, segments: Sequence[Segment], style: Mapping[str, str], colour: Spectrum
    ) -> Line | None:
        diagonal = math.hypot(*self.view.whole) / math.sqrt(2.0)
        width = self._tried(element, lambda: length(style["stroke-width"], diagonal))
        limit = self._tried(element, lambda: share(style["stroke-miterlimit"]))
        dashes = self._tried(element, lambda: dashes_of(style, diagonal))
        if not width or limit is None or dashes is None:
            return None
        if width < 0.0:  # programs differ: none, or the default width
            self.refuse(element, f"its stroke-width {style['stroke-width'][:40]!r} is below 0; give one of 0 or more")
            return None
        if any(dashes[0]) and "pathLength" in element.attributes:
            self.refuse(element, "has dashes in shares of a pathLength; give their lengths in user units")
            return None
        cap, join = style["stroke-linecap"], style["stroke-linejoin"]
        return self._tried(
            element,
            lambda: Line(
                segments_um=segments,
                width_um=width,
                cap=cap,  # type: ignore[arg-type]  # validated there
                join=join,  # type: ignore[arg-type]
                miter_limit=max(limit, 1.0) if limit >= 0.0 else 4.0,  # negative is an error that SVG ignores
                dashes_um=dashes[0],
                dash_offset_um=dashes[1],
                reflectance=colour,
            ),
        )

    def _paint(self, element: Element, style: Mapping[str, str], key: str) -> Spectrum | None:
        """Return the reflectance of a fill or a stroke; None where there is none."""
        said = style["color"] if style[key].lower() == "currentcolor" else style[key]
        alpha = self._tried(element, lambda: share(style[f"{key}-opacity"]))
        if said == "none" or alpha is None or alpha <= 0.0 or said.lower() == "transparent":
            return None
        if said.startswith("url("):
            self.refuse(element, f"its {key} {said[:40]!r} is a gradient or a pattern; give it one colour")
            return None
        if alpha < 1.0:
            self.refuse(element, f"its {key} is {100 * alpha:g} % opaque; paint it in the colour that this makes")
            return None
        found = self._tried(element, lambda: colours.rgb_and_alpha(said))
        colour = self._tried(element, lambda: colours.rgb(said)) if found is not None and found[1] > 0.0 else None
        return (
            None if colour is None else self.palette[colour] if colour in self.palette else colours.reflectance(colour)
        )

    def _understood(self, element: Element, style: Mapping[str, str]) -> bool:
        """Return whether an element is painted; refuse unsupported style."""
        opacity = self._tried(element, lambda: share(style["opacity"]))
        if opacity is None or opacity <= 0.0:
            return False
        said = {key: style[key] for key in PLAIN if style[key] not in (INHERITED.get(key), OWN.get(key), "fill")}
        if opacity < 1.0:
            said["opacity"] = style["opacity"]
        if style["stroke"] != "none":
            said |= {key: style[key] for key in ("vector-effect",) if style[key] != "none"}
        if element is self.root:  # programs differ on whether these apply to the page or its content
            said |= {key: style[key] for key in ("transform", "clip-path") if style[key] not in ("", "none")}
            said |= {key: style[key] for key in OF_PAGE if key in style}
        return self._lies_plainly(element, style, said)

    def _lies_plainly(self, element: Element, style: Mapping[str, str], said: Mapping[str, str]) -> bool:
        """Return whether an element's placement and visibility are supported; refuse the rest.

        said : further content to refuse
        """
        found = dict(said)
        if style["transform"] and style["transform-origin"].replace("px", "") not in ("", "0", "0 0"):
            found["transform-origin"] = style["transform-origin"]
        if style["transform"] and style["transform-box"] != "view-box":
            found["transform-box"] = style["transform-box"]
        if element.tag in (*SHAPES, "use"):
            found |= {key: style[key] for key in GEOMETRY if key in style}
        found |= strange(style) | {key: style[key] for key in CHANGES if key in style}
        found |= {key: element.attributes[key] for key in _CONDITIONS if key in element.attributes}
        for key, value in found.items():
            self.refuse(element, f"its {key} {value[:40]!r} is not supported; {_WAYS_OUT.get(key, 'remove it')}")
        moving = [child for child in element.children if child.tag in _MOVEMENTS]
        for child in moving:
            self.refuse(child, _WAYS_OUT[child.tag])
        return not found and not moving

    def _clip(self, element: Element, said: str, matrix: Matrix) -> Any:
        """Return the shapes of a clip path as one."""
        clip = self.known.get(said.strip().removeprefix("url(").removesuffix(")").strip("\"'").removeprefix("#"))
        if clip is None or clip.tag != "clipPath":
            self.refuse(element, f"its clip-path {said[:40]!r} is not there")
            return None
        above = self._style_of(clip)
        if clip.attributes.get("clipPathUnits", "userSpaceOnUse") != "userSpaceOnUse" or above["clip-path"] != "none":
            self.refuse(clip, "is not supported: give it clipPathUnits userSpaceOnUse and no clip-path")
            return None
        if not self._lies_plainly(clip, above, {}) or (one := self._moved(clip, above)) is None:
            return None
        shapes: list[Any] = []
        for child in clip.children:
            if child.tag in _UNSEEN:
                continue
            link = child.attributes.get("href", "") if child.tag == "use" else ""
            drawn = self.known.get(link.removeprefix("#"), child)
            if drawn.tag not in SHAPES or {"x", "y"} & set(child.attributes if link else ()):
                self.refuse(child, "is not supported in a <clipPath>; draw it with paths")
                continue
            there, seen, style = times(matrix, one), True, above
            for element in (child, drawn) if link else (child,):
                style = styled(element, style, self.rules)
                if style["clip-path"] != "none":
                    self.refuse(child, "is clipped itself, in a <clipPath>; draw what is left of it")
                moved = self._moved(element, style) if self._lies_plainly(element, style, {}) else None
                seen = seen and moved is not None and style["display"] != "none"
                there = times(there, moved or IDENTITY)
            if not seen or style["visibility"] != "visible" or flattens(there):
                continue
            if segments := self._tried(drawn, functools.partial(segments_of, drawn, self.view.whole)):
                shapes.append(self._tried(drawn, functools.partial(path, segments, style["clip-rule"], 0.0, there)))
        return None if None in shapes else Group(shapes=shapes)

    def _style_of(self, element: Element) -> dict[str, str]:
        """Return an element's properties with inheritance."""
        around = self.around.get(id(element))
        return styled(element, {} if around is None else self._style_of(around), self.rules)


def path(segments: Sequence[Segment], rule: str, reflectance: Spectrum, matrix: Matrix) -> Any:
    """Return a filled path under a transform."""
    fill_rule: FillRule = "evenodd" if rule == "evenodd" else "nonzero"
    return placed(Path(segments_um=segments, fill_rule=fill_rule, reflectance=reflectance), matrix)


def placed(shape: Any, matrix: Matrix) -> Any:
    """Return a shape under a transform."""
    return shape if matrix == IDENTITY else Group(shapes=[shape], matrix=matrix)


def _too_large(root: Element, known: Mapping[str, Element]) -> tuple[Element, str] | None:
    """Return the element at which a drawing is too large to be read in seconds, and the message."""
    count = 0
    for element in root.all():
        for key in ("d", "points"):
            count += sum(1 for _ in re.finditer(NUMBER, element.attributes.get(key, "")))
        if count > MOST_NUMBERS:
            return element, f"the paths up to here hold more than {MOST_NUMBERS} numbers; simplify them"
    if _drawn(root, known, {}, 0) > MOST_ELEMENTS:
        return root, f"draws more than {MOST_ELEMENTS} elements, those that <use> repeats counted each time"
    return None


def _drawn(element: Element, known: Mapping[str, Element], found: dict[int, int], uses: int) -> int:
    """Return the number of elements that an element draws; arbitrary for recursion or excessive depth."""
    if id(element) not in found:
        found[id(element)] = 1  # guard against recursion
        linked = known.get(element.attributes.get("href", "").removeprefix("#"))
        inner = [linked] if element.tag == "use" and linked is not None and uses < MOST_USES else element.children
        deeper = uses + (element.tag == "use")
        found[id(element)] = 1 + sum(_drawn(each, known, found, deeper) for each in inner)
    return found[id(element)]
