"""The camera: its stages, in the order light meets them, and ``expose``, which is the pipeline."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.arrays import F32, F64, U16
from camsim.description import describe
from camsim.errors import InvalidValueError
from camsim.frame import Frame, Report, check_products
from camsim.optics import Airy, FourSpotOlpf, OpticalSystem, SquarePhotosite
from camsim.rendering import Grid, Rendering, render_channels
from camsim.rendering.cube import SpectralCube, radiance_cube
from camsim.reporting import Clock, acting, notes, sentence, signal, wavelengths
from camsim.scene import Scene
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa
from camsim.sensor.chain import STAGES, mixed, record
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.colour_response import colour_response
from camsim.sensor.conversion_gain import DualGain
from camsim.sensor.exposure import Exposure, auto_time_s, electrons_per_reflectance
from camsim.sensor.falloff import Falloff, falloff_at, working_f_number
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


@dataclass(frozen=True, slots=True)
class Region:
    """A window of the frame; ``origin`` (row, col), None for the middle, rounded down to the CFA's period."""

    rows: int
    cols: int
    origin: tuple[int, int] | None = None


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
    lens: Airy
    olpf: FourSpotOlpf | None = None
    photosite: SquarePhotosite
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
    def from_yaml(cls, sensor: str | os.PathLike[str], *, lens: Airy) -> Camera:
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

    def electrons_per_reflectance(self, samples: LightSamples, time_s: float) -> F64:
        """Return (channels, n) mean electrons of a perfect diffuser at every wavelength, on the optical axis."""
        return electrons_per_reflectance(
            samples,
            f_number=self.working_f_number,
            transmission=self.lens.transmission,
            filters=self.filters,
            quantum_efficiency=self.quantum_efficiency.select(self.cfa.channels),
            photosite_area_um2=self.photosite.area_um2,
            time_s=time_s,
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
        per_second = self.electrons_per_reflectance(light.samples(), 1.0).sum(axis=1)
        return auto_time_s(
            per_second, saturation_e=self.adc.saturation_e(exposure.iso, self.well_as_read_e(exposure.iso))
        )

    def expose(self, scene: Scene, *, frame_number: int = 0, **how: Any) -> Frame:
        """Take a picture; ``how`` and what it means: ``expose_frames``.

        frame_number : another number is another exposure of the same scene with the same sensor: the same fixed
                       patterns, fresh temporal noise
        """
        return next(self.expose_frames(scene, frame_numbers=(frame_number,), **how))

    def expose_frames(
        self,
        scene: Scene,
        *,
        frame_numbers: Iterable[int],
        light: Light,
        exposure: Exposure,
        seed: int = 0,
        region: Region | None = None,
        products: Collection[str] = ("mosaic",),
        tolerance: float = 1e-6,
        noise: bool = True,
        colour_matrix: MatrixOf = "standard",
        spectral_nm: Sequence[float] | None = None,
        scene_name: str = "scene",
        progress: Callable[[str, float], None] | None = None,
    ) -> Iterator[Frame]:
        """Take pictures of one scene, rendered once.

        seed      : of the temporal noise; the same seed and frame number give the same frame, bit for bit
        region    : a window of the frame; None takes all of it
        products  : "truth" fills ``Frame.truth``, "spectral" ``Frame.spectral``; everything else is there anyway
        tolerance : of the optics, relative to a perfect diffuser (or the brightest surface, if that is more)
        noise     : False leaves out every noise and the dark current
        colour_matrix : which matrices files carry: "standard" (illuminants A and D65) or "scene" (this light)
        spectral_nm   : wavelengths of "spectral"; None: 400 to 700 nm every 10, or the light's one line
        """
        check_products(products)
        clock = Clock()
        grid, samples = self._grid(region), light.samples()
        time_s = self.exposure_time_s(light, exposure)
        response = self.electrons_per_reflectance(samples, time_s)
        cube = (
            radiance_cube(scene, self.optics, grid, samples=samples, wavelength_nm=spectral_nm, tolerance=tolerance)
            if "spectral" in products
            else None
        )
        clock.lap("light")
        # Crosstalk brings in what the window's neighbours see.
        wide = grid if self.crosstalk is None else _widened(grid)
        rendering = render_channels(
            scene,
            self.optics,
            wide,
            response=response,
            wavelength_nm=samples.wavelength_nm,
            channel=self.cfa.channel_index(wide.rows, wide.cols, wide.origin),
            tolerance=tolerance,
            every_channel="truth" in products,
            progress=progress,
        )
        mean, truth = self._with_falloff(rendering, wide)
        clock.lap("render")
        for frame_number in frame_numbers:
            recorded = self._record(mean, grid, exposure, time_s, seed, frame_number, noise)
            clock.lap("noise")
            mosaic = self.adc.quantise(recorded, iso=exposure.iso, origin=grid.origin)
            clock.lap("adc")
            yield self._frame(
                mosaic=mosaic,
                electrons=recorded,
                mean=mean if self.crosstalk is None else mixed(mean, self.crosstalk),
                truth=truth if truth is None or wide is grid else truth[1:-1, 1:-1],
                spectral=cube,
                grid=grid,
                rendering=rendering,
                samples=samples,
                time_s=time_s,
                seconds=clock.seconds,
                scene_name=scene_name,
                asked={
                    "camera": self,
                    "scene": scene,
                    "light": light,
                    "exposure": exposure,
                    "region": region,
                    "seed": seed,
                    "frame_number": frame_number,
                    "tolerance": tolerance,
                    "noise": noise,
                    "colour_matrix": colour_matrix,
                    "spectral_nm": spectral_nm,
                },
            )

    def _with_falloff(self, rendering: Rendering, grid: Grid) -> tuple[F64, F32 | None]:
        """Return the mean electrons and the truth, dimmed towards the corners."""
        # An error of the tolerance may lie below black. In place: a large frame needs no second copy.
        mean = np.maximum(rendering.image, 0.0, out=rendering.image)
        truth = _truth(rendering)
        if self.falloff is None:
            return mean, truth
        dimmed = falloff_at(self.falloff, shape=mean.shape, first_centre=grid.first_centre, pitch_um=self.pitch_um)
        return mean * dimmed, None if truth is None else (truth * dimmed[..., None]).astype(np.float32)

    def electronics(self, iso: float) -> Mapping[str, Any]:
        """Return the electronic stages at an ISO setting by the names and in the order of ``sensor.chain.record``."""
        stages = {name: getattr(self, name) for name in STAGES}
        return stages | {"full_well": self.full_well_at(iso), "read_noise": self.read_noise_at(iso)}

    def _record(
        self, mean: F64, grid: Grid, exposure: Exposure, time_s: float, seed: int, frame_number: int, noise: bool
    ) -> F64:
        """Return the electrons that are read, every electronic stage applied."""
        return record(
            mean,
            **self.electronics(exposure.iso),
            time_s=time_s,
            temperature_c=exposure.temperature_c,
            electrons_per_dn=self.adc.electrons_per_dn_at(exposure.iso),
            seed=seed,
            serial=self.serial,
            origin=grid.origin,
            frame_cols=self.cols,
            frame_number=frame_number,
            noise=noise,
        )

    def _frame(
        self,
        *,
        mosaic: U16,
        electrons: F64,
        mean: F64,
        truth: F32 | None,
        spectral: SpectralCube | None,
        grid: Grid,
        rendering: Rendering,
        samples: LightSamples,
        time_s: float,
        seconds: Mapping[str, float],
        scene_name: str,
        asked: Mapping[str, Any],
    ) -> Frame:
        exposure: Exposure = asked["exposure"]
        channel = self.cfa.channel_index(grid.rows, grid.cols, grid.origin)
        white = self.adc.white_level_dn(exposure.iso, self.well_as_read_e(exposure.iso))
        return Frame(
            mosaic=mosaic,
            mean_electrons=mean,
            electrons=electrons,
            truth=truth,
            spectral=spectral,
            channel_index=channel,
            channels=self.cfa.channels,
            cfa_pattern=self.cfa.window_pattern(grid.origin),
            pitch_um=self.pitch_um,
            bit_depth=self.adc.bit_depth,
            black_level_dn=self.adc.black_level_dn,
            black_offsets_dn=self.adc.window_black_offsets_dn(grid.origin),
            white_level_dn=white,
            electrons_per_dn=self.adc.electrons_per_dn_at(exposure.iso),
            read_noise_e=self.dark_noise_e(exposure.iso) if asked["noise"] else 0.0,
            camera_name=self.name,
            serial=self.serial,
            f_number=self.lens.f_number,
            time_s=time_s,
            iso=exposure.iso,
            datetime=exposure.datetime,
            seed=asked["seed"],
            frame_number=asked["frame_number"],
            colour=colour_response(
                self.quantum_efficiency.select(self.cfa.channels),
                samples,
                passes=self.filters if samples.on_sensor else (self.lens.transmission, *self.filters),
                matrix=asked["colour_matrix"],
            ),
            description=describe(asked),
            report=Report(
                scene=scene_name,
                optics=tuple(sentence(stage) for stage in self.optics.stages),
                electronics=acting(self.electronics(exposure.iso), noise=asked["noise"]),
                wavelengths=wavelengths(samples, rendering.wavelengths),
                method=rendering.method,
                tolerance=rendering.tolerance,
                error_estimate=rendering.error_estimate,
                truth_error_estimate=rendering.planes_error,
                checked_photosites=rendering.checked_photosites,
                seconds=dict(seconds),
                signal=signal(self.cfa.channels, channel, mean, mosaic, white),
                notes=notes(self.adc, self.well_as_read_e(exposure.iso), exposure.iso),
            ),
        )

    def _grid(self, region: Region | None) -> Grid:
        if region is None:
            return Grid(rows=self.rows, cols=self.cols, pitch_um=self.pitch_um)
        frame, size, period = (self.rows, self.cols), (region.rows, region.cols), self.cfa.period
        row, col = region.origin or ((f - s) // 2 // p * p for f, s, p in zip(frame, size, period, strict=True))
        for name, first, count, most in (
            ("rows", row, region.rows, self.rows),
            ("cols", col, region.cols, self.cols),
        ):
            if count < 1 or first < 0 or first + count > most:
                raise InvalidValueError(
                    f"region: {name} {first}..{first + count} lie outside the frame's 0..{most}; "
                    "make it smaller or move its origin"
                )
        return Grid(rows=region.rows, cols=region.cols, pitch_um=self.pitch_um, origin=(row, col), frame=frame)


def _widened(grid: Grid) -> Grid:
    """Return a grid with one photosite more on every side; beyond the frame's edge the scene goes on."""
    (row, col), frame = grid.origin, grid.frame or (grid.rows, grid.cols)
    return dataclasses.replace(grid, rows=grid.rows + 2, cols=grid.cols + 2, origin=(row - 1, col - 1), frame=frame)


def _truth(rendering: Rendering) -> Any:
    if rendering.planes is None:
        return None
    return np.ascontiguousarray(np.moveaxis(np.maximum(rendering.planes, 0.0), 0, 2), dtype=np.float32)
