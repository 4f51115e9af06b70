"""Drawings as scenery: SVG files, with fills and strokes as shapes."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camsim.core.typed import FilePath, Number, Place, Point, Positive, Several, check, validate
from camsim.errors import InvalidValueError
from camsim.scene.primitives import Compound, Primitive, Shape, flattened
from camsim.scene.shapes import Group, Rectangle
from camsim.spectra.curve import Reflectance, Spectrum

__all__ = ["Svg", "read_svg"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Svg(Compound):
    """The shapes of a drawing.

    name : name of the drawing's file

    >>> Svg(name="flag.svg", shapes=[Rectangle(width_um=2.0, height_um=1.0, reflectance=0.1)]).pieces
    4
    """

    name: str
    shapes: Several[Shape]

    if TYPE_CHECKING:

        def __init__(self, *, name: str, shapes: Several[Shape]) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        self._count(self.shapes, deeper=0)

    def primitives(self) -> Iterator[Primitive]:
        """Return the primitives of its shapes."""
        return iter(flattened(self.shapes))


def read_svg(
    file: str | os.PathLike[str],
    *,
    width_um: Number | None = None,
    height_um: Number | None = None,
    centre_um: Place = (0.0, 0.0),
    rotate_deg: Number = 0.0,
    palette: Mapping[str, Spectrum] | None = None,
    displayed: str = "",
) -> Svg:
    """Return a drawing as shapes.

    width_um, height_um : size of the drawing's page; give one of the two, the other follows
    centre_um  : centre of the page
    rotate_deg : rotation about the page's centre, clockwise as displayed
    palette    : reflectances of colours, such as {"#ff0000": 0.2, "black": 0.05}; other colours get the reflectance
                 that has their sRGB under D65 (``camsim.spectra.rgb``)
    displayed  : name of the file in messages; its path when left out

    Paths, basic shapes, groups, ``use``, transforms, fills, strokes and clip paths are drawn; nothing beyond the page
    is. Raises ConfigError that names every element that cannot be, with its line: nothing is left out silently.

    >>> import tempfile
    >>> from pathlib import Path
    >>> text = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"><rect width="1" height="1" fill="red"/></svg>'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "flag.svg").write_text(text)
    ...     len(read_svg(Path(folder) / "flag.svg", width_um=80.0, palette={"red": 0.1}).shapes)
    1
    """
    name = displayed or check(file, FilePath, "file")
    if (width_um is None) == (height_um is None):
        message = "missing; give it or height_um" if width_um is None else "given together with height_um; one follows"
        raise InvalidValueError(message, key="width_um", stage="read_svg")
    size = (width_um, "width_um") if height_um is None else (height_um, "height_um")
    size_um: float = check(size[0], Positive, size[1], "read_svg")
    reflectances = check({} if palette is None else palette, Mapping[str, Reflectance], "palette", "read_svg")
    x, y = check(centre_um, Point, "centre_um", "read_svg")
    angle = math.radians(check(rotate_deg, float, "rotate_deg", "read_svg"))
    from camsim.scene.svg.reader import Reader  # imported here: most scenes need no XML parser

    view, shapes = Reader(Path(file), name, reflectances).shapes()
    scale = size_um / (view.width_px if height_um is None else view.height_px)
    left, top = 0.5 * view.width_px, 0.5 * view.height_px
    boxes = [fill.curves.boxes - [left, top, left, top] for one in flattened(shapes) for fill in one.fills]
    beyond = any((np.abs(box) > [left, top, left, top]).any() for box in boxes)
    page = Rectangle(width_um=view.width_px, height_um=view.height_px, centre_um=(left, top), reflectance=0.0)
    c, s = scale * math.cos(angle), scale * math.sin(angle)
    matrix = (c, s, -s, c, x - c * left + s * top, y - s * left - c * top)
    group = Group(shapes=shapes, matrix=matrix, clip=page if beyond else None)
    return Svg(name=os.path.basename(name), shapes=(group,))
