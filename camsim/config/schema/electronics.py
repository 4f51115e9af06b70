"""sensor/1, its electronics: the path of the charge, and the stage of the camera that each key makes."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import Makes, Name, Table, ToldBy, by_form
from camsim.core.annotations import Called
from camsim.core.typed import Fraction, NonNegative
from camsim.files.hot_list import Hot, read_hot
from camsim.sensor import conversion_gain
from camsim.sensor.conversion_gain import ReadOut
from camsim.sensor.stages import defects, flicker_rows, nonlinearity, telegraph_noise
from camsim.sensor.stages.blooming import Blooming
from camsim.sensor.stages.column_noise import ColumnNoise
from camsim.sensor.stages.crosstalk import Crosstalk
from camsim.sensor.stages.dark_current import DarkCurrent
from camsim.sensor.stages.dsnu import Dsnu
from camsim.sensor.stages.full_well import FullWell
from camsim.sensor.stages.offset_map import OffsetUnit
from camsim.sensor.stages.output_noise import OutputNoise
from camsim.sensor.stages.prnu import Prnu
from camsim.sensor.stages.read_noise import ReadNoise
from camsim.sensor.stages.reset_noise import ResetNoise
from camsim.sensor.stages.row_noise import RowNoise
from camsim.sensor.stages.shot_noise import ShotNoise

Place: TypeAlias = Annotated[int, Field(ge=0)]


class HotPhotosite(Table):
    """One photosite with more dark current."""

    row: int = Field(ge=0, description="from the top, 0 the first")
    col: int = Field(ge=0, description="from the left, 0 the first")
    e_per_s: float = Field(ge=0, description="its additional dark current, electrons per second")


HotPhotosites: TypeAlias = Annotated[Annotated[list[HotPhotosite], Tag("list")] | Annotated[Name, Tag("word")], by_form]


class Defects(Table):
    """Hot and dead photosites."""

    hot_fraction: float | None = Field(default=None, ge=0, le=1, description="share of photosites that are hot")
    hot_e_per_s: float | None = Field(
        default=None, ge=0, description="their mean dark current (distributed exponentially), electrons per second"
    )
    dead_fraction: float = Field(default=0.0, ge=0, le=1, description="share of photosites that see no light")
    hot: HotPhotosites = Field(
        default=[],
        description="hot ones by place, besides those drawn; or a CSV file with the columns row, col, e_per_s",
    )
    dead: list[Annotated[tuple[Place, Place], Called("a place [row, col]")]] = Field(
        default=[], description="dead ones by place, [row, col], besides those drawn"
    )

    def made(self, file: Path | None) -> defects.Defects:
        """Make the stage; ``file``: the list of hot photosites."""
        hot: tuple[Hot, ...]
        if isinstance(self.hot, str):
            hot = read_hot(file or Path(self.hot), self.hot)
        else:
            hot = tuple((one.row, one.col, one.e_per_s) for one in self.hot)
        return defects.Defects(
            hot_fraction=self.hot_fraction,
            hot_e_per_s=self.hot_e_per_s,
            dead_fraction=self.dead_fraction,
            hot=hot,
            dead=tuple(self.dead),
        )


class Polynomial(Table):
    """Response x·(1 + a₁u + a₂u² + …) with u = x/scale_e."""

    kind: Literal["polynomial"] = Field(description="how the non-linearity is given")
    coefficients: list[float] = Field(min_length=1, description="a₁, a₂, …: relative errors at scale_e")
    scale_e: float = Field(gt=0, description="charge at which u is 1, electrons; mostly the full well")

    def made(self) -> nonlinearity.PolynomialResponse:
        """Make the stage."""
        return nonlinearity.PolynomialResponse(tuple(self.coefficients), self.scale_e)


class ResponseTable(Table):
    """Response by a table, straight between its points."""

    kind: Literal["table"] = Field(description="how the non-linearity is given")
    electrons_in: list[NonNegative] = Field(min_length=2, description="charge, increasing, electrons")
    electrons_out: list[NonNegative] = Field(
        min_length=2, description="what a linear read-out would have called it, increasing, electrons"
    )

    def made(self) -> nonlinearity.ResponseTable:
        """Make the stage."""
        return nonlinearity.ResponseTable(tuple(self.electrons_in), tuple(self.electrons_out))


Nonlinearity: TypeAlias = Annotated[Polynomial | ResponseTable, ToldBy("kind")]


def _darks(name: str, path: Path | None) -> Any:
    from camsim.measure.dark_frames import read_darks  # which reads raw files; few sensors have any

    return read_darks(path or Path(name), name)


class Charge(Table):
    """The charge in a photosite; a stage that is left out has no effect."""

    prnu: Annotated[float | None, Makes("prnu", Prnu)] = Field(
        default=None, ge=0, le=1, description="standard deviation of the response, a fraction: 0.8 % is 0.008"
    )
    defects: Annotated[Defects | None, Makes("defects", Defects.made, reads=("hot",))] = Field(
        default=None, description="hot and dead photosites"
    )
    crosstalk: Annotated[
        list[Annotated[list[Fraction], Field(min_length=3, max_length=3)]] | None, Makes("crosstalk", Crosstalk)
    ] = Field(
        default=None,
        min_length=3,
        max_length=3,
        description="3 rows of 3 fractions: where a photosite's charge ends, the middle is itself; at most 1 together",
    )
    dark_current_e_per_s: Annotated[
        float | None,
        Makes("dark_current", DarkCurrent, also=("dcnu", "dark_current_at_c", "dark_current_doubles_every_c")),
    ] = Field(default=None, ge=0, description="charge without light, electrons per second")
    dark_current_at_c: float = Field(
        default=25.0, ge=-273.15, le=200, description="temperature at which dark_current_e_per_s holds, °C"
    )
    dark_current_doubles_every_c: float = Field(
        default=7.0, ge=1, le=1000, description="warming that doubles it, °C; silicon: 5 to 9"
    )
    dcnu: float = Field(
        default=0.0, ge=0, le=1, description="standard deviation of the photosites' dark currents, a fraction"
    )
    shot_noise: Annotated[bool, Makes("shot_noise", lambda there: ShotNoise() if there else None)] = Field(
        default=True, description="false: photons come as evenly as they never do"
    )
    full_well_e: Annotated[float | None, Makes("full_well", FullWell)] = Field(
        default=None, gt=0, description="most charge that a photosite holds, electrons"
    )
    blooming: Annotated[float | None, Makes("blooming", Blooming)] = Field(
        default=None, ge=0, le=1, description="fraction of what is too much that runs along its column (CCD)"
    )
    nonlinearity: Annotated[Nonlinearity | None, Makes("nonlinearity", lambda table: table.made())] = Field(
        default=None, description="signal that is not in proportion to charge"
    )
    dsnu_e: Annotated[float | None, Makes("dsnu", Dsnu)] = Field(
        default=None, ge=0, description="standard deviation of the dark offset, electrons"
    )
    dark_frames: Annotated[Name | None, Makes("dark_frames", _darks, reads=())] = Field(
        default=None,
        description="a folder of real darks, in place of all other noise in the dark: one, drawn at random, is added "
        "to each exposure",
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield faults: blooming without a full well, and details of a dark current without the current."""
        if table.get("dark_current_e_per_s") is None:
            for key in ("dark_current_at_c", "dark_current_doubles_every_c", "dcnu"):
                if table.get(key) is not None:
                    way_out = "give that too, 0 where only hot photosites gather charge"
                    yield key, f"does nothing without dark_current_e_per_s; {way_out}"
        if table.get("blooming") is not None and table.get("full_well_e") is None:
            yield "blooming", "there is no full_well_e that charge could spill over; give one"


class FlickerRows(Table):
    """1/f noise of the supply, seen as bands of rows."""

    sigma_e: float = Field(ge=0, description="standard deviation of a row over many frames, electrons")
    exponent: float = Field(default=1.0, ge=0, le=2, description="power falls as 1/frequency^exponent")

    def made(self) -> flicker_rows.FlickerRows:
        """Make the stage."""
        return flicker_rows.FlickerRows(self.sigma_e, self.exponent)


class TelegraphNoise(Table):
    """Photosites whose offset jumps between two values."""

    fraction: float = Field(ge=0, le=1, description="share of photosites that jump")
    amplitude_e: float = Field(ge=0, description="mean distance of the two (distributed exponentially), electrons")

    def made(self) -> telegraph_noise.TelegraphNoise:
        """Make the stage."""
        return telegraph_noise.TelegraphNoise(fraction=self.fraction, amplitude_e=self.amplitude_e)


class Companding(Table):
    """Fewer codes than data numbers: the stored codes, linear between points."""

    linear_dn: list[Place] = Field(
        min_length=2,
        description="data numbers, increasing from 0; the last is the largest that has a code",
    )
    codes: list[Place] = Field(min_length=2, description="what is stored for each, increasing, 65535 at most")


class OffsetMap(Table):
    """Offsets of the photosites, as they were measured."""

    file: Name = Field(
        description="an array (rows, cols; NPY, TIFF, EXR …), or a folder of darks, whose mean it is; its own mean is "
        "taken off, and where the sensor has more photosites it is repeated"
    )
    unit: OffsetUnit = Field(
        default="dn", description="dn: after the gain, the same at every ISO setting; electrons: before the gain"
    )

    def made(self, path: Path | None) -> Any:
        """Make the stage of the file at ``path``."""
        from camsim.measure.dark_frames import read_offsets  # which reads raw files

        return read_offsets(path or Path(self.file), self.file, self.unit)


class GainAtIso(Table):
    """The gain at an ISO setting, where it is not proportional to the ISO setting."""

    iso: float = Field(gt=0, description="the setting")
    electrons_per_dn: float = Field(gt=0, description="electrons per data number at that setting")


class DualGain(Table):
    """A second, higher conversion gain: from an ISO setting on, or in each exposure besides the lower one."""

    alternatives = (("from_iso", "electrons_per_dn"),)

    from_iso: float | None = Field(default=None, gt=0, description="lowest ISO setting that uses it")
    full_well_e: float | None = Field(default=None, gt=0, description="full well in this mode, electrons")
    read_noise_e: float | None = Field(default=None, ge=0, description="read noise in this mode, electrons")
    electrons_per_dn: float | None = Field(
        default=None,
        gt=0,
        description="instead of from_iso: at base_iso, where each exposure is read at both gains",
    )
    read: ReadOut | None = Field(
        default=None,
        description="which of the two images is recorded; left out, both are merged in 16 bits: the high gain's up to "
        "90 % of its white, the low gain's beyond",
    )

    def made(self) -> conversion_gain.DualGain:
        """Make the stage."""
        return conversion_gain.DualGain(
            from_iso=self.from_iso,
            capacity_e=self.full_well_e,
            read_noise_e=self.read_noise_e,
            electrons_per_dn=self.electrons_per_dn,
            read=self.read,
        )


class Readout(Table):
    """From electrons to data numbers."""

    bit_depth: int = Field(ge=1, le=16, description="bits of a data number")
    black_level_dn: int = Field(ge=0, le=65534, description="data number of no charge")
    black_offsets_dn: list[list[int]] | None = Field(
        default=None,
        min_length=1,
        description="rows of offsets from it, repeated over the frame; not all above 0, or below: [[0, 2], [1, 3]]",
    )
    base_iso: float = Field(gt=0, description="ISO setting at which electrons_per_dn holds")
    electrons_per_dn: float = Field(gt=0, description="electrons per data number at base_iso: 1/K of EMVA 1288")
    reset_noise_e: Annotated[float | None, Makes("reset_noise", ResetNoise)] = Field(
        default=None, ge=0, description="kTC noise of the reset, electrons"
    )
    gain_at_iso: list[GainAtIso] = Field(
        default=[],
        description="settings of other gains, increasing; electrons_per_dn · iso goes straight between, over log iso",
    )
    code_step_dn: float = Field(
        default=1.0, ge=1, le=32768, description="distance between codes: 16 where 12 bits are stored in 16"
    )
    companding: Companding | None = Field(
        default=None,
        description="what is stored for the converter's data numbers, which bit_depth and levels are of; DNGs "
        "carry the table that undoes it",
    )
    read_noise_e: Annotated[
        float | None,
        Makes(
            "read_noise",
            ReadNoise,
            also=("read_noise_student_dof", "read_noise_tukey_lambda", "read_noise_spread"),
        ),
    ] = Field(default=None, ge=0, description="electrons, before gain")
    read_noise_student_dof: float | None = Field(
        default=None, gt=2, le=1000, description="heavy tails: degrees of freedom of Student's t"
    )
    read_noise_tukey_lambda: float | None = Field(
        default=None, gt=-0.5, le=0.2, description="heavy tails: shape of Tukey's λ law, 0.13 nearly normal"
    )
    read_noise_spread: float = Field(
        default=0.0, ge=0, le=2, description="standard deviation of the logarithm of the photosites' own read noise"
    )
    telegraph_noise: Annotated[TelegraphNoise | None, Makes("telegraph_noise", TelegraphNoise.made)] = Field(
        default=None, description="photosites whose offset jumps between two values"
    )
    row_noise_e: Annotated[float | None, Makes("row_noise", RowNoise)] = Field(
        default=None, ge=0, description="offset of each row, fresh each frame, electrons"
    )
    flicker_rows: Annotated[FlickerRows | None, Makes("flicker_rows", FlickerRows.made)] = Field(
        default=None, description="1/f noise of the rows"
    )
    column_noise_e: Annotated[float | None, Makes("column_noise", ColumnNoise)] = Field(
        default=None, ge=0, description="fixed offset of each column, electrons"
    )
    offset_map: Annotated[OffsetMap | None, Makes("offset_map", OffsetMap.made, reads=("file",))] = Field(
        default=None, description="a fixed offset of each photosite, from a file"
    )
    dual_gain: Annotated[DualGain | None, Makes("dual_gain", DualGain.made)] = Field(
        default=None, description="a second, higher conversion gain"
    )
    output_noise_dn: Annotated[float | None, Makes("output_noise", OutputNoise)] = Field(
        default=None, ge=0, description="noise after the gain, data numbers"
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield faults: details of a read noise without the noise."""
        if table.get("read_noise_e") is None:
            for key in ("read_noise_student_dof", "read_noise_tukey_lambda", "read_noise_spread"):
                if table.get(key) is not None:
                    yield key, "does nothing without read_noise_e; give that too"
