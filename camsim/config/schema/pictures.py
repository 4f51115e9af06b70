"""scene/1, pictures and point sources among its shapes."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import Name, Point, Reflectance, Table, by_form
from camsim.core.typed import Positive

Encoding: TypeAlias = Annotated[
    Annotated[float, Field(ge=0.1, le=10.0), Tag("number")] | Annotated[Literal["srgb", "linear"], Tag("word")], by_form
]


class Picture(Table):
    """Samples of a file: a photograph, or a cube of spectra."""

    alternatives = (("width", "sample"),)

    kind: Literal["picture"] = Field(description="which shape")
    file: Name = Field(description="PNG, JPEG, TIFF, EXR, NPY, NPZ, ENVI or MATLAB, in this scene's folder")
    width: float | None = Field(
        default=None, gt=0, description="of all of it along its rows, in the scene's unit; samples are squares"
    )
    sample: float | None = Field(
        default=None, gt=0, description="instead: side of one sample, in the scene's unit; 0.5 pixel shrinks it by two"
    )
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed, degrees")
    interpolation: Literal["squares", "linear", "cubic"] = Field(
        default="squares", description="between samples: each a square of one colour, straight, or a smooth spline"
    )
    encoding: Encoding | None = Field(
        default=None,
        description="of colours: srgb, linear or an exponent; when left out whole numbers are srgb, others linear; of "
        "codes that were divided it must be said",
    )
    scale: float = Field(default=1.0, gt=0, description="what every number is multiplied by: reflectances are 0 to 1")
    wavelength_nm: list[Positive] | None = Field(
        default=None, min_length=1, description="of the bands of a cube whose file does not say them, nm"
    )
    tolerance: float = Field(
        default=1e-4, ge=0, le=1, description="how far a cube's planes may lie from it; 0 keeps every band"
    )
    layer: str | None = Field(
        default=None, description="of an EXR that holds several images; an array of an NPZ or MATLAB file"
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless one size is given."""
        sizes = [key for key in ("width", "sample") if table.get(key) is not None]
        if not sizes:
            yield "width", "missing; give the width of all of it, or sample, the side of one of its samples"
        elif len(sizes) > 1:
            yield "sample", "given together with 'width'; one follows from the other, leave one of the two out"


class PointSource(Table):
    """A point of light, such as a star: it has no area, and hides nothing."""

    kind: Literal["point-source"] = Field(description="which shape")
    electrons: float | None = Field(
        default=None,
        gt=0,
        description="that all photosites would collect of it in a frame, were all of the channel with the most",
    )
    photosites: float | None = Field(
        default=None,
        gt=0,
        description="in place of electrons: photosites full of such a surface that send as much light",
    )
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    reflectance: Reflectance = Field(
        default=1.0, description="of a surface with light of that colour; names: camsim list reflectances"
    )
