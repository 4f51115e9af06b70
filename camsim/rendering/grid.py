"""Where the photosites are."""

from __future__ import annotations

import math
from dataclasses import dataclass

from camsim.errors import InvalidValueError


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """A window of a frame that is centred on the optical axis.

    rows, cols : of the window
    pitch_um   : distance between neighbouring photosites, µm
    origin     : (row, col) of the window's first photosite in the frame
    frame      : (rows, cols) of the whole frame; None: the window is the frame

    >>> Grid(rows=446, cols=446, pitch_um=4.88).first_centre
    (-222.5, -222.5)
    """

    rows: int
    cols: int
    pitch_um: float
    origin: tuple[int, int] = (0, 0)
    frame: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name, count in (("rows", self.rows), ("cols", self.cols)):
            if count < 1:
                raise InvalidValueError(f"{count!r} photosites make no grid; give 1 or more", key=name)
        if not (math.isfinite(self.pitch_um) and self.pitch_um > 0):
            raise InvalidValueError(f"{self.pitch_um!r} is not a pitch; give µm above 0", key="pitch_um")

    @property
    def first_centre(self) -> tuple[float, float]:
        """Return x, y of photosite (0, 0) of the window, in pitches from the optical axis."""
        rows, cols = self.frame or (self.rows, self.cols)
        return self.origin[1] + 0.5 - 0.5 * cols, self.origin[0] + 0.5 - 0.5 * rows
