"""Rows of a window as they are lit: the rendered image before any electron is counted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.camera.body import Body
from camsim.camera.window import rows_of, widened
from camsim.core.arrays import F32, F64, U8
from camsim.core.tiled import Tiled
from camsim.optics.protocols import Illuminates
from camsim.rendering import Grid
from camsim.sensor.chain import mixed
from camsim.sensor.falloff import falloff_at


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExposedRows:
    """Rows of the window.

    rows_before : of the window
    mean_e      : of light alone; with crosstalk one photosite more on every side
    shown_e     : after crosstalk: what mean and truth are
    channel     : of each photosite
    """

    rows_before: int
    mean_e: F64
    displayed_e: F64
    channel: U8


@dataclass(frozen=True, kw_only=True)
class Window:
    """A camera's photosites that take part: ``grid`` those of the picture, ``wide`` those that are rendered.

    on_sensor : the light is given as it falls on the sensor, where no lens dims it
    """

    camera: Body
    grid: Grid
    on_sensor: bool = False

    @property
    def wide(self) -> Grid:
        """What is rendered: crosstalk brings in what the window's neighbours see."""
        return self.grid if self.camera.crosstalk is None else widened(self.grid)

    def channel(self, grid: Grid) -> U8:
        """Return each photosite's channel."""
        return self.camera.cfa.channel_index(grid.rows, grid.cols, grid.origin)

    def channels_of_all(self) -> Tiled:
        """Return the channel of each photosite that is rendered; no array of a large frame is made."""
        grid = self.wide
        return self.camera.cfa.tiled_index(grid.rows, grid.cols, grid.origin)

    def exposed(self, image: F64, veil_e: F64, rows_before: int) -> ExposedRows:
        """Return rows as they are lit: of the rendered image and each channel's veil, from a row of the window on."""
        grid = rows_of(self.wide, rows_before, len(image))
        # An error of the tolerance may lie below black. In place: a large frame needs no second copy.
        mean_e = np.maximum(image, 0.0, out=image)
        if veil_e.any():
            mean_e += veil_e[self.channel(grid)]
        if self.falls_off:
            mean_e = mean_e * self.falloff(grid)
        displayed_e = mean_e if self.camera.crosstalk is None else mixed(mean_e, self.camera.crosstalk)
        channel = self.channel(rows_of(self.grid, rows_before, len(displayed_e)))
        return ExposedRows(rows_before=rows_before, mean_e=mean_e, displayed_e=displayed_e, channel=channel)

    def truth(self, planes: F64 | None, veil_e: F64, mean_electrons: F64) -> F32 | None:
        """Return (rows, cols, channels) of every channel's rendered plane; its own is a photosite's mean electrons."""
        if planes is None:
            return None
        planes = np.maximum(planes, 0.0, out=planes)
        planes += veil_e[:, None, None]
        if self.falls_off:
            planes *= self.falloff(self.wide)
        truth = np.empty((self.grid.rows, self.grid.cols, len(planes)), np.float32)
        one, crosstalk = self.channel(self.grid), self.camera.crosstalk
        for k in range(len(planes)):
            plane = planes[k] if crosstalk is None else crosstalk.seen_by(k, planes, self.camera.cfa)
            truth[..., k] = np.where(one == k, mean_electrons, plane)
        return truth

    @property
    def falls_off(self) -> bool:
        """Whether photosites get less light than the axis."""
        dims = self.camera.falloff is not None or isinstance(self.camera.lens, Illuminates)
        return dims and not self.on_sensor

    def falloff(self, grid: Grid) -> F64:
        """Return the light that falls on photosites, relative to the axis: the lens's own, and what stands on it."""
        (x0, y0), pitch_um = grid.first_centre, self.camera.pitch_um
        relative: F64 = np.ones((grid.rows, grid.cols))
        if isinstance(lens := self.camera.lens, Illuminates):
            # The axis is often in the middle, and what is left of it as bright as what is right: asked for once.
            x, cols = np.unique(np.abs(x0 + np.arange(grid.cols)), return_inverse=True)
            y, rows = np.unique(np.abs(y0 + np.arange(grid.rows)), return_inverse=True)
            relative = lens.illumination(pitch_um * np.hypot(x, y[:, None]))[rows[:, None], cols]
        if self.camera.falloff is not None:
            shape = grid.rows, grid.cols
            relative = relative * falloff_at(self.camera.falloff, shape=shape, first_centre=(x0, y0), pitch_um=pitch_um)
        return relative
