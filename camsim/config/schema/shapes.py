"""scene/1: its shapes and their keys. A key whose parameter has the same name with ``_um`` added is a length."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import Point, Reflectance, Table, ToldBy, by_form
from camsim.config.schema.charts import Chart
from camsim.config.schema.drawings import Svg
from camsim.config.schema.gradients import (
    LinearGradient,
    RadialGradient,
    SineGrating,
    SineStar,
    SineZonePlate,
)
from camsim.config.schema.pictures import Picture, PointSource
from camsim.core.annotations import Called
from camsim.core.typed import NonNegative, Positive

Segment: TypeAlias = Annotated[list[float | str], Called("a segment such as [line, 1, 2]")]
_Painted: TypeAlias = Annotated[
    Reflectance, Field(description="fraction of the light that it returns; names: camsim list reflectances")
]


class Rectangle(Table):
    """A rectangle about its centre."""

    kind: Literal["rectangle"] = Field(description="which shape")
    width: float = Field(gt=0, description="side along x before it is turned, in the scene's unit")
    height: float = Field(gt=0, description="side along y before it is turned, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed, degrees")
    reflectance: _Painted


class Polygon(Table):
    """Any outline that does not cross itself, with holes or without."""

    kind: Literal["polygon"] = Field(description="which shape")
    points: list[Point] = Field(min_length=3, description="corners [x, y] in order, in the scene's unit")
    holes: list[Annotated[list[Point], Field(min_length=3)]] = Field(
        default=[], description="outlines of holes in it, which neither cross nor leave it"
    )
    reflectance: _Painted


class RegularPolygon(Table):
    """A polygon of equal sides and angles."""

    kind: Literal["regular-polygon"] = Field(description="which shape")
    sides: int = Field(ge=3, le=100_000, description="how many")
    radius: float = Field(gt=0, description="from its centre to a corner, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(
        default=0.0, description="of the first corner from the right, clockwise as displayed, degrees"
    )
    reflectance: _Painted


class Star(Table):
    """A star."""

    kind: Literal["star"] = Field(description="which shape")
    tips: int = Field(ge=3, le=100_000, description="how many")
    radius: float = Field(gt=0, description="from its centre to the tips, in the scene's unit")
    inner_radius: float = Field(gt=0, description="from its centre to the corners between them, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(
        default=0.0, description="of the first tip from the right, clockwise as displayed, degrees"
    )
    reflectance: _Painted


class Disc(Table):
    """A round disc."""

    kind: Literal["disc"] = Field(description="which shape")
    radius: float = Field(gt=0, description="in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    reflectance: _Painted


class Ellipse(Table):
    """An ellipse."""

    kind: Literal["ellipse"] = Field(description="which shape")
    radius_x: float = Field(gt=0, description="half its width before it is turned, in the scene's unit")
    radius_y: float = Field(gt=0, description="half its height before it is turned, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed, degrees")
    reflectance: _Painted


class Ring(Table):
    """The area between two circles."""

    kind: Literal["ring"] = Field(description="which shape")
    radius: float = Field(gt=0, description="of the outer circle, in the scene's unit")
    inner_radius: float = Field(gt=0, description="of the inner one, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    reflectance: _Painted


class Sector(Table):
    """Part of a disc or a ring."""

    kind: Literal["sector"] = Field(description="which shape")
    radius: float = Field(gt=0, description="of its rim, in the scene's unit")
    inner_radius: NonNegative = Field(default=0.0, description="of its inner rim, in the scene's unit")
    from_deg: float = Field(default=0.0, ge=-1e6, le=1e6, description="where it begins, clockwise from the right")
    turn_deg: float = Field(gt=0, le=360, description="how far it goes on clockwise, degrees")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    reflectance: _Painted


class HalfPlane(Table):
    """Everything on one side of a line, as far as 10 km."""

    kind: Literal["half-plane"] = Field(description="which shape")
    through: Point = Field(default=(0.0, 0.0), description="a point of the line, in the scene's unit")
    towards_deg: float = Field(
        default=0.0, description="in which direction it lies, square to the line, clockwise from the right, degrees"
    )
    reflectance: _Painted


class Path(Table):
    """The area enclosed by outlines, which may be curved and may cross."""

    kind: Literal["path"] = Field(description="which shape")
    segments: list[Segment] = Field(
        description="[move, x, y], [line, x, y], [quadratic, x1, y1, x, y], [cubic, x1, y1, x2, y2, x, y], "
        "[arc, rx, ry, rotate_deg, large, sweep, x, y] as in SVG, [close]; in the scene's unit"
    )
    fill_rule: Literal["nonzero", "evenodd"] = Field(
        default="nonzero", description="inside is what outlines wind about: at all, or an odd number of times"
    )
    reflectance: _Painted


class Line(Table):
    """A line of some width, straight or bent."""

    kind: Literal["line"] = Field(description="which shape")
    segments: list[Segment] = Field(description="of its middle, as of a path; open or closed, in the scene's unit")
    width: float = Field(gt=0, description="half of it on either side, in the scene's unit")
    cap: Literal["butt", "round", "square"] = Field(
        default="butt", description="open ends: cut off, a half disc, or half a width longer"
    )
    join: Literal["miter", "round", "bevel"] = Field(default="miter", description="corners: pointed, round, or cut off")
    miter_limit: float = Field(
        default=4.0, ge=1, le=1e6, description="points longer than so many widths are cut off, as in SVG"
    )
    dashes: list[Annotated[float, Field(ge=0)]] = Field(
        default=[], description="lengths of dash, gap, dash …, again and again, in the scene's unit; none: it is whole"
    )
    dash_offset: float = Field(default=0.0, description="where in this pattern an outline begins, in the scene's unit")
    reflectance: _Painted


class Text(Table):
    """Text in Open Sans."""

    kind: Literal["text"] = Field(description="which shape")
    text: str = Field(description="Latin, Greek or Cyrillic; lines end at a line feed")
    size: float = Field(gt=0, description="of the font (its em), in the scene's unit; capitals are 0.714 of it high")
    at: Point = Field(
        default=(0.0, 0.0), description="where the first line begins, on its baseline; but see align and vertical"
    )
    align: Literal["left", "centre", "right"] = Field(default="left", description="what of each line lies there")
    vertical: Literal["baseline", "middle"] = Field(
        default="baseline", description="the first line's baseline lies there, or the middle of all lines"
    )
    weight: Literal[
        "Light", "LightItalic", "Regular", "Italic", "SemiBold", "SemiBoldItalic", "Bold", "BoldItalic", "ExtraBold",
        "ExtraBoldItalic",
    ] = Field(default="Regular", description="of the font")  # fmt: skip
    line: float = Field(default=1.36, ge=0, le=100, description="from one baseline to the next, in sizes")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed about that place, degrees")
    reflectance: _Painted


class Group(Table):
    """Shapes that are mirrored, scaled, turned and moved together, in this order, about the optical axis."""

    kind: Literal["group"] = Field(description="which shape")
    shapes: "list[Shape]" = Field(description="later ones cover earlier ones")
    mirror: Literal["left-right", "up-down"] | None = Field(default=None, description="left out for neither")
    scale: Annotated[
        Annotated[Positive, Tag("number")] | Annotated[tuple[Positive, Positive], Tag("list")], by_form
    ] = Field(default=1.0, description="a factor, or [along x, along y]")
    turn_deg: float = Field(default=0.0, ge=-1e6, le=1e6, description="clockwise as displayed, degrees")
    move: Point = Field(default=(0.0, 0.0), description="to the right and down, in the scene's unit")
    matrix: tuple[float, float, float, float, float, float] | None = Field(
        default=None, description="instead of all these: a, b, c, d, e, f as in SVG; e and f in the scene's unit"
    )
    clip: "Shape | None" = Field(
        default=None, description="nothing outside this shape is painted; its reflectance plays no part"
    )


class RepeatOnGrid(Table):
    """Shapes repeated in rows and columns about where they are given."""

    kind: Literal["repeat-on-grid"] = Field(description="which shape")
    shapes: "list[Shape]" = Field(description="what is repeated; later ones cover earlier ones")
    cols: int = Field(default=1, ge=1, description="copies side by side")
    rows: int = Field(default=1, ge=1, description="copies below one another")
    step: Point = Field(description="from one column and one row to the next, in the scene's unit")


class RepeatOnRing(Table):
    """Shapes repeated on a ring: copies, evenly turned about its centre, the first where it is given."""

    kind: Literal["repeat-on-ring"] = Field(description="which shape")
    shapes: "list[Shape]" = Field(description="what is repeated; later ones cover earlier ones")
    count: int = Field(ge=1, description="copies")
    centre: Point = Field(default=(0.0, 0.0), description="of the ring, in the scene's unit")
    upright: bool = Field(
        default=False, description="copies keep their direction; the middle of the box about them goes round"
    )


_Kinds: TypeAlias = (
    Rectangle
    | Polygon
    | RegularPolygon
    | Star
    | Disc
    | Ellipse
    | Ring
    | Sector
    | HalfPlane
    | Path
    | Line
    | Text
    | Group
    | RepeatOnGrid
    | RepeatOnRing
    | Chart
    | Svg
)
Shape: TypeAlias = Annotated[_Kinds, ToldBy("kind")]
_Fields: TypeAlias = Picture | PointSource | LinearGradient | RadialGradient | SineGrating | SineStar | SineZonePlate
Placed: TypeAlias = Annotated[_Kinds | _Fields, ToldBy("kind")]
"""A shape of a scene; within groups and as clips there are no pictures, gradients and points."""
