"""Exposed rows of a window: mean electrons of the rendered image, before noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.camera.body import Body
from camsim.camera.window import rows_of, widened
from camsim.core.arrays import F32, F64, U8
from camsim.core.kernels import shared
from camsim.core.tiled import Tiled
from camsim.optics.protocols import Illuminates
from camsim.rendering import Grid
from camsim.sensor.chain import mixed
from camsim.sensor.falloff import falloff_at

_ROWS_AT_ONCE = 32


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExposedRows:
    """Mean electrons of consecutive rows of a window.

    rows_before : rows of the window above these
    mean_e      : (rows, cols) from light alone; with crosstalk padded by one photosite on every side
    displayed_e : (rows, cols) after crosstalk, as in ``Frame.mean_electrons`` and ``Frame.truth``
    channel     : (rows, cols) channel index of each photosite
    """

    rows_before: int
    mean_e: F64
    displayed_e: F64
    channel: U8


@dataclass(frozen=True, kw_only=True)
class Window:
    """The photosites of a window: those of the picture (``grid``), and those that are rendered (``wide``).

    on_sensor : whether the light is given on the sensor, so that no lens attenuates it
    """

    camera: Body
    grid: Grid
    on_sensor: bool = False

    @property
    def wide(self) -> Grid:
        """The rendered photosites: with crosstalk the window padded by one on every side."""
        return self.grid if self.camera.crosstalk is None else widened(self.grid)

    def channel(self, grid: Grid) -> U8:
        """Return the channel index of each photosite."""
        return self.camera.cfa.channel_index(grid.rows, grid.cols, grid.origin)

    def channels_of_all(self) -> Tiled:
        """Return the channel index of each rendered photosite as a tiled array, which needs little memory."""
        grid = self.wide
        return self.camera.cfa.tiled_index(grid.rows, grid.cols, grid.origin)

    def exposed(self, image: F64, veil_e: F64, rows_before: int) -> ExposedRows:
        """Return exposed rows: rendered image plus each channel's veiling glare; ``rows_before``: rows above them."""
        grid = rows_of(self.wide, rows_before, len(image))
        # Errors within the tolerance may be negative. In place: saves a copy of a large frame.
        mean_e = np.maximum(image, 0.0, out=image)
        if veil_e.any():
            mean_e += veil_e[self.channel(grid)]
        if self.falls_off:
            mean_e = mean_e * self.falloff(grid)
        displayed_e = mean_e if self.camera.crosstalk is None else mixed(mean_e, self.camera.crosstalk)
        channel = self.channel(rows_of(self.grid, rows_before, len(displayed_e)))
        return ExposedRows(rows_before=rows_before, mean_e=mean_e, displayed_e=displayed_e, channel=channel)

    def truth(self, planes: F64 | F32 | None, veil_e: F64, mean_electrons: F64) -> F32 | None:
        """Return (rows, cols, channels) mean electrons: planes, with ``mean_electrons`` in each photosite's channel."""
        if planes is None:
            return None
        planes = np.maximum(planes, 0.0, out=planes)
        if veil_e.any():
            planes += veil_e[:, None, None]
        if self.falls_off:
            planes *= self.falloff(self.wide)
        truth = np.empty((self.grid.rows, self.grid.cols, len(planes)), np.float32)
        one, crosstalk = self.channel(self.grid), self.camera.crosstalk
        for k in range(len(planes)):
            plane = planes[k] if crosstalk is None else crosstalk.seen_by(k, planes, self.camera.cfa)

            def work(begin: int, end: int, k: int = k, plane: F64 | F32 = plane) -> None:
                rows = slice(begin, end)
                truth[rows, :, k] = np.where(one[rows] == k, mean_electrons[rows], plane[rows])

            shared(len(truth), work, least=_ROWS_AT_ONCE)
        return truth

    @property
    def falls_off(self) -> bool:
        """Whether illumination varies over the frame."""
        dims = self.camera.falloff is not None or isinstance(self.camera.lens, Illuminates)
        return dims and not self.on_sensor

    def falloff(self, grid: Grid) -> F64:
        """Return the relative illumination of photosites, 1 on the axis: that of the lens times ``Body.falloff``."""
        (x0, y0), pitch_um = grid.first_centre, self.camera.pitch_um
        relative: F64 = np.ones((grid.rows, grid.cols))
        if isinstance(lens := self.camera.lens, Illuminates):
            # Illumination is symmetric about the axis, so each distinct |x|, |y| is evaluated once.
            x, cols = np.unique(np.abs(x0 + np.arange(grid.cols)), return_inverse=True)
            y, rows = np.unique(np.abs(y0 + np.arange(grid.rows)), return_inverse=True)
            relative = lens.illumination(pitch_um * np.hypot(x, y[:, None]))[rows[:, None], cols]
        if self.camera.falloff is not None:
            shape = grid.rows, grid.cols
            relative = relative * falloff_at(self.camera.falloff, shape=shape, first_centre=(x0, y0), pitch_um=pitch_um)
        return relative
