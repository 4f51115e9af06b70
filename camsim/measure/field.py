"""Positions of edges relative to the optical axis, and whether they give the sagittal or the tangential MTF."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

from camsim.measure.full_frame import FullFrame

Direction: TypeAlias = Literal["sagittal", "tangential", "oblique"]

NEAR_DEG = 30.0
"""Largest angle between an edge and a direction to count for it: cos² = ¾."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldPlace:
    """The place of an edge in the frame.

    x_um, y_um  : distance from the optical axis, right and down; NaN if the pitch is not known
    x_pixel, y_pixel, radius_pixel : the same in pixels
    direction   : "sagittal" for an edge along the radius, which is blurred across it; "tangential" (meridional) for an
                  edge across the radius, which is blurred along it; "oblique" in between
    from_tangential_deg : between the edge's normal and the radius, 0 to 90°; 0 is tangential
    """

    x_um: float
    y_um: float
    x_pixel: float
    y_pixel: float
    radius_pixel: float
    direction: Direction
    from_tangential_deg: float


def field_place(x_pixel: float, y_pixel: float, normal_rad: float, frame: FullFrame) -> FieldPlace:
    """Return the field position of an edge, given by a point of it (in the picture) and by its normal.

    >>> frame = FullFrame(rows=100, cols=100, axis_x_pixel=50.0, axis_y_pixel=50.0)
    >>> [field_place(90.0, 50.0, turn, frame).direction for turn in (0.1, 0.8, 1.5)]
    ['tangential', 'oblique', 'sagittal']
    """
    x, y = x_pixel - frame.axis_x_pixel, y_pixel - frame.axis_y_pixel
    radius = math.hypot(x, y)
    # Between undirected lines: 0 to 90°.
    along = abs(x * math.cos(normal_rad) + y * math.sin(normal_rad))
    off = math.degrees(math.atan2(abs(y * math.cos(normal_rad) - x * math.sin(normal_rad)), along))
    direction: Direction = "tangential" if off < NEAR_DEG else "sagittal" if off > 90.0 - NEAR_DEG else "oblique"
    pitch_um = math.nan if frame.pitch_um is None else frame.pitch_um
    return FieldPlace(
        x_um=x * pitch_um,
        y_um=y * pitch_um,
        x_pixel=x,
        y_pixel=y,
        radius_pixel=radius,
        direction=direction,
        from_tangential_deg=off,
    )
