"""Drawings as a table of a scene file."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from camsim.config.schema.base import Name, Point, Reflectance, Table


class Svg(Table):
    """A drawing: an SVG file with paths, basic shapes, fills and strokes."""

    kind: Literal["svg"] = Field(description="which shape")
    file: Name = Field(description="the drawing, in this scene's folder or below")
    width: float | None = Field(default=None, gt=0, description="of the drawing's page, in the scene's unit")
    height: float | None = Field(default=None, gt=0, description="instead: height of the page; the other follows")
    centre: Point = Field(default=(0.0, 0.0), description="of the page, from the optical axis, in the scene's unit")
    rotate_deg: float = Field(default=0.0, description="about the page's centre, clockwise as displayed, degrees")
    palette: dict[Annotated[str, Field(description="a colour: #rrggbb or a name of CSS")], Reflectance] = Field(
        default={}, description="reflectances of colours; others get one that has their sRGB under D65"
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless one size is given; the other follows."""
        sizes = [key for key in ("width", "height") if table.get(key) is not None]
        if not sizes:
            yield "width", "missing; give width or height, the other follows"
        elif len(sizes) > 1:
            yield "height", "given together with 'width'; the other follows, leave one of the two out"
