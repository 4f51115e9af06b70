"""The camera: its stages, in the order light meets them. What happens when it exposes is in ``exposing``."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.frame import Frame
from camsim.optics import FourSpotOlpf, Lens, OpticalSystem, PhotositeShape
from camsim.rendering import Grid
from camsim.scene import Scene
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa
from camsim.sensor.chain import STAGES
from camsim.sensor.colour_matrix import ColourResponse, MatrixOf
from camsim.sensor.conversion_gain import DualGain
from camsim.sensor.exposure import Exposure, auto_time_s, electrons_per_reflectance
from camsim.sensor.falloff import Falloff, working_f_number
from camsim.sensor.linearity import Nonlinearity
from camsim.sensor.neighbours import Blooming, Crosstalk, Defects
from camsim.sensor.noise import (
    ColumnNoise,
    DarkCurrent,
    Dsnu,
    FlickerRows,
    FullWell,
    OutputNoise,
    Prnu,
    ReadNoise,
    ResetNoise,
    RowNoise,
    ShotNoise,
)
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import Spectrum
from camsim.spectra.light import Light, LightSamples
from camsim.window import Region as Region
from camsim.window import grid_of


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A lens and a sensor, stage by stage; a stage that is None is left out.

    name       : of the model, goes into files
    serial     : seeds the fixed patterns
    rows, cols : of the full frame;  pitch_um: distance between photosites, µm
    filters    : in front of the sensor (infrared cut, grey, colour): fractions that pass, all of them multiply
    magnification : image size over object size; makes the working f-number N·(1 + m), in brightness and in blur
    falloff    : light towards the corners, relative to the axis
    """

    name: str = "camera"
    serial: int = 1
    rows: int
    cols: int
    pitch_um: float
    lens: Lens
    olpf: FourSpotOlpf | None = None
    photosite: PhotositeShape
    cfa: Cfa
    quantum_efficiency: QuantumEfficiency
    filters: tuple[Spectrum, ...] = ()
    magnification: float = 0.0
    falloff: Falloff | None = None
    prnu: Prnu | None = None
    defects: Defects | None = None
    crosstalk: Crosstalk | None = None
    dark_current: DarkCurrent | None = None
    shot_noise: ShotNoise | None = ShotNoise()  # noqa: RUF009 (frozen, without fields)
    full_well: FullWell | None = None
    blooming: Blooming | None = None
    nonlinearity: Nonlinearity | None = None
    reset_noise: ResetNoise | None = None
    read_noise: ReadNoise | None = None
    row_noise: RowNoise | None = None
    flicker_rows: FlickerRows | None = None
    column_noise: ColumnNoise | None = None
    dsnu: Dsnu | None = None
    dual_gain: DualGain | None = None
    output_noise: OutputNoise | None = None
    adc: Adc

    def __post_init__(self) -> None:
        object.__setattr__(self, "filters", tuple(self.filters))
        working_f_number(self.lens.f_number, self.magnification)
        if self.blooming is not None and self.full_well is None:
            raise InvalidValueError("blooming: there is no full_well that charge could spill over; give one")

    @classmethod
    def from_yaml(cls, sensor: str | os.PathLike[str], *, lens: Lens) -> Camera:
        """Return the camera of a sensor file (a path, or the name of a shipped one) behind ``lens``."""
        from camsim.capturing import load_camera  # the one door upward: the name users look for is here

        return load_camera(sensor, lens=lens)

    def replace(self, **changes: Any) -> Camera:
        """Return a camera with some stages exchanged, such as ``replace(olpf=None)``."""
        return dataclasses.replace(self, **changes)

    @property
    def working_f_number(self) -> float:
        """The f-number as the sensor sees it, N·(1 + m)."""
        return working_f_number(self.lens.f_number, self.magnification)

    @property
    def optics(self) -> OpticalSystem:
        """Lens (at its working f-number), OLPF and photosite as one."""
        lens = dataclasses.replace(self.lens, f_number=self.working_f_number) if self.magnification else self.lens
        return OpticalSystem(lens=lens, olpf=self.olpf, photosite=self.photosite)

    def samples(self, light: Light, surfaces: Iterable[Spectrum] = ()) -> LightSamples:
        """Return a light at nodes that follow every curve it meets: surfaces, lens, filters, quantum efficiency."""
        efficiencies = [curve for _, curve in self.quantum_efficiency.select(self.cfa.channels).curves]
        passes = ([spectrum] for spectrum in (self.lens.transmission, *self.filters))
        return light.samples(surfaces, *passes, efficiencies)

    def electrons_per_reflectance(self, samples: LightSamples, time_s: float) -> F64:
        """Return (channels, n) mean electrons of a perfect diffuser at every wavelength, on the optical axis.

        samples : as ``samples`` returns them;  before crosstalk
        """
        return electrons_per_reflectance(
            samples,
            f_number=self.working_f_number,
            transmission=self.lens.transmission,
            filters=self.filters,
            quantum_efficiency=self.quantum_efficiency.select(self.cfa.channels),
            photosite_area_um2=self.photosite.area_um2,
            time_s=time_s,
        )

    def diffuser_electrons(self, light: Light, time_s: float) -> F64:
        """Return (channels,) mean electrons of a perfect diffuser on the optical axis, after crosstalk."""
        own_e: F64 = self.electrons_per_reflectance(self.samples(light), time_s).sum(axis=1)
        return own_e if self.crosstalk is None else self.crosstalk.mixing(self.cfa) @ own_e

    def colour_response(self, light: Light, matrix: MatrixOf = "standard") -> ColourResponse:
        """Return how the channels see light, the capture's and others, for white balance and colour matrices."""
        return ColourResponse(
            quantum_efficiency=self.quantum_efficiency.select(self.cfa.channels),
            passes=self.filters if light.at == "sensor" else (self.lens.transmission, *self.filters),
            crosstalk=None if self.crosstalk is None else tuple(map(tuple, self.crosstalk.mixing(self.cfa).tolist())),
            light=light,
            matrix=matrix,
        )

    def full_well_at(self, iso: float) -> FullWell | None:
        """Return the full well at an ISO setting: a high conversion gain holds less."""
        dual = self.dual_gain
        if dual is None or dual.capacity_e is None or iso < dual.from_iso:
            return self.full_well
        return FullWell(dual.capacity_e)

    def read_noise_at(self, iso: float) -> ReadNoise | None:
        """Return the read noise at an ISO setting: a high conversion gain is quieter."""
        dual = self.dual_gain
        if dual is None or dual.read_noise_e is None or iso < dual.from_iso:
            return self.read_noise
        return ReadNoise(dual.read_noise_e)

    def dark_noise_e(self, iso: float) -> float:
        """Return all temporal noise of the read-out at an ISO setting as one standard deviation, electrons."""
        read = self.read_noise_at(iso)
        output_e = self.output_noise.sigma_e(self.adc.electrons_per_dn_at(iso)) if self.output_noise else 0.0
        stages = (self.reset_noise, read, self.row_noise, self.flicker_rows)
        return math.hypot(output_e, *(stage.sigma_e for stage in stages if stage is not None))

    def well_as_read_e(self, iso: float) -> float | None:
        """Return the full well as the converter sees it, after the non-linearity; None without a full well."""
        well = self.full_well_at(iso)
        if well is None:
            return None
        if self.nonlinearity is None:
            return well.capacity_e
        return float(self.nonlinearity.apply(np.array([well.capacity_e]))[0])

    def exposure_time_s(self, light: Light, exposure: Exposure) -> float:
        """Return the exposure time; "auto" puts the most responsive channel's white at 80 % of black..white."""
        if not isinstance(exposure.time_s, str):
            return exposure.time_s
        return auto_time_s(
            self.diffuser_electrons(light, 1.0),
            saturation_e=self.adc.saturation_e(exposure.iso, self.well_as_read_e(exposure.iso)),
        )

    def grid(self, region: Region | None = None) -> Grid:
        """Return the photosites of a window, None for all of the frame."""
        return grid_of(region, frame=(self.rows, self.cols), period=self.cfa.period, pitch_um=self.pitch_um)

    def expose(
        self,
        scene: Scene,
        *,
        light: Light,
        exposure: Exposure,
        seed: int = 0,
        frame_number: int = 0,
        region: Region | None = None,
        tolerance: float = 1e-6,
        method: str = "auto",
        strict: bool = False,
        noise: bool = True,
        colour_matrix: MatrixOf = "standard",
        spectral_nm: Sequence[float] | None = None,
        scene_name: str = "scene",
        products: Collection[str] = ("mosaic",),
        progress: Callable[[str, float], None] | None = None,
    ) -> Frame:
        """Take a picture; the arguments are those of ``Capture`` and of its ``frame``.

        ``Capture`` itself takes several pictures of a scene (``frames``), or one that memory need not hold (``rows``).
        """
        from camsim.exposing import Capture  # the door upward, as in from_yaml

        capture = Capture(
            camera=self,
            scene=scene,
            light=light,
            exposure=exposure,
            seed=seed,
            frame_number=frame_number,
            region=region,
            tolerance=tolerance,
            method=method,
            strict=strict,
            noise=noise,
            colour_matrix=colour_matrix,
            spectral_nm=spectral_nm,
            scene_name=scene_name,
        )
        return capture.frame(products=products, progress=progress)

    def electronics(self, iso: float) -> Mapping[str, Any]:
        """Return the electronic stages at an ISO setting by the names and in the order of ``sensor.chain.record``."""
        stages = {name: getattr(self, name) for name in STAGES}
        return stages | {"full_well": self.full_well_at(iso), "read_noise": self.read_noise_at(iso)}
