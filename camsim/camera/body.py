"""A camera's body and lens: the stages in the order of the light path, and quantities derived from them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Self, TypeAlias, Unpack

import numpy as np
from annotated_types import MinLen

from camsim.camera.window import Region, grid_of
from camsim.core.annotations import Called
from camsim.core.arrays import F64
from camsim.core.custom import is_custom
from camsim.core.typed import Count, FNumber, Number, Pitch, Seed, Several, Whole, check, refusal, spelled_out
from camsim.errors import UnknownNameError
from camsim.optics import Lens, LowPass, OpticalStage, OpticalSystem, PhotositeShape
from camsim.optics.custom import check_blur, check_custom, check_extent, settled
from camsim.optics.protocols import KnowsOpening
from camsim.rendering import Grid
from camsim.rendering.veil import Veil
from camsim.scene import Scene
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa, filters_of
from camsim.sensor.colour_matrix import ColourResponse, MatrixOf
from camsim.sensor.conversion_gain import DualGain
from camsim.sensor.electronics import ElectronicChanges, Electronics
from camsim.sensor.exposure import AUTO_LEVEL, Exposure, auto_time_s, electrons_per_reflectance
from camsim.sensor.falloff import Falloff, Magnification, working_f_number
from camsim.sensor.measured_matrix import MeasuredMatrix
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.sensor.stage import ElectronicStage
from camsim.sensor.stages.full_well import FullWell
from camsim.sensor.stages.nonlinearity import charge_e
from camsim.sensor.stages.read_noise import ReadNoise
from camsim.spectra.curve import Curve, Filter, NumberOrCurve, Spectrum, Transmission
from camsim.spectra.light import Light, LightSamples

CustomLens: TypeAlias = Annotated[
    Lens, Called("a lens", "such as Airy(f_number=8); a custom one has f_number, transmission and otf")
]
Photosite: TypeAlias = Annotated[PhotositeShape, Called("a photosite", "such as SquarePhotosite(side_um=…)")]
Blur: TypeAlias = Annotated[OpticalStage, Called("a stage with otf(fx_per_um, fy_per_um, wavelength_nm)")]
Olpf: TypeAlias = Annotated[LowPass, Called("an OLPF", "such as FourSpotOlpf(split_um=…)")]

_FINEST_STEP_E = 2.0**-60  # for channels without response to the light

MID_GREY = 0.18
"""Mid-tone level as a share of black..white: an 18 % grey card exposed so that white just clips."""


class Changes(ElectronicChanges, total=False):
    """What ``replace`` may exchange: the fields of ``Body``."""

    name: str
    serial: Whole
    rows: Whole
    cols: Whole
    pitch_um: Number
    lens: Lens
    olpf: LowPass | None
    photosite: PhotositeShape
    cfa: Cfa
    quantum_efficiency: QuantumEfficiency
    colour_matrices: Several[MeasuredMatrix]
    filters: Several[NumberOrCurve]
    magnification: Number
    falloff: Falloff | None
    veiling_glare: NumberOrCurve
    dual_gain: DualGain | None
    adc: Adc
    extra_optics: Several[OpticalStage]


@dataclass(frozen=True, kw_only=True)
class Body(Electronics):
    """A lens and a sensor, stage by stage; a stage that is None is left out. Electronic stages: ``Electronics``.

    name       : name of the model; written to files
    serial     : seeds the fixed patterns
    rows, cols : size of the full frame;  pitch_um: distance between photosites, µm
    colour_matrices : measured on a chart (``camsim calibrate colour``); written to files in place of fitted ones
    filters    : in front of the sensor (infrared cut, grey, colour): transmissions, multiplied
    magnification : image size over object size; makes the working f-number N·(1 + m), in brightness and in blur
    falloff    : relative illumination over the frame, 1 on the axis
    veiling_glare : fraction of the light that is spread evenly over the frame (docs/glare.md)
    extra_optics : custom optical stages besides the lens (docs/developers.md), such as haze
    """

    name: Annotated[str, MinLen(1)] = "camera"
    serial: Seed = 1
    rows: Count
    cols: Count
    pitch_um: Pitch
    lens: CustomLens
    olpf: Olpf | None = None
    photosite: Photosite
    cfa: Cfa
    quantum_efficiency: QuantumEfficiency
    colour_matrices: Several[MeasuredMatrix] = dataclasses.field(default=(), metadata={"described": "if any"})
    filters: Several[Filter] = ()
    magnification: Magnification = 0.0
    falloff: Falloff | None = None
    veiling_glare: Transmission = dataclasses.field(default=0.0, metadata={"described": "if any"})
    dual_gain: DualGain | None = None
    adc: Adc
    extra_optics: Several[Blur] = dataclasses.field(default=(), metadata={"described": "if any"})

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            name: str = "camera",
            serial: Whole = 1,
            rows: Whole,
            cols: Whole,
            pitch_um: Number,
            lens: Lens,
            olpf: LowPass | None = None,
            photosite: PhotositeShape,
            cfa: Cfa,
            quantum_efficiency: QuantumEfficiency,
            colour_matrices: Several[MeasuredMatrix] = (),
            filters: Several[NumberOrCurve] = (),
            magnification: Number = 0.0,
            falloff: Falloff | None = None,
            veiling_glare: NumberOrCurve = 0.0,
            dual_gain: DualGain | None = None,
            adc: Adc,
            extra_optics: Several[OpticalStage] = (),
            **electronics: Unpack[ElectronicChanges],
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in ("lens", "olpf", "photosite"):
            check_custom(getattr(self, key), key)
        for blur in self.extra_optics:
            check_custom(blur, "extra_optics")
            check_blur(blur)
        check(self.lens.f_number, FNumber, "f_number", type(self.lens).__name__)
        if is_custom(self.lens):
            farthest_um = 0.5 * self.pitch_um * math.hypot(self.rows, self.cols)
            object.__setattr__(self, "lens", settled(self.lens, farthest_um))
        known = self.quantum_efficiency.channels
        if "G" in known and "g" in known and "g" not in self.cfa.channels:
            object.__setattr__(self, "cfa", self.cfa.greens_apart())
            if "g" not in self.cfa.channels:
                message = "curves of Gr and Gb, and no row of the cfa has green and blue without red; give one of G"
                raise refusal(self, "quantum_efficiency", message)
        if missing := [letter for letter in self.cfa.channels if letter not in known]:
            message = f"no curve for {', '.join(missing)} of the cfa; there are {', '.join(known)}"
            raise refusal(self, "quantum_efficiency", message)
        if self.colour_matrices and sorted(filters_of(self.cfa.channels)) != ["B", "G", "R"]:
            message = f"are of red, green and blue, and the cfa has {', '.join(self.cfa.channels)}; leave them out"
            raise refusal(self, "colour_matrices", message)
        listed = () if self.defects is None else (*self.defects.hot, *self.defects.dead)
        if outside := [place[:2] for place in listed if place[0] >= self.rows or place[1] >= self.cols]:
            places = ", ".join(f"({row}, {col})" for row, col in outside[:3])
            raise refusal(self, "defects", f"no photosite {places} in a frame of {self.rows} × {self.cols}")
        well, high = self.full_well, self.dual_gain
        if well and high and high.capacity_e and high.capacity_e > well.capacity_e:
            message = f"holds {high.capacity_e:g} e⁻, and the full well is {well.capacity_e:g} e⁻"
            raise refusal(self, "dual_gain", f"{message}; a high conversion gain holds less, give it no more")
        if high and high.electrons_per_dn is not None:
            if high.electrons_per_dn >= self.adc.electrons_per_dn:
                message = f"has {high.electrons_per_dn:g} electrons_per_dn, and the low gain's are"
                way_out = "a high conversion gain has fewer"
                raise refusal(self, "dual_gain", f"{message} {self.adc.electrons_per_dn:g}; {way_out}")
            if self.adc.companding:
                raise refusal(
                    self, "dual_gain", "reads both gains, whose codes are not companded; leave one of them out"
                )
        if is_custom(self.photosite):
            check_extent(self.photosite)
        widest_um = 2.0 * max(self.photosite.half_extent_um)
        if widest_um > self.pitch_um * (1.0 + 1e-9):
            overlap = f"is {widest_um:g} µm wide; photosites may not overlap, and the pitch is {self.pitch_um:g} µm"
            raise refusal(self, "photosite", overlap)
        if not self.photosite.area_um2 > 0.0:
            raise refusal(self, "photosite", "has no area and sees no light; give one with a side above 0")

    @spelled_out(Changes)
    def replace(self, **changes: Unpack[Changes]) -> Self:
        """Return a camera with some stages exchanged, such as ``replace(olpf=None)``."""
        known = [field.name for field in dataclasses.fields(self)]
        for name in changes:
            if name not in known:
                raise UnknownNameError("parameter", name, known, stage=type(self).__name__)
        exchanged: dict[str, Any] = {**changes}  # dataclasses.replace is typed for the stored field types only
        return dataclasses.replace(self, **exchanged)

    @property
    def working_f_number(self) -> float:
        """The working f-number N·(1 + m)."""
        return working_f_number(self.lens.f_number, self.magnification)

    @property
    def opening(self) -> float:
        """Area of the lens's pupil as a fraction of the full circle of diameter f/N, and so of that circle's light."""
        return self.lens.opening if isinstance(self.lens, KnowsOpening) else 1.0

    @property
    def optics(self) -> OpticalSystem:
        """Lens (at its working f-number), custom blurs, OLPF and photosite as one optical system."""
        lens = dataclasses.replace(self.lens, f_number=self.working_f_number) if self.magnification else self.lens
        return OpticalSystem(lens=lens, olpf=self.olpf, photosite=self.photosite, more=tuple(self.extra_optics))

    def _open_curves(self) -> Iterator[tuple[str, Curve]]:
        """Yield the curves without a declared value outside their tables, each with the name of its parameter."""
        seen = self.cfa.channels
        efficiencies = [("quantum_efficiency", c) for letter, c in self.quantum_efficiency.curves if letter in seen]
        for part, curve in (*efficiencies, *(("filters", spectrum) for spectrum in self.filters)):
            if isinstance(curve, Curve) and curve.outside is None:
                yield part, curve

    def with_ends(self, light: Light | None) -> Self:
        """Return the camera with 0 beyond the ends of every curve that does not declare what holds there.

        Raises InvalidValueError if the light has power there. ``light`` None: no spectrum passes through the curves.
        """
        opened = list(self._open_curves())
        if not opened:
            return self
        for part, curve in opened:
            if light is not None and (missing := light.beyond(curve)):
                way_out = "extend the table, or say outside='zero' (or 'hold') of the curve"
                raise refusal(self, part, f"{missing}; {way_out}")
        curves = tuple((letter, curve.going_on("zero")) for letter, curve in self.quantum_efficiency.curves)
        filters = tuple(f.going_on("zero") if isinstance(f, Curve) else f for f in self.filters)
        efficiency = dataclasses.replace(self.quantum_efficiency, curves=curves)
        return self.replace(quantum_efficiency=efficiency, filters=filters)

    def samples(self, light: Light, surfaces: Iterable[Spectrum] = ()) -> LightSamples:
        """Return a light at quadrature nodes that resolve every curve: surfaces, lens, filters, quantum efficiency."""
        efficiencies = [curve for _, curve in self.quantum_efficiency.select(self.cfa.channels).curves]
        passes = ([spectrum] for spectrum in (self.lens.transmission, self.veiling_glare, *self.filters))
        return light.samples(surfaces, *passes, efficiencies)

    def dimmed_by(self, light: Light) -> tuple[tuple[str, Spectrum], ...]:
        """Return the transmissions between light and photosites, by name; light given on the sensor passes no lens."""
        lens = () if light.at == "sensor" else (("lens", self.lens.transmission),)
        return *lens, *((f"filter {number}", spectrum) for number, spectrum in enumerate(self.filters, 1))

    def electrons_per_reflectance(self, samples: LightSamples, time_s: float) -> F64:
        """Return (channels, n) mean electrons of a perfect diffuser on the optical axis, per wavelength node.

        samples : as ``samples`` returns them. The electrons are those before crosstalk.
        """
        return electrons_per_reflectance(
            samples,
            f_number=self.working_f_number,
            transmission=self.lens.transmission,
            filters=tuple(self.filters),
            quantum_efficiency=self.quantum_efficiency.select(self.cfa.channels),
            photosite_area_um2=self.photosite.area_um2,
            time_s=time_s,
            opening=self.opening,
        )

    def diffuser_electrons(self, light: Light, time_s: float) -> F64:
        """Return (channels,) mean electrons of a perfect diffuser on the optical axis, after crosstalk."""
        return self.after_crosstalk(self.electrons_per_reflectance(self.samples(light), time_s).sum(axis=1))

    def steps_e(self, light: Light, time_s: float, tolerance: float) -> tuple[float, ...]:
        """Return ``Frame.steps_e`` of each channel: a power of two whose half is at most 1/1000 of the tolerance."""
        finest_e = np.maximum(2e-3 * tolerance * self.diffuser_electrons(light, time_s), _FINEST_STEP_E)
        return tuple(np.ldexp(1.0, np.frexp(finest_e)[1] - 1).tolist())

    def after_crosstalk(self, each_e: F64) -> F64:
        """Return (channels, …) mean electrons under flat light after crosstalk; ``each_e``: those before it."""
        return each_e if self.crosstalk is None else self.crosstalk.mixing(self.cfa) @ each_e

    @property
    def prnu_on_grey(self) -> float:
        """PRNU as measured in a frame with equal channels: crosstalk averages neighbours, and so makes it smaller."""
        if self.prnu is None or self.crosstalk is None:
            return 0.0 if self.prnu is None else self.prnu.fraction
        even = np.ones(len(self.cfa.channels))
        return self.prnu.fraction * float(self.crosstalk.left_of_pattern(self.cfa, even)[0])

    def colour_response(self, light: Light, matrix: MatrixOf = "standard") -> ColourResponse:
        """Return the channels' spectral response, for white balance and colour matrices."""
        return ColourResponse(
            quantum_efficiency=self.quantum_efficiency.select(self.cfa.channels),
            passes=tuple(passes for _, passes in self.dimmed_by(light)),
            crosstalk=None if self.crosstalk is None else tuple(map(tuple, self.crosstalk.mixing(self.cfa).tolist())),
            light=light,
            matrix=matrix,
            measured=tuple(self.colour_matrices),
        )

    def image_per_reflectance(self, samples: LightSamples) -> F64:
        """Return (channels, n) electrons per J/m² of a perfect diffuser's image, without its share of veiling glare."""
        return self.veil.spared(self.electrons_per_reflectance(samples, 1.0), samples.wavelength_nm)

    def veil_of(self, scene: Scene, samples: LightSamples, tolerance: float) -> F64:
        """Return (channels,) the uniform veiling glare on the axis, electrons per J/m²."""
        response = self.electrons_per_reflectance(samples, 1.0)
        return self.veil.light(scene, response, samples.wavelength_nm, tolerance)

    @property
    def veil(self) -> Veil:
        """The veiling-glare model."""
        return Veil(share=self.veiling_glare, frame=self.grid())

    @property
    def converter(self) -> Adc:
        """The converter of the recorded codes: ``adc``, or if exposures are read twice, the recorded read-out's."""
        return self.adc if self.dual_gain is None else self.dual_gain.converter(self.adc)

    @property
    def read_outs(self) -> tuple[Self, ...]:
        """The cameras that read an exposure: this one, or with merged dual gain two, one of each gain."""
        dual = self.dual_gain
        if dual is None or dual.read != "merged":
            return (self,)
        return tuple(self.replace(dual_gain=dataclasses.replace(dual, read=read)) for read in ("low", "high"))

    @property
    def read_out_number(self) -> int:
        """Index of this read-out within an exposure; low and high gain differ in it, so their noise is independent."""
        return int(self.dual_gain is not None and self.dual_gain.read == "high")

    def full_well_at(self, iso: float) -> FullWell | None:
        """Return the full well at an ISO setting; it is smaller at high conversion gain."""
        dual = self.dual_gain
        if dual is None or dual.capacity_e is None or not dual.is_small_at(iso):
            return self.full_well
        return FullWell(dual.capacity_e)

    def read_noise_at(self, iso: float) -> ReadNoise | None:
        """Return the read noise at an ISO setting; it is lower at high conversion gain."""
        dual = self.dual_gain
        if dual is None or dual.read_noise_e is None or not dual.has_low_noise_at(iso):
            return self.read_noise
        if self.read_noise is None:
            return ReadNoise(dual.read_noise_e)
        return dataclasses.replace(self.read_noise, sigma_e=dual.read_noise_e)

    def dark_noise_e(self, iso: float) -> float:
        """Return the standard deviation of the total temporal read-out noise at an ISO setting, electrons."""
        electrons_per_dn = self.converter.electrons_per_dn_at(iso)
        return math.hypot(*(stage.dark_noise_e(electrons_per_dn) for stage in self.electronics(iso)))

    def dark_e(self, time_s: float, temperature_c: float | None) -> float:
        """Return the mean dark charge of all photosites, electrons."""
        current = self.dark_current
        return 0.0 if current is None else current.e_per_s * time_s * current.warming(temperature_c)

    def well_as_read_e(self, iso: float) -> float | None:
        """Return the full well after the non-linearity, in electrons as read; None without a full well.

        With two merged read-outs: the upper limit of the low-gain converter, if that is lower.
        """
        well = self.full_well_at(iso)
        read_e = None if well is None else well.capacity_e
        if read_e is not None and self.nonlinearity is not None:
            read_e = float(self.nonlinearity.response(np.array([read_e]))[0])
        if self.dual_gain is None or self.dual_gain.read != "merged":
            return read_e
        low_e = self.adc.saturation_e(iso)
        return low_e if read_e is None else min(read_e, low_e)

    def charge_at_e(self, share: float, iso: float) -> float:
        """Return the charge whose code lies at a share of black..white; share 1 is the clipping level."""
        signal_e = share * self.converter.saturation_e(iso, self.well_as_read_e(iso))
        return signal_e if self.nonlinearity is None else charge_e(self.nonlinearity, signal_e)

    def shot_e2_per_e(self, iso: float) -> float:
        """Return the variance of shot noise per electron of signal, both as read at mid-grey; 1 if linear.

        The shot noise of a charge q is √q. A non-linear read-out r maps q ± √q to r(q ± √q): half their difference is
        the noise as read, and its square over r(q) is returned. It depends on q; the value holds at mid-grey, where
        most of a picture lies.
        """
        if self.shot_noise is None or self.nonlinearity is None:
            return float(self.shot_noise is not None)
        charge_e = self.charge_at_e(MID_GREY, iso)
        low_e, signal_e, high_e = self.nonlinearity.response(
            charge_e + math.sqrt(charge_e) * np.array([-1.0, 0.0, 1.0])
        )
        return float((0.5 * (high_e - low_e)) ** 2 / signal_e)

    def exposure_time_s(self, light: Light, exposure: Exposure) -> float:
        """Return the exposure time; "auto" puts the most responsive channel's white at 80 % of black..white."""
        if not isinstance(exposure.time_s, str):
            return exposure.time_s
        level_e = self.charge_at_e(AUTO_LEVEL, exposure.iso)
        return auto_time_s(self.diffuser_electrons(light, 1.0), level_e=level_e)

    def grid(self, region: Region | None = None) -> Grid:
        """Return the photosite grid of a window; None: the full frame."""
        check(region, Region | None, "region")
        return grid_of(region, frame=(self.rows, self.cols), period=self.cfa.period, pitch_um=self.pitch_um)

    def electronics(self, iso: float, *, noise: bool = True) -> tuple[ElectronicStage, ...]:
        """Return the electronic stages active at an ISO setting; without noise only the deterministic ones."""
        set_to = self.replace(full_well=self.full_well_at(iso), read_noise=self.read_noise_at(iso))
        return tuple(stage for stage in set_to.stages if noise or stage.without_noise)

    @property
    def needs_whole_window(self) -> bool:
        """Whether a stage needs all rows at once, so that a window cannot be recorded band by band."""
        return any(stage.whole_window for stage in self.stages)
