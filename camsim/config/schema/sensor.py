"""sensor/1: one camera body."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import Curve, Filter, Name, Table, ToldBy, by_form
from camsim.config.schema.electronics import Charge, Readout
from camsim.core.annotations import Called
from camsim.core.typed import Pitch


class SensorFrame(Table):
    """The lattice of photosites."""

    rows: int = Field(ge=1, description="photosites from top to bottom")
    cols: int = Field(ge=1, description="photosites from left to right")
    pitch_um: Pitch = Field(description="distance between centres of neighbouring photosites, µm")


class SquarePhotosite(Table):
    """A square that collects light evenly."""

    kind: Literal["square"] = Field(description="shape of the area that collects light")
    fill_factor: float = Field(default=1.0, gt=0, le=1, description="fraction of the pitch's area that collects light")


Corner: TypeAlias = Annotated[tuple[float, float], Called("a point [x, y]")]


class RectangularPhotosite(Table):
    """A rectangle that collects light evenly."""

    kind: Literal["rectangular"] = Field(description="shape of the area that collects light")
    width_um: float = Field(gt=0, description="side along x, µm")
    height_um: float = Field(gt=0, description="side along y, µm")


class CircularPhotosite(Table):
    """A disc that collects light evenly."""

    kind: Literal["circular"] = Field(description="shape of the area that collects light")
    diameter_um: float = Field(gt=0, description="µm")


class RoundedPhotosite(Table):
    """A rectangle with rounded corners that collects light evenly."""

    kind: Literal["rounded"] = Field(description="shape of the area that collects light")
    width_um: float = Field(gt=0, description="side along x, µm")
    height_um: float = Field(gt=0, description="side along y, µm")
    radius_um: float = Field(ge=0, description="of the corners, µm; at most half the shorter side")


class PolygonPhotosite(Table):
    """Any polygon that collects light evenly, such as an L."""

    kind: Literal["polygon"] = Field(description="shape of the area that collects light")
    points_um: list[Corner] = Field(min_length=3, description="corners [x, y] in order from the photosite's centre, µm")


Photosite: TypeAlias = Annotated[
    SquarePhotosite | RectangularPhotosite | CircularPhotosite | RoundedPhotosite | PolygonPhotosite,
    ToldBy("kind"),
]


class FourSpotOlpf(Table):
    """Two birefringent plates: every point becomes four."""

    alternatives = (("split_um", "split_pitches"), ("split_y_um", "split_y_pitches"))

    kind: Literal["four-spot"] = Field(description="what the filter makes of a point")
    split_um: float | None = Field(default=None, gt=0, description="full distance between two neighbouring spots, µm")
    split_pitches: float | None = Field(
        default=None, gt=0, description="instead: the same in pitches of the sensor, mostly 0.5 to 1"
    )
    split_y_um: float | None = Field(default=None, gt=0, description="the same along y, µm; as along x when left out")
    split_y_pitches: float | None = Field(default=None, gt=0, description="instead: the same along y in pitches")
    rotate_deg: float = Field(default=0.0, description="turns the spots clockwise as displayed, degrees")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless one split is given along each axis."""
        yield from _one_split(table)
        if table.get("split_y_um") is not None and table.get("split_y_pitches") is not None:
            yield "split_y_pitches", "given together with 'split_y_um'; leave one of the two out"


class TwoSpotOlpf(Table):
    """One birefringent plate: every point becomes two."""

    alternatives = (("split_um", "split_pitches"),)

    kind: Literal["two-spot"] = Field(description="what the filter makes of a point")
    split_um: float | None = Field(default=None, gt=0, description="full distance between the two spots, µm")
    split_pitches: float | None = Field(
        default=None, gt=0, description="instead: the same in pitches of the sensor, mostly 0.5 to 1"
    )
    rotate_deg: float = Field(
        default=0.0, description="from side by side, clockwise as displayed, degrees; 90: one above the other"
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless one split is given."""
        yield from _one_split(table)


def _one_split(table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    if table.get("split_um") is None and table.get("split_pitches") is None:
        yield "split_um", "missing; give split_um, or split_pitches"
    if table.get("split_um") is not None and table.get("split_pitches") is not None:
        yield "split_pitches", "given together with 'split_um'; leave one of the two out"


Olpf: TypeAlias = Annotated[FourSpotOlpf | TwoSpotOlpf, ToldBy("kind")]


class BayerCfa(Table):
    """Red, green and blue in the pattern of Bayer."""

    kind: Literal["bayer"] = Field(description="which colour filter array")
    pattern: Literal["RGGB", "BGGR", "GRBG", "GBRG"] = Field(
        description="letters of photosites (0,0) (0,1) (1,0) (1,1)"
    )


class QuadBayerCfa(Table):
    """Bayer's pattern with a square of photosites for every letter."""

    kind: Literal["quad-bayer"] = Field(description="which colour filter array")
    pattern: Literal["RGGB", "BGGR", "GRBG", "GBRG"] = Field(description="letters of the squares, row by row")
    group: int = Field(default=2, ge=2, le=16, description="photosites along a side of a square")


class NamedCfa(Table):
    """An array with a name: X-Trans 6 × 6, RGBW 4 × 4 (TrueSense), RYYB and CYGM 2 × 2, mono (one channel, Y)."""

    kind: Literal["x-trans", "rgbw", "ryyb", "cygm", "mono"] = Field(description="which colour filter array")


class LetterCfa(Table):
    """Any rectangle of letters, repeated over the sensor; every letter needs a curve."""

    kind: Literal["letters"] = Field(description="which colour filter array")
    pattern: list[Annotated[str, Field(pattern="^[A-Za-z]+$"), Called("letters")]] = Field(
        min_length=1, description="one string of letters for each row, all equally long"
    )


Cfa: TypeAlias = Annotated[BayerCfa | QuadBayerCfa | NamedCfa | LetterCfa, ToldBy("kind")]
Channel: TypeAlias = Annotated[str, Field(pattern="^([A-Za-z]|Gr|Gb)$", description="a channel: one letter, Gr or Gb")]
Curves: TypeAlias = Annotated[Annotated[Name, Tag("word")] | Annotated[dict[Channel, Curve], Tag("table")], by_form]

Peak: TypeAlias = Annotated[
    Annotated[float, Field(gt=0, le=1), Tag("number")] | Annotated[Literal["as given"], Tag("word")], by_form
]


class QuantumEfficiency(Table):
    """Electrons per photon of each channel, filters of the sensor included."""

    curves: Curves = Field(
        description="relative, or absolute with peak: as given; a table has a curve per letter of the cfa (Gr and Gb "
        "where greens in rows with red and with blue differ); names: camsim list sensitivities"
    )
    per: Literal["energy", "photon"] = Field(
        description="what the curves respond to: equal energy or equal numbers of photons"
    )
    peak: Peak = Field(
        description="electrons per photon at the highest point of all channels; 'as given' of curves that are "
        "absolute, A/W where they are per energy"
    )


Triple: TypeAlias = Annotated[tuple[float, float, float], Called("three numbers")]


class MeasuredMatrix(Table):
    """A camera's colours under one light, as measured on a chart (camsim calibrate colour)."""

    light: Name = Field(description="its name; files state that of A as A's, any other as D65's")
    white_xyz: Triple = Field(description="X, Y and Z of a perfect diffuser in that light, Y = 1")
    camera_to_xyz: tuple[Triple, Triple, Triple] = Field(
        description="rows X, Y and Z of red, green and blue above black, on any scale"
    )


class SensorFile(Table):
    """A camera body: lattice, photosite, filters, noise and analogue-to-digital conversion."""

    camsim: Literal["sensor/1"] = Field(description="format of this file")
    name: Name = Field(description="what reports and files call the camera")
    serial: int = Field(default=1, ge=0, le=2**63 - 1, description="seeds the fixed patterns")
    frame: SensorFrame = Field(description="the lattice of photosites")
    photosite: Photosite = Field(
        default=SquarePhotosite.model_construct(kind="square"), description="the area that collects light"
    )
    olpf: Olpf | None = Field(default=None, description="optical low-pass filter; leave out for none")
    filters: list[Filter] = Field(
        default=[], description="in front of the sensor (infrared cut, cover), fractions that pass; all multiply"
    )
    cfa: Cfa = Field(description="colour filter array")
    quantum_efficiency: QuantumEfficiency = Field(description="electrons per photon of each channel")
    colour_matrices: list[MeasuredMatrix] = Field(
        default=[], description="measured ones, which DNGs carry in place of those fitted to the curves"
    )
    charge: Charge = Field(default=Charge.model_construct(), description="what a photosite does with charge")
    readout: Readout = Field(description="from electrons to data numbers")
