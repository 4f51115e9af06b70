"""The lens of a scene file: its kinds, and what all of them have in common."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field

from camsim.config.schema.base import Filter, Name, Table, ToldBy, Transmission
from camsim.core.annotations import Called
from camsim.core.typed import FNumber, Fraction, NonNegative


class Cos4Falloff(Table):
    """The natural fall-off of a lens: cos⁴ of the angle of its rays."""

    kind: Literal["cos4"] = Field(description="how the light falls off towards the corners")
    exit_pupil_mm: float = Field(gt=0, description="from the sensor to the exit pupil, mm; about the focal length")


class RadialFalloff(Table):
    """A measured fall-off, straight between its points."""

    kind: Literal["radial"] = Field(description="how the light falls off towards the corners")
    radius_mm: list[NonNegative] = Field(min_length=2, description="from the optical axis, increasing from 0, mm")
    values: list[Fraction] = Field(min_length=2, description="light there relative to the axis, the first 1")


Falloff: TypeAlias = Annotated[Cos4Falloff | RadialFalloff, ToldBy("kind")]


class MountTable(Table):
    """Keys of every lens, and of what is mounted on it."""

    kind: str = Field(description="what blurs the image")
    magnification: float = Field(
        default=0.0,
        ge=0,
        le=100,
        description="image size over object size; the working f-number is f_number · (1 + magnification)",
    )
    transmission: Transmission = Field(default=1.0, description="fraction of the light that passes")
    filters: list[Filter] = Field(default=[], description="in front of the lens, fractions that pass; all multiply")
    falloff: Falloff | None = Field(default=None, description="light towards the corners; leave out for even light")
    veiling_glare: Transmission = Field(
        default=0.0, description="fraction of the light that is spread evenly over the frame; see glare.md"
    )


class LensTable(MountTable):
    """A lens that does not come from a file."""

    f_number: FNumber = Field(description="focal length over aperture, as engraved on the lens")


class FieldLens(MountTable):
    """A lens that changes over the frame: wavefront, distortion, lateral colour, illumination."""

    kind: Literal["field"] = Field(description="what blurs the image")
    file: Name = Field(description="a shipped lens (camsim list lenses), or a lens file in this scene's folder")
    focus_um: float = Field(default=0.0, description="focus shift of the sensor, µm; positive adds to Zernike 4")


class AiryLens(LensTable):
    """A diffraction-limited lens."""

    kind: Literal["airy"] = Field(description="what blurs the image")


class AnnularLens(LensTable):
    """A diffraction-limited lens with an obstruction in the middle of its pupil, such as a mirror lens."""

    kind: Literal["annular-airy"] = Field(description="what blurs the image")
    obstruction: float = Field(
        ge=0,
        le=0.95,
        description="its diameter over that of the pupil; it takes obstruction² of the light",
    )


class GaussianLens(LensTable):
    """A lens with a Gaussian pattern, the same at every wavelength; f_number sets the exposure only."""

    alternatives = (("sigma_um", "mtf50_per_um"),)

    kind: Literal["gaussian"] = Field(description="what blurs the image")
    sigma_um: float | None = Field(default=None, gt=0, description="standard deviation, µm")
    mtf50_per_um: float | None = Field(
        default=None, gt=0, description="instead: where the transfer is one half, cycles/µm"
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless one width is given."""
        if table.get("sigma_um") is None and table.get("mtf50_per_um") is None:
            yield "sigma_um", "missing; give sigma_um, or mtf50_per_um"
        elif table.get("sigma_um") is not None and table.get("mtf50_per_um") is not None:
            yield "mtf50_per_um", "given together with 'sigma_um'; a Gaussian has one width, leave one of the two out"


class EllipticalGaussianLens(LensTable):
    """A lens with an elliptical Gaussian pattern, the same at every wavelength; f_number sets the exposure only."""

    kind: Literal["elliptical-gaussian"] = Field(description="what blurs the image")
    sigma_um: float = Field(gt=0, description="standard deviation along the first axis, µm")
    sigma_across_um: float = Field(gt=0, description="standard deviation along the second axis, µm")
    rotate_deg: float = Field(default=0.0, description="of the first axis, from x clockwise as displayed, degrees")


class Pupil(Table):
    """The opening of a lens."""

    shape: Literal["circular", "square", "bladed"] = Field(
        default="circular",
        description="a square touches the circle of the f-number from outside, an iris from inside",
    )
    obstruction: float = Field(
        default=0.0, ge=0, le=0.95, description="diameter of a round obstruction in the middle, over the circle's"
    )
    blades: int = Field(default=0, ge=0, le=64, description="of an iris, 3 or more")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed, degrees; 0: an iris has a corner right")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault if an iris has no blades, or another shape has some."""
        if table.get("shape") == "bladed" and not table.get("blades"):
            yield "blades", "missing; an iris has 3 blades or more"
        if table.get("shape", "circular") in ("circular", "square") and table.get("blades"):
            yield "blades", "are an iris's; make the shape bladed, or leave them out"


class WavefrontLens(LensTable):
    """A lens with aberrations."""

    kind: Literal["wavefront"] = Field(description="what blurs the image")
    zernike_waves: list[Annotated[tuple[int, float], Called("a pair [index, waves]")]] = Field(
        default=[], description="pairs [OSA/ANSI index, coefficient]: waves at reference_nm, root mean square"
    )
    reference_nm: float = Field(default=550.0, gt=0, description="wavelength of those waves, nm")
    defocus_um: float = Field(default=0.0, description="focus shift, µm; positive adds to Zernike 4")
    pupil: Pupil = Field(default=Pupil.model_construct(), description="the opening")


class RadialOtfLens(LensTable):
    """A round lens given by its transfer function, the same at every wavelength; f_number sets the exposure only."""

    kind: Literal["radial-otf"] = Field(description="what blurs the image")
    freq_per_um: list[NonNegative] = Field(min_length=3, description="increasing from 0, cycles/µm")
    values: list[Annotated[float, Field(ge=-1, le=1)]] = Field(
        min_length=3, description="transfer, one for each frequency: 1 at the first, 0 at the last"
    )


class MeasuredPsfLens(LensTable):
    """A lens given by samples of its pattern, the same at every wavelength; f_number sets the exposure only."""

    kind: Literal["measured-psf"] = Field(description="what blurs the image")
    irradiance: list[list[float]] | None = Field(
        default=None,
        min_length=1,
        description="rows of samples from the top, any unit, the middle on the axis",
    )
    file: Name | None = Field(
        default=None, description="instead: an image with one channel (.exr, .tiff, .npy) in this scene's folder"
    )
    spacing_um: float = Field(gt=0, description="between samples, µm on the sensor")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless the samples are given once."""
        yield from _one_of(table, "irradiance")


class MeasuredOtfLens(LensTable):
    """A lens given by its OTF on a grid of frequencies, the same at every wavelength."""

    kind: Literal["measured-otf"] = Field(description="what blurs the image")
    values: list[list[float]] | None = Field(
        default=None,
        min_length=1,
        description="rows by fy, negative first, odd in number, frequency 0 in the middle, 0 in the outer fifth",
    )
    file: Name | None = Field(
        default=None,
        description="instead: an image (.exr, .tiff, .npy) in this scene's folder; a complex one has channels re, im",
    )
    spacing_per_um: float = Field(gt=0, description="between frequencies, cycles/µm")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless the values are given once."""
        yield from _one_of(table, "values")


def _one_of(table: Mapping[str, Any], inline: str) -> Iterator[tuple[str, str]]:
    if table.get(inline) is None and table.get("file") is None:
        yield inline, f"missing; give {inline}, or a file"
    if table.get(inline) is not None and table.get("file") is not None:
        yield "file", f"given together with '{inline}'; leave one of the two out"


Lens: TypeAlias = Annotated[
    AiryLens
    | AnnularLens
    | GaussianLens
    | EllipticalGaussianLens
    | WavefrontLens
    | FieldLens
    | RadialOtfLens
    | MeasuredPsfLens
    | MeasuredOtfLens,
    ToldBy("kind"),
]
