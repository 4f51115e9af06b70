"""Lens files: wavefront, distortion and illumination over the frame, as numbers."""

from typing import Annotated, Any, Literal

from pydantic import Field

from camsim.config.schema.base import Name, Table
from camsim.core.typed import FNumber, Fraction, NonNegative, Positive


class LensFile(Table):
    """A lens that changes over the frame: wavefront, distortion, lateral colour and illumination by place."""

    camsim: Literal["lens/1"] = Field(description="format of this file")
    name: Name = Field(description="what people call the lens")
    residual_waves: NonNegative = Field(
        default=0.0, description="of a traced lens: the residual of the Zernike fit, rms at the worst place, waves"
    )
    residual_mtf: NonNegative = Field(
        default=0.0, description="of a traced lens: by how much its MTF differs from that of the rays at the most"
    )
    f_number: FNumber = Field(description="of the cone of light on the axis: 1/(2·sin of its half angle)")
    wavelength_nm: list[Positive] = Field(
        min_length=1, description="increasing, nm; path differences between them lie on a spline"
    )
    zernike: list[Annotated[int, Field(ge=0)]] = Field(
        description="OSA/ANSI indices; of a lens of revolution those with cosines only, the field along +x"
    )
    waves: list[Any] = Field(
        description="root mean square, waves at each wavelength: a list for each wavelength of lists for each height "
        "(or of rows of places, from the top) of one number for each index"
    )
    height_um: list[NonNegative] = Field(default=[], description="from the axis, increasing from 0 to the rim, µm")
    x_um: list[float] = Field(default=[], description="instead, without symmetry: x of places, increasing, µm")
    y_um: list[float] = Field(default=[], description="and their y, increasing, µm")
    distortion: list[float] = Field(
        default=[],
        description="fraction at each height: what would fall there without it falls at height·(1 + distortion)",
    )
    distortion_height_um: list[NonNegative] = Field(
        default=[], description="heights of distortion where they are not height_um, increasing from 0, µm"
    )
    distortion_powers: list[float] = Field(
        default=[], description="instead: k₁, k₂ … of k₁·u² + k₂·u⁴ + …, u the height over the last one"
    )
    lateral_colour_um: list[list[float]] = Field(
        default=[], description="a list for each wavelength: how much farther out its light falls at each height, µm"
    )
    relative_illumination: list[Fraction] = Field(
        default=[], description="light at each height over that on the axis, fractions, the first 1"
    )
