"""Position of a picture in its camera's frame, and frequencies in common units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from camsim.camera.window import Region, grid_of
from camsim.core.typed import known_name
from camsim.errors import CamsimError

Unit: TypeAlias = Literal["cycles/px", "lp/mm", "lw/ph"]

UNITS: Mapping[Unit, str] = {
    "cycles/px": "cycles per pixel (of the sensor's pitch)",
    "lp/mm": "line pairs per mm on the sensor",
    "lw/ph": "line widths per picture height",
}
"""Units of frequencies."""

NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class FullFrame:
    """The camera's whole frame, seen from a picture that may be a window of it.

    rows, cols                 : size of the full frame
    axis_x_pixel, axis_y_pixel : middle of the full frame, the optical axis, in pixels of the picture
    pitch_um                   : None if unknown
    """

    rows: int
    cols: int
    axis_x_pixel: float
    axis_y_pixel: float
    pitch_um: float | None = None

    @classmethod
    def of(cls, description: Mapping[str, Any] | None, shape: tuple[int, int]) -> FullFrame:
        """Return the full frame from a file's description; without one, the picture is taken as the full frame."""
        here = cls(rows=shape[0], cols=shape[1], axis_x_pixel=0.5 * shape[1], axis_y_pixel=0.5 * shape[0])
        if description is None:
            return here
        try:
            camera, window = description["camera"], description.get("region")
            frame, pattern = (camera["rows"], camera["cols"]), camera["cfa"]["pattern"]
            region = None if window is None else Region(window["rows"], window["cols"], window["origin"])
            period = len(pattern), len(pattern[0])
            grid = grid_of(region, frame=frame, period=period, pitch_um=camera["pitch_um"])
        except (CamsimError, KeyError, TypeError, ValueError, IndexError, ZeroDivisionError, AttributeError):
            return here  # foreign or damaged metadata
        if (grid.rows, grid.cols) != tuple(shape):
            return here
        left, top = grid.first_centre
        return cls(
            rows=frame[0],
            cols=frame[1],
            axis_x_pixel=0.5 - left,
            axis_y_pixel=0.5 - top,
            pitch_um=grid.pitch_um,
        )

    def per_unit(self, unit: Unit) -> float:
        """Return what one cycle per pixel is in a unit; NaN if that needs the pitch and it is unknown.

        >>> frame = FullFrame(rows=2000, cols=3000, axis_x_pixel=1500.0, axis_y_pixel=1000.0, pitch_um=5.0)
        >>> [0.25 * frame.per_unit(unit) for unit in UNITS]
        [0.25, 50.0, 1000.0]
        """
        known_name("unit", unit, UNITS)
        if unit == "lp/mm":
            return math.nan if self.pitch_um is None else 1e3 / self.pitch_um
        return 2.0 * self.rows if unit == "lw/ph" else 1.0

    def in_units(self, cycles_per_pixel: float) -> dict[str, float]:
        """Return a frequency in all units, by their names.

        >>> frame = FullFrame(rows=2000, cols=3000, axis_x_pixel=1500.0, axis_y_pixel=1000.0, pitch_um=5.0)
        >>> frame.in_units(0.25)
        {'cycles_per_pixel': 0.25, 'lp_per_mm': 50.0, 'lw_per_ph': 1000.0}
        """
        names = ("cycles_per_pixel", "lp_per_mm", "lw_per_ph")
        return {name: cycles_per_pixel * self.per_unit(unit) for name, unit in zip(names, UNITS, strict=True)}
