"""A window of the frame, and the grid of its photosites."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camsim.core.typed import Count, Index, Whole, validate
from camsim.errors import InvalidValueError
from camsim.rendering import Grid


@dataclass(frozen=True, slots=True)
class Region:
    """A window of the frame; ``origin`` (row, col), None for the middle, rounded down to the CFA's period.

    >>> Region(rows=64, cols=96)
    Region(rows=64, cols=96, origin=None)
    >>> Region(rows=2, cols=2, origin=(100, 200)).origin
    (100, 200)
    """

    rows: Count
    cols: Count
    origin: tuple[Index, Index] | None = None

    if TYPE_CHECKING:

        def __init__(self, rows: Whole, cols: Whole, origin: tuple[Whole, Whole] | None = None) -> None: ...

    def __post_init__(self) -> None:
        validate(self)


def grid_of(region: Region | None, *, frame: tuple[int, int], period: tuple[int, int], pitch_um: float) -> Grid:
    """Return the photosite grid of a window, None: the full frame; raises InvalidValueError if it exceeds the frame.

    frame, period : (rows, cols) of the sensor and of its colour filter array
    """
    if region is None:
        return Grid(rows=frame[0], cols=frame[1], pitch_um=pitch_um)
    size = region.rows, region.cols
    row, col = region.origin or ((f - s) // 2 // p * p for f, s, p in zip(frame, size, period, strict=True))
    for name, first, count, most in (("rows", row, size[0], frame[0]), ("cols", col, size[1], frame[1])):
        if count > most:
            raise InvalidValueError(f"is {count}; the sensor has {most} {name}", key=name, stage="Region")
        if first + count > most:
            message = f"puts the last of the {name} at {first + count - 1}; the sensor's are 0 to {most - 1}"
            raise InvalidValueError(message, key="origin", stage="Region")
    return Grid(rows=size[0], cols=size[1], pitch_um=pitch_um, origin=(row, col), frame=frame)


def widened(grid: Grid) -> Grid:
    """Return a grid padded by one photosite on every side; the scene continues beyond the frame's edge."""
    (row, col), frame = grid.origin, grid.frame or (grid.rows, grid.cols)
    return dataclasses.replace(grid, rows=grid.rows + 2, cols=grid.cols + 2, origin=(row - 1, col - 1), frame=frame)


def rows_of(grid: Grid, first: int, count: int) -> Grid:
    """Return the grid of some of the rows."""
    frame = grid.frame or (grid.rows, grid.cols)
    return dataclasses.replace(grid, rows=count, origin=(grid.origin[0] + first, grid.origin[1]), frame=frame)
