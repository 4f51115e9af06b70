"""Recording of exposed photosites: noise, codes, and the metadata of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from camsim.camera.body import Body
from camsim.camera.description import CUSTOM_STAGES, describe
from camsim.camera.exposed_rows import ExposedRows, Window
from camsim.camera.frame import Frame
from camsim.camera.reporting import Clock, Signals
from camsim.camera.window import Region
from camsim.core.arrays import F64, U16
from camsim.core.cached import Caching, cached_property
from camsim.core.custom import custom_stages
from camsim.optics.no_lens import NoLens
from camsim.rendering import Grid
from camsim.sensor.chain import random_numbers, record
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.conversion_gain import merged_e
from camsim.sensor.exposure import Exposure
from camsim.sensor.stage import Context, ElectronicStage
from camsim.spectra.light import Light


class Recording(Caching):
    """A camera's electronics at one exposure; subclasses supply the light and these fields.

    made_of : names of the fields that a description holds
    """

    made_of: ClassVar[tuple[str, ...]]

    camera: Body
    light: Light
    exposure: Exposure
    seed: int
    region: Region | None
    noise: bool
    colour_matrix: MatrixOf

    @cached_property
    def grid(self) -> Grid:
        """The photosite grid of the window."""
        return self.camera.grid(self.region)

    @cached_property
    def window(self) -> Window:
        """The photosites involved: the window's, and with crosstalk their neighbours."""
        return Window(camera=self.camera, grid=self.grid, on_sensor=self.light.at == "sensor")

    @cached_property
    def time_s(self) -> float:
        """The exposure time, resolved if "auto"."""
        return self.camera.exposure_time_s(self.light, self.exposure)

    @property
    def dark_e(self) -> float:
        """The mean dark charge of all photosites, electrons; 0 without noise."""
        return self.camera.dark_e(self.time_s, self.exposure.temperature_c) if self.noise else 0.0

    @cached_property
    def white_level_dn(self) -> int:
        """The code at which the signal clips."""
        return self.camera.converter.white_level_dn(self.exposure.iso, self.camera.well_as_read_e(self.exposure.iso))

    @cached_property
    def random_numbers(self) -> int:
        """Number of random numbers drawn for one frame."""
        shape = self.grid.rows, self.grid.cols
        return sum(random_numbers(stages, shape, self._context(camera, 0, 0)) for camera, stages in self._read_outs)

    @cached_property
    def _read_outs(self) -> tuple[tuple[Body, tuple[ElectronicStage, ...]], ...]:
        """The read-outs of an exposure, each with its active electronic stages."""
        iso = self.exposure.iso
        return tuple((camera, camera.electronics(iso, noise=self.noise)) for camera in self.camera.read_outs)

    @cached_property
    def electronics(self) -> tuple[ElectronicStage, ...]:
        """The active electronic stages."""
        return self.camera.electronics(self.exposure.iso, noise=self.noise)

    def _recorded(self, exposed: ExposedRows, frame_number: int, clock: Clock, signals: Signals) -> tuple[F64, U16]:
        """Return electrons of rows after all electronic stages, and their codes."""
        row, col = self.grid.origin
        first, iso = (row + exposed.rows_before, col), self.exposure.iso
        read = [
            record(exposed.mean_e, stages, self._context(camera, frame_number, exposed.rows_before))
            for camera, stages in self._read_outs
        ]
        clock.lap("noise")
        electrons = read[0] if len(read) == 1 else self._merged(read, first)
        codes = self.camera.converter.quantise(electrons, iso=iso, origin=first)
        clock.lap("adc")
        signals.add(exposed, self.camera.converter.data_numbers(codes))
        return electrons, codes

    def _merged(self, read: Sequence[F64], first: tuple[int, int]) -> F64:
        """Return electrons merged from the two read-outs of an exposure, each through its converter."""
        iso, cameras = self.exposure.iso, [camera for camera, _ in self._read_outs]
        low_e, high_e = (
            camera.converter.electrons(
                camera.converter.quantise(electrons, iso=iso, origin=first), iso=iso, origin=first
            )
            for camera, electrons in zip(cameras, read, strict=True)
        )
        return merged_e(low_e, high_e, cameras[1].converter.saturation_e(iso, cameras[1].well_as_read_e(iso)))

    def _signals(self) -> Signals:
        full_e = self.camera.charge_at_e(1.0, self.exposure.iso) - self.dark_e
        return Signals(self.camera, self.grid.origin, self.white_level_dn, full_e=full_e)

    def _context(self, camera: Body, frame_number: int, rows_before: int) -> Context:
        """Return the context of electronic stages; ``rows_before``: rows of the window above."""
        return Context(
            time_s=self.time_s,
            iso=self.exposure.iso,
            temperature_c=self.exposure.temperature_c,
            electrons_per_dn=camera.converter.electrons_per_dn_at(self.exposure.iso),
            seed=self.seed,
            serial=camera.serial,
            read_out=camera.read_out_number,
            frame_number=frame_number,
            origin=self.grid.origin,
            frame_cols=camera.cols,
            rows_in_all=self.grid.rows,
            rows_before=rows_before,
        )

    @cached_property
    def _read_noise_e(self) -> float:
        """The standard deviation of the temporal noise of the read-out, electrons."""
        return self.camera.dark_noise_e(self.exposure.iso) if self.noise else 0.0

    def description(self, frame_number: int) -> dict[str, Any]:
        """Return the description of everything that determines a frame, as written to files."""
        return {**self._described, "frame_number": frame_number}

    @cached_property
    def _described(self) -> dict[str, Any]:
        one = custom_stages((*self.camera.optics.stages, *self.camera.stages))
        parts = {name: getattr(self, name) for name in self.made_of}
        described: dict[str, Any] = describe(parts | ({CUSTOM_STAGES: one} if one else {}))
        return described

    @cached_property
    def _steps_e(self) -> tuple[float, ...]:
        """Return ``Frame.steps_e``: empty, as given light is exact."""
        return ()

    def _frame(self, *, frame_number: int, **photosites: Any) -> Frame:
        """Return the frame: ``photosites`` with the metadata of files."""
        camera, exposure = self.camera, self.exposure
        return Frame(
            **photosites,
            channels=camera.cfa.channels,
            cfa_pattern=camera.cfa.window_pattern(self.grid.origin),
            pitch_um=camera.pitch_um,
            bit_depth=camera.converter.bit_depth,
            black_level_dn=camera.converter.black_level_dn,
            companding=tuple(camera.converter.companding),
            black_offsets_dn=camera.converter.window_black_offsets_dn(self.grid.origin),
            white_level_dn=self.white_level_dn,
            electrons_per_dn=camera.converter.electrons_per_dn_at(exposure.iso),
            white_e=camera.charge_at_e(1.0, exposure.iso) if camera.nonlinearity is not None else None,
            shot_e2_per_e=camera.shot_e2_per_e(exposure.iso) if self.noise else 0.0,
            read_noise_e=self._read_noise_e,
            camera_name=camera.name,
            serial=camera.serial,
            f_number=0.0 if isinstance(camera.lens, NoLens) else camera.lens.f_number,
            time_s=self.time_s,
            iso=exposure.iso,
            datetime=exposure.datetime,
            seed=self.seed,
            frame_number=frame_number,
            steps_e=self._steps_e,
            colour=camera.colour_response(self.light, self.colour_matrix),
            description=self.description(frame_number),
        )
