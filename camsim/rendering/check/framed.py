"""Photosites that are transformed: in small windows one by one, or in one that holds all."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.rendering.check.beside import Beside
from camsim.rendering.check.fitting import Windows
from camsim.rendering.check.frame import Frame
from camsim.rendering.engine import CHECK, MEMORY_LIMIT_BYTES, OF_LIMIT, Cost, too_much
from camsim.rendering.grid import Grid

OF_OTHERS = 0.5  # of a window's time that others of its size take, measured


@dataclass(frozen=True, kw_only=True, eq=False)
class Framed:
    """Photosites of a grid.

    windows  : what transforms
    together : photosites that come one after the other and lie in one window
    beside   : what tells without a transform what some of them see
    """

    grid: Grid
    windows: Windows
    together: int
    beside: Beside | None = None

    def seconds(self, rows: I64, cols: I64) -> float:
        """Return what photosites are expected to take; the transfers serve lines and windows."""
        made = 0.0 if self.beside is None else self.beside.seconds
        return made + self._in_turn([self._expected(frame).seconds for frame, _ in self._frames(rows, cols)])

    def refuse_much(self, rows: I64, cols: I64) -> None:
        """Refuse photosites whose windows would be refused once the image is there."""
        most = max((self._expected(frame).memory_bytes for frame, _ in self._frames(rows, cols)), default=0.0)
        if most > OF_LIMIT * MEMORY_LIMIT_BYTES:
            raise too_much(CHECK, most, OF_LIMIT * MEMORY_LIMIT_BYTES)

    def taken(self, rows: I64, cols: I64) -> float:
        """Return what the window about photosites is expected to take; inf: more memory than there is."""
        return self._taken(Frame.about(rows, cols))

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Return what photosites see, each in its channel of ``sets`` (..., photosites)."""
        values = np.zeros(sets.shape)
        for part in self._parts(rows):
            if self.beside is not None and self._alone(rows[part], cols[part]):
                values[..., part] = self.beside.values(self._points(rows[part], cols[part]), sets[..., part])
        for frame, which in self._frames(rows, cols):
            places = (..., rows[which] - frame.row, cols[which] - frame.col)
            channel = np.empty((*sets.shape[:-1], *frame.shape), sets.dtype)
            channel[...] = sets[..., which][..., :1, None]
            channel[places] = sets[..., which]
            values[..., which] = self.windows.rendered(self._origin(frame), channel)[places]
        return values

    def _parts(self, rows: I64) -> list[I64]:
        return np.split(np.arange(rows.size), range(self.together, rows.size, self.together))

    def _points(self, rows: I64, cols: I64) -> F64:
        x0, y0 = self.grid.first_centre
        return np.stack([x0 + cols, y0 + rows], axis=1)

    def _alone(self, rows: I64, cols: I64) -> bool:
        return self.beside is not None and self.beside.alone(self._points(rows, cols))

    def _frames(self, rows: I64, cols: I64) -> list[tuple[Frame, I64]]:
        """Return windows that photosites lie in, one after the other, or what holds all if that takes less."""
        parts = [part for part in self._parts(rows) if not self._alone(rows[part], cols[part])]
        each = [(Frame.about(rows[part], cols[part]), part) for part in parts]
        if len(each) < 2:
            return each
        every = np.concatenate(parts)
        whole = [(Frame.about(rows[every], cols[every]), every)]
        return whole if self._seconds(whole) < self._seconds(each) else each

    def _origin(self, frame: Frame) -> tuple[float, float]:
        x0, y0 = self.grid.first_centre
        return x0 + frame.col, y0 + frame.row

    def _seconds(self, frames: list[tuple[Frame, I64]]) -> float:
        """Return what windows take one after the other; inf: more memory than there is."""
        return self._in_turn([self._taken(frame) for frame, _ in frames])

    def _in_turn(self, seconds: list[float]) -> float:
        """Add up: what is made of the lens for the first serves the others."""
        return sum(seconds[:1]) + OF_OTHERS * sum(seconds[1:])

    def _taken(self, frame: Frame) -> float:
        cost = self._expected(frame)
        return cost.seconds if cost.memory_bytes <= MEMORY_LIMIT_BYTES else math.inf

    def _expected(self, frame: Frame) -> Cost:
        return self.windows.expected(self._origin(frame), frame.shape)[0]
