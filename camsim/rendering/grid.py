"""The grid of photosites."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from camsim.core.typed import Count, Number, Positive, Whole, validate


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """A window of a frame that is centred on the optical axis.

    rows, cols : size of the window
    pitch_um   : distance between neighbouring photosites, µm
    origin     : (row, col) of the window's first photosite in the frame
    frame      : (rows, cols) of the whole frame; None: the window is the frame

    >>> Grid(rows=446, cols=446, pitch_um=4.88).first_centre
    (-222.5, -222.5)
    """

    rows: Count
    cols: Count
    pitch_um: Positive
    origin: tuple[int, int] = (0, 0)
    frame: tuple[Count, Count] | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            rows: Whole,
            cols: Whole,
            pitch_um: Number,
            origin: tuple[Whole, Whole] = (0, 0),
            frame: tuple[Whole, Whole] | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @property
    def moved_um(self) -> tuple[float, float]:
        """Return the displacement of the PSF by a lens's tilt, x and y, µm; photosites are displaced instead."""
        return 0.0, 0.0

    @property
    def first_centre(self) -> tuple[float, float]:
        """Return the effective centre x, y of photosite (0, 0) of the window, in pitches from the optical axis."""
        rows, cols = self.frame or (self.rows, self.cols)
        x, y = (length_um / self.pitch_um for length_um in self.moved_um)
        return self.origin[1] + 0.5 - 0.5 * cols - x, self.origin[0] + 0.5 - 0.5 * rows - y

    def behind(self, moved_um: tuple[float, float]) -> Grid:
        """Return a grid that gives with a PSF the same image as this one with the PSF displaced along x and y."""
        one = {field.name: getattr(self, field.name) for field in fields(Grid)}
        return _Behind(**one, by_um=moved_um) if any(moved_um) else self


@dataclass(frozen=True, slots=True, kw_only=True)
class _Behind(Grid):
    """A grid behind a lens that displaces its PSF."""

    by_um: tuple[float, float]

    @property
    def moved_um(self) -> tuple[float, float]:
        """Return the displacement, x and y, µm."""
        return self.by_um
