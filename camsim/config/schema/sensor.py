"""sensor/1: one camera body."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import Curve, Letter, Name, Table, by_form


class SensorFrame(Table):
    """The lattice of photosites."""

    rows: int = Field(ge=1, description="photosites from top to bottom")
    cols: int = Field(ge=1, description="photosites from left to right")
    pitch_um: float = Field(gt=0, description="distance between centres of neighbouring photosites, µm")


class SquarePhotosite(Table):
    """A square that collects light evenly."""

    kind: Literal["square"] = Field(description="shape of the area that collects light")
    fill_factor: float = Field(
        default=1.0, gt=0, le=1, description="fraction of the pitch's area that collects light"
    )


class FourSpotOlpf(Table):
    """Two birefringent plates: every point becomes four."""

    kind: Literal["four-spot"] = Field(description="what the filter makes of a point")
    split_um: float = Field(gt=0, description="full distance between two neighbouring spots, µm")


class BayerCfa(Table):
    """Red, green and blue in the pattern of Bayer."""

    kind: Literal["bayer"] = Field(description="which colour filter array")
    pattern: Literal["RGGB", "BGGR", "GRBG", "GBRG"] = Field(
        description="letters of photosites (0,0) (0,1) (1,0) (1,1)"
    )


class MonoCfa(Table):
    """No colour filters: one channel, Y."""

    kind: Literal["mono"] = Field(description="which colour filter array")


Cfa: TypeAlias = Annotated[BayerCfa | MonoCfa, Field(discriminator="kind")]
Curves: TypeAlias = Annotated[
    Annotated[Name, Tag("word")] | Annotated[dict[Letter, Curve], Tag("table")], by_form
]


class QuantumEfficiency(Table):
    """Electrons per photon of each channel, filters of the sensor included."""

    curves: Curves = Field(
        description="relative; a table has a curve per letter of the cfa; names: camsim list sensitivities"
    )
    per: Literal["energy", "photon"] = Field(
        description="what the curves respond to: equal energy or equal numbers of photons"
    )
    peak: float = Field(gt=0, le=1, description="electrons per photon at the highest point of all channels")


class Charge(Table):
    """What a photosite does with charge; a stage that is left out does not happen."""

    full_well_e: float | None = Field(
        default=None, gt=0, description="most charge that a photosite holds, electrons"
    )
    dark_current_e_per_s: float | None = Field(
        default=None, ge=0, description="charge without light, electrons per second"
    )
    prnu: float | None = Field(
        default=None, ge=0, le=1, description="standard deviation of the response, a fraction"
    )
    dsnu_e: float | None = Field(
        default=None, ge=0, description="standard deviation of the dark offset, electrons"
    )


class Readout(Table):
    """From electrons to data numbers."""

    bit_depth: int = Field(ge=1, le=16, description="bits of a data number")
    black_level_dn: int = Field(ge=0, le=65534, description="data number of no charge")
    base_iso: float = Field(gt=0, description="ISO setting at which electrons_per_dn holds")
    electrons_per_dn: float = Field(gt=0, description="electrons per data number at base_iso")
    read_noise_e: float | None = Field(default=None, ge=0, description="electrons, before gain")


class SensorFile(Table):
    """A camera body: lattice, photosite, filters, noise and analogue-to-digital conversion."""

    camsim: Literal["sensor/1"] = Field(description="format of this file")
    name: Name = Field(description="what reports and files call the camera")
    serial: int = Field(default=1, ge=0, le=2**63 - 1, description="seeds the fixed patterns")
    frame: SensorFrame = Field(description="the lattice of photosites")
    photosite: SquarePhotosite = Field(
        default=SquarePhotosite(kind="square"), description="the area that collects light"
    )
    olpf: FourSpotOlpf | None = Field(default=None, description="optical low-pass filter; leave out for none")
    cfa: Cfa = Field(description="colour filter array")
    quantum_efficiency: QuantumEfficiency = Field(description="electrons per photon of each channel")
    charge: Charge = Field(default=Charge(), description="what a photosite does with charge")
    readout: Readout = Field(description="from electrons to data numbers")
