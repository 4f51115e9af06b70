"""scene/1: one capture: scene, camera, light and exposure."""

from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, Field, Tag
from pydantic_core import PydanticCustomError

from camsim.camera.given_light import MOST_SAMPLES
from camsim.config.schema.base import LightTable, Name, Reflectance, Table, by_form
from camsim.config.schema.lens import Lens
from camsim.config.schema.shapes import Placed
from camsim.core.annotations import Called
from camsim.core.typed import FrameNumber, Iso, Positive, Seconds, Seed


class Light(Table):
    """The light that falls on the scene: one spectrum, one level."""

    alternatives = (
        ("illuminant", "table", "blackbody_k", "line_nm"),
        ("illuminance_lux", "irradiance_w_per_m2", "luminance_cd_per_m2"),
    )

    illuminant: Name | None = Field(default=None, description="its spectrum by name (camsim list illuminants)")
    table: LightTable | None = Field(default=None, description="instead: a custom spectrum")
    blackbody_k: float | None = Field(
        default=None, ge=500, le=1e6, description="instead: a thermal radiator's temperature, kelvin"
    )
    line_nm: float | None = Field(default=None, gt=0, description="instead: a single wavelength (a laser, say), nm")
    width_nm: float = Field(default=0.0, ge=0, description="full width of the line at half its height, nm")
    illuminance_lux: float | None = Field(default=None, gt=0, description="level, lux")
    irradiance_w_per_m2: float | None = Field(default=None, gt=0, description="instead: W/m² of the whole spectrum")
    luminance_cd_per_m2: float | None = Field(
        default=None, gt=0, description="instead: luminance of a perfect diffuser in the scene, cd/m²"
    )
    at: Literal["scene", "sensor"] = Field(
        default="scene",
        description="where the level holds; on the sensor: behind the lens, before filters, for a reflectance of 1",
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield faults unless one spectrum and one level are given."""
        spectra, levels = cls.alternatives
        given = [key for key in spectra if table.get(key) is not None]
        if not given:
            yield "illuminant", "missing; give an illuminant such as D55, or line_nm for a single wavelength"
        for key in given[1:]:
            yield key, f"given together with '{given[0]}'; a light has one spectrum, leave one of the two out"
        given = [key for key in levels if table.get(key) is not None]
        if not given:
            yield "illuminance_lux", "missing; give illuminance_lux, irradiance_w_per_m2 or luminance_cd_per_m2"
        for key in given[1:]:
            yield key, f"given together with '{given[0]}'; a light has one level, leave one of the two out"
        if table.get("width_nm") and table.get("line_nm") is None:
            yield "width_nm", "is a line's; there is no line_nm here"


def _date(text: str) -> str:
    try:
        datetime.strptime(text, "%Y-%m-%d %H:%M:%S")
    except ValueError:
        raise PydanticCustomError("date", "not a date") from None
    return text


Time: TypeAlias = Annotated[Annotated[Seconds, Tag("number")] | Annotated[Literal["auto"], Tag("word")], by_form]


class Exposure(Table):
    """Exposure time and ISO setting."""

    time_s: Time = Field(description="seconds; auto puts a perfect diffuser at 80 % of black..white")
    iso: Iso = Field(description="ISO setting; the sensor's electrons_per_dn holds at its base_iso")
    datetime: Annotated[str, AfterValidator(_date), Called("a date and time such as 2000-01-31 23:59:59")] = Field(
        default="2000-01-01 00:00:00", description="what files carry as their date"
    )
    temperature_c: float | None = Field(
        default=None, ge=-273.15, le=200, description="of the sensor, °C; the one of its dark current when left out"
    )


class Region(Table):
    """A window of the full frame."""

    rows: int = Field(ge=1, description="photosites from top to bottom")
    cols: int = Field(ge=1, description="photosites from left to right")
    origin: tuple[Annotated[int, Field(ge=0)], Annotated[int, Field(ge=0)]] | None = Field(
        default=None, description="[row, col] of its first photosite; the middle of the frame when left out"
    )


class Background(Table):
    """Everything that no shape covers, out to infinity."""

    reflectance: Reflectance = Field(
        description="fraction of the light that it returns; names: camsim list reflectances"
    )


class SceneContent(Table):
    """What is in front of the camera, as it falls on the sensor: x right, y down, from the optical axis."""

    unit: Literal["pixel", "um", "mm", "frame"] = Field(
        description="of all lengths in the scene; pixel is the sensor's pitch, frame the height of its full frame"
    )
    background: Background = Field(description="everything that no shape covers")
    shapes: list[Placed] = Field(default=[], description="later ones cover earlier ones")


class Render(Table):
    """How the image is computed, and how accurately."""

    tolerance: float = Field(
        default=1e-6,
        ge=1e-11,
        le=1e-2,
        description="largest error of any photosite, a fraction of the brightest surface",
    )
    method: Literal["auto", "boundary", "fourier"] = Field(
        default="auto", description="the engine; auto takes the cheaper one of those that can"
    )
    strict: bool = Field(
        default=False, description="true writes nothing when an error above the tolerance is found, and exits with 1"
    )


class Noise(Table):
    """The noise of this capture; the fixed patterns belong to the sensor."""

    enabled: bool = Field(default=True, description="false records the mean signal")
    seed: Seed = Field(default=0, description="same seed, same noise")
    frame_number: FrameNumber = Field(
        default=0, description="another exposure of the scene: same patterns, fresh noise"
    )


class Files(Table):
    """What files are to contain besides the numbers of the image."""

    colour_matrix: Literal["standard", "scene"] = Field(
        default="standard",
        description="of a DNG: standard fits illuminants A and D65, scene fits this capture's own light",
    )
    spectral_nm: list[Positive] | None = Field(
        default=None,
        min_length=1,
        description="wavelengths of the spectral cube, increasing, nm; 400 to 700 every 10 when left out",
    )


class CustomLight(Table):
    """Light from a file, as it lies on the sensor: a render, a photograph, a cube, an array."""

    file: Name = Field(description="NPY, NPZ, EXR, TIFF, PNG, JPEG, ENVI or MATLAB, in this file's folder")
    unit: Literal["electrons", "photons", "irradiance", "reflectance", "srgb"] | None = Field(
        default=None, description="of its numbers, as of camsim expose --as; as the file says when left out"
    )
    wavelength_nm: list[Positive] | None = Field(
        default=None, min_length=1, description="of its planes, increasing, nm"
    )
    per_photosite: int = Field(default=1, ge=1, le=MOST_SAMPLES, description="samples along the side of a photosite")
    layer: Name | None = Field(default=None, description="of an EXR of several; an array of NPZ or MATLAB")
    illuminant: Name = Field(default="D65", description="what lights a reflectance (camsim list illuminants)")
    illuminance_lux: Positive = Field(default=10.0, description="on the sensor, from a reflectance of 1, lux")


class CustomExposure(Table):
    """Exposure time and ISO setting, without a lens."""

    time_s: Time | None = Field(
        default=None,
        description="seconds; auto puts a reflectance of 1 at 80 % of black..white, and is meant when left out; of "
        "other units 0.01",
    )
    iso: Iso | None = Field(default=None, description="ISO setting; the sensor's base_iso when left out")
    datetime: Annotated[str, AfterValidator(_date), Called("a date and time such as 2000-01-31 23:59:59")] = Field(
        default="2000-01-01 00:00:00", description="what files carry as their date"
    )
    temperature_c: float | None = Field(
        default=None, ge=-273.15, le=200, description="of the sensor, °C; the one of its dark current when left out"
    )


class ShotFile(Table):
    """A capture without a lens: given light on a sensor, nothing resampled."""

    camsim: Literal["scene/1"] = Field(description="format of this file")
    name: Name | None = Field(default=None, description="for people; reports name the light")
    sensor: Name | None = Field(
        default=None, description="its name (camsim list sensors), or a file in this file's folder or in ../sensors"
    )
    lens: Literal["none"] = Field(description="none: the light lies on the photosites")
    light: CustomLight = Field(description="the light of the whole exposure")
    exposure: CustomExposure = Field(
        default=CustomExposure.model_construct(), description="how long, and how much the signal is amplified"
    )
    region: Region | None = Field(
        default=None, description="the window that the light fills; in the middle of the frame when left out"
    )
    noise: Noise = Field(default=Noise.model_construct(), description="the noise of this capture")
    files: Files = Field(default=Files.model_construct(), description="what the files hold besides their numbers")


class SceneFile(Table):
    """A capture: scene, lens, light and exposure, taken with a camera."""

    camsim: Literal["scene/1"] = Field(description="format of this file")
    name: Name | None = Field(default=None, description="what reports call it; the file's name when left out")
    sensor: Name | None = Field(
        default=None, description="its name (camsim list sensors), or a file in this scene's folder or in ../sensors"
    )
    lens: Lens = Field(description="the lens")
    light: Light = Field(description="the light that falls on the scene")
    exposure: Exposure = Field(description="how long, and how much the signal is amplified")
    region: Region | None = Field(default=None, description="a window of the full frame; leave out for all of it")
    scene: SceneContent = Field(description="what is in front of the camera")
    render: Render = Field(default=Render.model_construct(), description="how accurately the image is computed")
    noise: Noise = Field(default=Noise.model_construct(), description="the noise of this capture")
    files: Files = Field(default=Files.model_construct(), description="what the files hold besides their numbers")
