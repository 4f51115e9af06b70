"""The camera: its stages, in the order light meets them, and ``expose``, which is the pipeline."""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.arrays import F64, U8, U16
from camsim.description import describe
from camsim.errors import InvalidValueError
from camsim.frame import ChannelSignal, Frame, Report
from camsim.optics import Airy, FourSpotOlpf, OpticalSystem, SquarePhotosite
from camsim.rendering import Grid, Rendering, render_channels
from camsim.scene import Scene
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa
from camsim.sensor.chain import record
from camsim.sensor.colour_matrix import ColourResponse, MatrixOf
from camsim.sensor.exposure import Exposure, auto_time_s, electrons_per_reflectance
from camsim.sensor.noise import DarkCurrent, Dsnu, FullWell, Prnu, ReadNoise
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import spectrum_at
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
    prnu: Prnu | None = None
    dark_current: DarkCurrent | None = None
    full_well: FullWell | None = None
    read_noise: ReadNoise | None = None
    dsnu: Dsnu | None = None
    adc: Adc

    @classmethod
    def from_yaml(cls, sensor: str | os.PathLike[str], *, lens: Airy) -> Camera:
        """Return the camera of a sensor file (a path, or the name of a shipped one) behind ``lens``."""
        from camsim.capturing import load_camera  # the one door upward: the name users look for is here

        return load_camera(sensor, lens=lens)

    def replace(self, **changes: Any) -> Camera:
        """Return a camera with some stages exchanged, such as ``replace(olpf=None)``."""
        return dataclasses.replace(self, **changes)

    @property
    def optics(self) -> OpticalSystem:
        """Lens, OLPF and photosite as one."""
        return OpticalSystem(lens=self.lens, olpf=self.olpf, photosite=self.photosite)

    def electrons_per_reflectance(self, samples: LightSamples, time_s: float) -> F64:
        """Return (channels, n) mean electrons of a perfect diffuser at every wavelength of the light."""
        return electrons_per_reflectance(
            samples,
            f_number=self.lens.f_number,
            transmission=self.lens.transmission,
            quantum_efficiency=self.quantum_efficiency.select(self.cfa.channels),
            photosite_area_um2=self.photosite.area_um2,
            time_s=time_s,
        )

    def exposure_time_s(self, light: Light, exposure: Exposure) -> float:
        """Return the exposure time; "auto" puts the most responsive channel's white at 80 % of black..white."""
        if not isinstance(exposure.time_s, str):
            return exposure.time_s
        per_second = self.electrons_per_reflectance(light.samples(), 1.0).sum(axis=1)
        return auto_time_s(per_second, saturation_e=self.adc.saturation_e(exposure.iso, self._full_well_e))

    def expose(
        self,
        scene: Scene,
        *,
        light: Light,
        exposure: Exposure,
        seed: int = 0,
        region: Region | None = None,
        products: Collection[str] = ("mosaic",),
        tolerance: float = 1e-6,
        noise: bool = True,
        colour_matrix: MatrixOf = "standard",
        scene_name: str = "scene",
        progress: Callable[[str, float], None] | None = None,
    ) -> Frame:
        """Take a picture.

        seed      : of the temporal noise; the same seed gives the same frame, bit for bit
        region    : a window of the frame; None takes all of it
        products  : "truth" fills ``Frame.truth``; everything else is there anyway
        tolerance : of the optics, relative to a perfect diffuser (or the brightest surface, if that is more)
        noise     : False leaves out every noise and the dark current
        colour_matrix : of the DNG, "standard" (illuminants A and D65) or "scene" (fitted to this light)
        """
        clock = _Clock()
        grid = self._grid(region)
        samples = light.samples()
        time_s = self.exposure_time_s(light, exposure)
        channel = self.cfa.channel_index(grid.rows, grid.cols, grid.origin)
        response = self.electrons_per_reflectance(samples, time_s)
        clock.lap("light")
        rendering = render_channels(
            scene,
            self.optics,
            grid,
            response=response,
            wavelength_nm=samples.wavelength_nm,
            channel=channel,
            tolerance=tolerance,
            every_channel="truth" in products,
            progress=progress,
        )
        mean = np.maximum(rendering.image, 0.0)  # an error of the tolerance may lie below black
        clock.lap("render")
        electrons = record(
            mean,
            prnu=self.prnu,
            dark_current=self.dark_current,
            full_well=self.full_well,
            read_noise=self.read_noise,
            dsnu=self.dsnu,
            time_s=time_s,
            seed=seed,
            serial=self.serial,
            origin=grid.origin,
            frame_cols=self.cols,
            noise=noise,
        )
        clock.lap("noise")
        mosaic = self.adc.quantise(electrons, iso=exposure.iso)
        white = self.adc.white_level_dn(exposure.iso, self._full_well_e)
        clock.lap("adc")
        return Frame(
            mosaic=mosaic,
            mean_electrons=mean,
            electrons=electrons,
            truth=_truth(rendering),
            channel_index=channel,
            channels=self.cfa.channels,
            cfa_pattern=self.cfa.window_pattern(grid.origin),
            pitch_um=self.pitch_um,
            bit_depth=self.adc.bit_depth,
            black_level_dn=self.adc.black_level_dn,
            white_level_dn=white,
            electrons_per_dn=self.adc.electrons_per_dn_at(exposure.iso),
            read_noise_e=self.read_noise.sigma_e if noise and self.read_noise else 0.0,
            camera_name=self.name,
            serial=self.serial,
            f_number=self.lens.f_number,
            time_s=time_s,
            iso=exposure.iso,
            datetime=exposure.datetime,
            seed=seed,
            colour=self._colour(samples, colour_matrix),
            description=describe(
                {
                    "camera": self,
                    "scene": scene,
                    "light": light,
                    "exposure": exposure,
                    "region": region,
                    "seed": seed,
                    "tolerance": tolerance,
                    "noise": noise,
                    "colour_matrix": colour_matrix,
                }
            ),
            report=Report(
                scene=scene_name,
                optics=tuple(_sentence(stage) for stage in self.optics.stages),
                wavelengths=_wavelengths(samples, rendering),
                method=rendering.method,
                tolerance=tolerance,
                error_estimate=rendering.error_estimate,
                truth_error_estimate=rendering.planes_error,
                checked_photosites=rendering.checked_photosites,
                seconds=clock.seconds,
                signal=_signal(self.cfa.channels, channel, mean, mosaic, white),
            ),
        )

    @property
    def _full_well_e(self) -> float | None:
        return self.full_well.capacity_e if self.full_well else None

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

    def _colour(self, samples: LightSamples, matrix: MatrixOf) -> ColourResponse:
        """Return how the channels see light, for colour matrices; not per photon but per energy, hence × λ."""
        wavelength_nm = np.arange(360.0, 831.0)
        efficiency = self.quantum_efficiency.select(self.cfa.channels).at(wavelength_nm)
        if samples.wavelength_nm.size == 1:
            light = (np.abs(wavelength_nm - samples.wavelength_nm[0]) <= 0.5).astype(float)
        else:
            light = np.interp(wavelength_nm, samples.wavelength_nm, samples.irradiance_w_per_m2_nm, left=0.0, right=0.0)
        return ColourResponse(
            channels=self.cfa.channels,
            wavelength_nm=wavelength_nm,
            sensitivity=efficiency * wavelength_nm * spectrum_at(self.lens.transmission, wavelength_nm),
            light=light,
            matrix=matrix,
        )


class _Clock:
    """Seconds since the last lap, by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now


def _truth(rendering: Rendering) -> Any:
    if rendering.planes is None:
        return None
    return np.ascontiguousarray(np.moveaxis(np.maximum(rendering.planes, 0.0), 0, 2), dtype=np.float32)


def _signal(
    channels: tuple[str, ...], channel: U8, mean_electrons: F64, mosaic: U16, white_level_dn: int
) -> tuple[ChannelSignal, ...]:
    signals = []
    for k, name in enumerate(channels):
        here = channel == k
        electrons, codes = mean_electrons[here], mosaic[here]
        if electrons.size:
            signals.append(
                ChannelSignal(
                    name=name,
                    mean_e=float(electrons.mean()),
                    max_e=float(electrons.max()),
                    mean_dn=float(codes.mean()),
                    clipped_photosites=int(np.count_nonzero(codes >= white_level_dn)),
                    photosites=int(electrons.size),
                )
            )
    return tuple(signals)


def _sentence(stage: object) -> str:
    """Return a stage as people write it: ``Airy(f_number=8.0)``, defaults left out."""
    fields = dataclasses.fields(stage)  # type: ignore[arg-type]
    shown = [f"{f.name}={getattr(stage, f.name)!r}" for f in fields if getattr(stage, f.name) != f.default]
    return f"{type(stage).__name__}({', '.join(shown)})"


def _wavelengths(samples: LightSamples, rendering: Rendering) -> str:
    if samples.wavelength_nm.size == 1:
        return f"{samples.wavelength_nm[0]:g} nm, one line"
    low, high = samples.wavelength_nm[0], samples.wavelength_nm[-1]
    return f"{low:g}–{high:g} nm, {samples.wavelength_nm.size} samples on {rendering.wavelengths} nodes"
