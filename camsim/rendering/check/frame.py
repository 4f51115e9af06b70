"""A small window of a frame, as the check has it rendered."""

from __future__ import annotations

from typing import NamedTuple

from camsim.arrays import I64

RIM = 2  # more on every side of a window: a grid that is one window has other numbers in its check all the same


class Frame(NamedTuple):
    """A window with its rim; row and column of its first photosite may lie outside the grid."""

    row: int
    col: int
    shape: tuple[int, int]

    @classmethod
    def about(cls, rows: I64, cols: I64) -> Frame:
        """Return the smallest that holds photosites."""
        row, col = int(rows.min()) - RIM, int(cols.min()) - RIM
        return cls(row, col, (int(rows.max()) - row + RIM + 1, int(cols.max()) - col + RIM + 1))
