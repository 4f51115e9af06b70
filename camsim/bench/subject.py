"""The subject of a bench: a scene as rendered by a capture, in a window of its frame."""

from __future__ import annotations

import contextlib
import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from camsim.bench.settings import Setting
from camsim.camera.window import Region
from camsim.core.arrays import F64, U8
from camsim.errors import CamsimError
from camsim.optics import OpticalSystem
from camsim.rendering import Grid, Rendering, render_channels
from camsim.rendering.auto import Choice
from camsim.rendering.render import plan_render
from camsim.scene import Scene
from camsim.spectra.curve import spectrum_at

if TYPE_CHECKING:
    from camsim.camera.capture import Capture


ROUGH = 1e-2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Subject:
    """Scene, optics and light of a capture, and the window that is rendered: every photosite in its own channel.

    response : (channels, n) electrons of a perfect diffuser;  wavelength_nm: (n,)
    channel  : (rows, cols) channel index of each photosite
    scale    : (rows, cols) full scale of each photosite: the larger of a perfect diffuser and the brightest surface
    """

    scene: Scene
    system: OpticalSystem
    grid: Grid
    response: F64
    wavelength_nm: F64
    channel: U8
    scale: F64

    @classmethod
    def of(cls, capture: Capture, region: Region | None) -> Subject:
        """Return the subject of a capture; ``region``: a window of the sensor's frame, None for the capture's own."""
        camera, samples = capture.camera, capture.samples
        grid = capture.grid if region is None else camera.grid(region)
        response = camera.electrons_per_reflectance(samples, capture.time_s)
        surfaces = capture.scene.spectra
        seen = [(response * spectrum_at(surface, samples.wavelength_nm)).sum(axis=1) for surface in set(surfaces)]
        scale = np.maximum(response.sum(axis=1), np.max(seen, axis=0))
        channel = camera.cfa.channel_index(grid.rows, grid.cols, grid.origin)
        return cls(
            scene=capture.exposed_scene,
            system=camera.optics,
            grid=grid,
            response=response,
            wavelength_nm=samples.wavelength_nm,
            channel=channel,
            scale=np.where(scale > 0.0, scale, 1.0)[channel],
        )

    def render(self, setting: Setting) -> Rendering:
        """Render the window, in electrons."""
        return render_channels(
            self.scene,
            self.system,
            self.grid,
            response=self.response,
            wavelength_nm=self.wavelength_nm,
            channel=self.channel,
            tolerance=setting.asked,
            method=setting.method,
            samples=setting.samples,
        )

    def warm(self, method: str) -> None:
        """Render a few photosites coarsely, so that a method's kernels are compiled before timing."""
        grid = self.grid
        few = min(2, grid.rows), min(2, grid.cols)
        tiny = dataclasses.replace(
            self,
            grid=dataclasses.replace(grid, rows=few[0], cols=few[1], frame=grid.frame or (grid.rows, grid.cols)),
            channel=self.channel[: few[0], : few[1]],
        )
        # Refusals are repeated by the actual rendering.
        with contextlib.suppress(CamsimError):
            tiny.render(Setting(method=method, tolerance=ROUGH, samples=1 if method == "importance" else None))

    def relative(self, image: F64) -> F64:
        """Return an image relative to each photosite's full scale."""
        relative: F64 = image / self.scale
        return relative

    def plan(self, setting: Setting) -> Choice:
        """Choose the rendering method without rendering; raises CamsimError if refused."""
        return plan_render(
            self.scene,
            self.system,
            self.grid,
            response=self.response,
            wavelength_nm=self.wavelength_nm,
            tolerance=setting.asked,
            method=setting.method,
            samples=setting.samples,
        )
