"""Regions of an image, and coordinates across and along an edge.

Positions are in pixels of the image: x to the right, y down, photosite (row, col) has its centre at
(col + ½, row + ½). A pixel is the sensor's pitch for every colour channel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import check, validate
from camsim.errors import InvalidValueError


@dataclass(frozen=True, slots=True)
class Roi:
    """A rectangle of photosites: first row and column, and numbers of rows and columns.

    >>> Roi.parse("10, 20, 64, 48")
    Roi(row=10, col=20, rows=64, cols=48)
    """

    row: int
    col: int
    rows: int
    cols: int

    @classmethod
    def parse(cls, text: str) -> Roi:
        """Read ``row,col,rows,cols``."""
        try:
            row, col, rows, cols = (int(part) for part in check(text, str, "roi").split(","))
        except ValueError:
            raise InvalidValueError(
                f"{text!r}; give row,col,rows,cols in whole pixels, such as 100,200,64,64", key="roi"
            ) from None
        return cls(row, col, rows, cols)

    def __post_init__(self) -> None:
        validate(self)

    def check_inside(self, shape: tuple[int, int]) -> None:
        """Raise for a region that exceeds an image of (rows, cols)."""
        rows, cols = shape
        if self.rows < 1 or self.cols < 1:
            raise InvalidValueError(
                f"{self}; {self.rows} × {self.cols} photosites are no region, give 64 or more each", key="roi"
            )
        if self.row < 0 or self.col < 0:
            raise InvalidValueError(f"{self} begins outside the image; rows and columns count from 0", key="roi")
        if self.row + self.rows > rows or self.col + self.cols > cols:
            raise InvalidValueError(
                f"{self} reaches beyond the image of {rows} rows and {cols} columns; "
                f"row + rows must be at most {rows} and col + cols at most {cols}",
                key="roi",
            )

    def __str__(self) -> str:
        return f"{self.row},{self.col},{self.rows},{self.cols}"


@dataclass(frozen=True, slots=True, kw_only=True)
class EdgeLine:
    """An edge that is straight, or an arc of a circle.

    x_pixel, y_pixel    : a point on it
    normal_rad          : direction from dark to bright, clockwise as displayed from the x axis
    curvature_per_pixel : 1/radius; positive if the edge bends towards the bright side
    """

    x_pixel: float
    y_pixel: float
    normal_rad: float
    curvature_per_pixel: float = 0.0

    @property
    def angle_deg(self) -> float:
        """Turn from the nearest pixel axis, −45..45°, clockwise as displayed: ``rotate_deg`` of a scene's rectangle.

        >>> round(EdgeLine(x_pixel=0.0, y_pixel=0.0, normal_rad=math.radians(184.0)).angle_deg, 9)
        4.0
        """
        return (math.degrees(self.normal_rad) + 45.0) % 90.0 - 45.0

    def across_and_along(self, x_pixel: F64, y_pixel: F64) -> tuple[F64, F64]:
        """Return the signed distance from the edge (positive on the bright side) and the position along it, pixels."""
        cos, sin = math.cos(self.normal_rad), math.sin(self.normal_rad)
        dx, dy = x_pixel - self.x_pixel, y_pixel - self.y_pixel
        along: F64 = cos * dy - sin * dx
        across: F64 = cos * dx + sin * dy
        bend = self.curvature_per_pixel
        if bend:
            # For a circle about (1/bend, 0), in a form without cancellation for nearly straight edges.
            twice = 2.0 * across - bend * (across**2 + along**2)
            across = twice / (1.0 + np.sqrt(np.maximum(1.0 - bend * twice, 0.0)))
        return across, along

    def moved(self, across: float, turn: float, bend: float) -> EdgeLine:
        """Return the edge whose distances are smaller by across + turn·along + bend·along² (small changes)."""
        cos, sin = math.cos(self.normal_rad), math.sin(self.normal_rad)
        return EdgeLine(
            x_pixel=self.x_pixel + across * cos,
            y_pixel=self.y_pixel + across * sin,
            normal_rad=self.normal_rad - math.atan(turn),
            curvature_per_pixel=self.curvature_per_pixel + 2.0 * bend,
        )

    def half_widths(self, roi: Roi) -> tuple[float, float]:
        """Return how far the region reaches from the edge's point along the normal, dark side and bright side."""
        cos, sin = math.cos(self.normal_rad), math.sin(self.normal_rad)
        reach = []
        for side in (-1.0, 1.0):
            limits = [math.inf]
            for start, size, at, step in (
                (roi.col, roi.cols, self.x_pixel, side * cos),
                (roi.row, roi.rows, self.y_pixel, side * sin),
            ):
                if abs(step) > 1e-9:
                    limits.append(((start + size if step > 0 else start) - at) / step)
            reach.append(min(limits))
        return reach[0], reach[1]


def longest_gap(across: F64, half_width: float) -> float:
    """Return the longest stretch across the edge without a photosite's centre, within ``half_width`` of the edge."""
    near = np.sort(across[np.abs(across) <= half_width])
    if near.size < 2:
        return 2.0 * half_width
    ends = max(near[0] + half_width, half_width - near[-1])
    return float(max(np.diff(near).max(), ends))
