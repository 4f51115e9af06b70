"""sensor/1: one camera body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import (
    Called,
    Curve,
    Filter,
    Fraction,
    Letter,
    Name,
    NonNegative,
    Table,
    by_form,
)

Place: TypeAlias = Annotated[int, Field(ge=0)]


class SensorFrame(Table):
    """The lattice of photosites."""

    rows: int = Field(ge=1, description="photosites from top to bottom")
    cols: int = Field(ge=1, description="photosites from left to right")
    pitch_um: float = Field(gt=0, description="distance between centres of neighbouring photosites, µm")


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
    Field(discriminator="kind"),
]


class FourSpotOlpf(Table):
    """Two birefringent plates: every point becomes four."""

    kind: Literal["four-spot"] = Field(description="what the filter makes of a point")
    split_um: float = Field(gt=0, description="full distance between two neighbouring spots, µm")
    split_y_um: float | None = Field(default=None, gt=0, description="the same along y, µm; as split_um when left out")
    rotate_deg: float = Field(default=0.0, description="turns the spots clockwise as displayed, degrees")


class TwoSpotOlpf(Table):
    """One birefringent plate: every point becomes two."""

    kind: Literal["two-spot"] = Field(description="what the filter makes of a point")
    split_um: float = Field(gt=0, description="full distance between the two spots, µm")
    rotate_deg: float = Field(
        default=0.0, description="from side by side, clockwise as displayed, degrees; 90: one above the other"
    )


Olpf: TypeAlias = Annotated[FourSpotOlpf | TwoSpotOlpf, Field(discriminator="kind")]


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
    group: Literal[2, 4] = Field(default=2, description="photosites along a side of a square")


class NamedCfa(Table):
    """An array with a name: X-Trans 6 × 6, RGBW 4 × 4 (TrueSense), RYYB and CYGM 2 × 2, mono (one channel, Y)."""

    kind: Literal["x-trans", "rgbw", "ryyb", "cygm", "mono"] = Field(description="which colour filter array")


class LetterCfa(Table):
    """Any rectangle of letters, repeated over the sensor; every letter needs a curve."""

    kind: Literal["letters"] = Field(description="which colour filter array")
    pattern: list[Annotated[str, Field(pattern="^[A-Za-z]+$"), Called("letters")]] = Field(
        min_length=1, description="one string of letters for each row, all equally long"
    )


Cfa: TypeAlias = Annotated[BayerCfa | QuadBayerCfa | NamedCfa | LetterCfa, Field(discriminator="kind")]
Curves: TypeAlias = Annotated[Annotated[Name, Tag("word")] | Annotated[dict[Letter, Curve], Tag("table")], by_form]


class QuantumEfficiency(Table):
    """Electrons per photon of each channel, filters of the sensor included."""

    curves: Curves = Field(
        description="relative; a table has a curve per letter of the cfa; names: camsim list sensitivities"
    )
    per: Literal["energy", "photon"] = Field(
        description="what the curves respond to: equal energy or equal numbers of photons"
    )
    peak: float = Field(gt=0, le=1, description="electrons per photon at the highest point of all channels")


class HotPhotosite(Table):
    """One photosite with a dark current of its own."""

    row: int = Field(ge=0, description="from the top, 0 the first")
    col: int = Field(ge=0, description="from the left, 0 the first")
    e_per_s: float = Field(ge=0, description="its additional dark current, electrons per second")


class Defects(Table):
    """Hot and dead photosites."""

    hot_fraction: float = Field(default=0.0, ge=0, le=1, description="share of photosites that are hot")
    hot_e_per_s: float = Field(
        default=0.0, ge=0, description="their mean dark current (distributed exponentially), electrons per second"
    )
    dead_fraction: float = Field(default=0.0, ge=0, le=1, description="share of photosites that see no light")
    hot: list[HotPhotosite] = Field(default=[], description="hot ones by place, besides those drawn")
    dead: list[Annotated[tuple[Place, Place], Called("a place [row, col]")]] = Field(
        default=[], description="dead ones by place, [row, col], besides those drawn"
    )


class Polynomial(Table):
    """Response x·(1 + a₁u + a₂u² + …) with u = x/scale_e."""

    kind: Literal["polynomial"] = Field(description="how the non-linearity is given")
    coefficients: list[float] = Field(min_length=1, description="a₁, a₂, …: relative errors at scale_e")
    scale_e: float = Field(gt=0, description="charge at which u is 1, electrons; mostly the full well")


class ResponseTable(Table):
    """Response by a table, straight between its points."""

    kind: Literal["table"] = Field(description="how the non-linearity is given")
    electrons_in: list[NonNegative] = Field(min_length=2, description="charge, increasing, electrons")
    electrons_out: list[NonNegative] = Field(
        min_length=2, description="what a linear read-out would have called it, increasing, electrons"
    )


Nonlinearity: TypeAlias = Annotated[Polynomial | ResponseTable, Field(discriminator="kind")]


class Charge(Table):
    """What a photosite does with charge; a stage that is left out does not happen."""

    prnu: float | None = Field(default=None, ge=0, le=1, description="standard deviation of the response, a fraction")
    defects: Defects | None = Field(default=None, description="hot and dead photosites")
    crosstalk: list[Annotated[list[Fraction], Field(min_length=3, max_length=3)]] | None = Field(
        default=None,
        min_length=3,
        max_length=3,
        description="3 rows of 3 fractions: where a photosite's charge ends, the middle is itself; at most 1 together",
    )
    dark_current_e_per_s: float | None = Field(
        default=None, ge=0, description="charge without light, electrons per second"
    )
    dark_current_at_c: float = Field(
        default=25.0, ge=-273.15, le=1000, description="temperature at which dark_current_e_per_s holds, °C"
    )
    dark_current_doubles_every_c: float = Field(
        default=7.0, ge=1, le=1000, description="warming that doubles it, °C; silicon: 5 to 9"
    )
    dcnu: float = Field(
        default=0.0, ge=0, le=1, description="standard deviation of the photosites' dark currents, a fraction"
    )
    shot_noise: bool = Field(default=True, description="false: photons come as evenly as they never do")
    full_well_e: float | None = Field(default=None, gt=0, description="most charge that a photosite holds, electrons")
    blooming: float | None = Field(
        default=None, ge=0, le=1, description="fraction of what is too much that runs along its column (CCD)"
    )
    nonlinearity: Nonlinearity | None = Field(default=None, description="signal that is not in proportion to charge")
    dsnu_e: float | None = Field(default=None, ge=0, description="standard deviation of the dark offset, electrons")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Charge spills over a full well only."""
        if table.get("blooming") is not None and table.get("full_well_e") is None:
            yield "blooming", "there is no full_well_e that charge could spill over; give one"


class FlickerRows(Table):
    """1/f noise of the supply, seen as bands of rows."""

    sigma_e: float = Field(ge=0, description="standard deviation over the rows of a frame, electrons")
    exponent: float = Field(default=1.0, ge=0, le=2, description="power falls as 1/frequency^exponent")


class DualGain(Table):
    """A second, higher conversion gain."""

    from_iso: float = Field(gt=0, description="lowest ISO setting that uses it")
    full_well_e: float | None = Field(default=None, gt=0, description="full well in this mode, electrons")
    read_noise_e: float | None = Field(default=None, ge=0, description="read noise in this mode, electrons")


class Readout(Table):
    """From electrons to data numbers."""

    bit_depth: int = Field(ge=1, le=16, description="bits of a data number")
    black_level_dn: int = Field(ge=0, le=65534, description="data number of no charge")
    black_offsets_dn: list[list[int]] | None = Field(
        default=None,
        min_length=1,
        description="rows of offsets from it, repeated over the frame; such as [[0, 2], [1, 3]]",
    )
    base_iso: float = Field(gt=0, description="ISO setting at which electrons_per_dn holds")
    electrons_per_dn: float = Field(gt=0, description="electrons per data number at base_iso")
    reset_noise_e: float | None = Field(default=None, ge=0, description="kTC noise of the reset, electrons")
    read_noise_e: float | None = Field(default=None, ge=0, description="electrons, before gain")
    row_noise_e: float | None = Field(default=None, ge=0, description="offset of each row, fresh each frame, electrons")
    flicker_rows: FlickerRows | None = Field(default=None, description="1/f noise of the rows")
    column_noise_e: float | None = Field(default=None, ge=0, description="fixed offset of each column, electrons")
    dual_gain: DualGain | None = Field(default=None, description="a second, higher conversion gain")
    output_noise_dn: float | None = Field(default=None, ge=0, description="noise after the gain, data numbers")


class SensorFile(Table):
    """A camera body: lattice, photosite, filters, noise and analogue-to-digital conversion."""

    camsim: Literal["sensor/1"] = Field(description="format of this file")
    name: Name = Field(description="what reports and files call the camera")
    serial: int = Field(default=1, ge=0, le=2**63 - 1, description="seeds the fixed patterns")
    frame: SensorFrame = Field(description="the lattice of photosites")
    photosite: Photosite = Field(default=SquarePhotosite(kind="square"), description="the area that collects light")
    olpf: Olpf | None = Field(default=None, description="optical low-pass filter; leave out for none")
    filters: list[Filter] = Field(
        default=[], description="in front of the sensor (infrared cut, cover), fractions that pass; all multiply"
    )
    cfa: Cfa = Field(description="colour filter array")
    quantum_efficiency: QuantumEfficiency = Field(description="electrons per photon of each channel")
    charge: Charge = Field(default=Charge(), description="what a photosite does with charge")
    readout: Readout = Field(description="from electrons to data numbers")
