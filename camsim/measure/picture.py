"""Picture: linear numbers to measure in, as planes that are each sampled on a lattice of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64
from camsim.errors import InvalidValueError, UnknownNameError
from camsim.measure.geometry import Roi


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plane:
    """One channel of an image, sampled at every ``step``-th row and column.

    name         : R, G1 (green in the rows of red), G2, B; Y for one channel; or what the file calls it
    samples      : (n, m) numbers in proportion to light, above ``black``
    first, step  : row and column of samples[0, 0] in the image, and the distance between samples, both (rows, cols)
    black, white : signal of no light, and the signal from which on it is clipped (None: never)
    lowest       : the smallest number that can be stored (None: no limit); many of them are clipped shadows
    """

    name: str
    samples: npt.NDArray[Any]
    first: tuple[int, int] = (0, 0)
    step: tuple[int, int] = (1, 1)
    black: float = 0.0
    white: float | None = None
    lowest: float | None = None

    @property
    def nyquist_cycles_per_pixel(self) -> float:
        """Half the sampling frequency along rows and columns, the lower of the two."""
        return 0.5 / max(self.step)

    def cut(self, roi: Roi) -> tuple[npt.NDArray[Any], F64, F64]:
        """Return the samples (n, m) in a region, and their centres: x (m,) and y (n,) in pixels of the image."""
        rows, cols = (
            slice(-(-(start - first) // step), -(-(start + size - first) // step))
            for start, size, first, step in zip(
                (roi.row, roi.col), (roi.rows, roi.cols), self.first, self.step, strict=True
            )
        )
        inside = self.samples[max(rows.start, 0) : rows.stop, max(cols.start, 0) : cols.stop]
        y = self.first[0] + 0.5 + self.step[0] * (max(rows.start, 0) + np.arange(inside.shape[0], dtype=np.float64))
        x = self.first[1] + 0.5 + self.step[1] * (max(cols.start, 0) + np.arange(inside.shape[1], dtype=np.float64))
        return inside, x, y


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """An image to measure in.

    name        : what to call it in messages
    shape       : (rows, cols)
    planes      : its channels
    pitch_um    : distance between photosites, None where that is not known
    description : what the file says of how it was computed; None for other people's files
    """

    name: str
    shape: tuple[int, int]
    planes: tuple[Plane, ...]
    pitch_um: float | None = None
    description: Mapping[str, Any] | None = field(default=None, repr=False)

    def select(self, channel: str) -> tuple[Plane, ...]:
        """Return the plane of that name; ``all`` gives every one."""
        if channel == "all":
            return self.planes
        found = tuple(plane for plane in self.planes if plane.name == channel)
        if not found:
            raise UnknownNameError("channel", channel, ["all", *(plane.name for plane in self.planes)])
        return found


def mosaic_planes(
    samples: npt.NDArray[Any],
    pattern: Sequence[str],
    *,
    black: float = 0.0,
    white: float | None = None,
    lowest: float | None = None,
) -> tuple[Plane, ...]:
    """Split a mosaic into the lattices of its filters, without interpolation.

    samples : (rows, cols);  pattern: letters of its own (0,0) (0,1) …, one string per row, such as ("RG", "GB")

    The two greens of a Bayer array are measured apart, because crosstalk makes them differ.

    >>> [(plane.name, plane.first) for plane in mosaic_planes(np.zeros((4, 4)), ("GR", "BG"))]
    [('R', (0, 1)), ('G1', (0, 0)), ('G2', (1, 1)), ('B', (1, 0))]
    """
    rows, cols = len(pattern), len(pattern[0])
    letters = sorted({letter for row in pattern for letter in row}, key=lambda s: ("RGB".find(s) % 99, s))
    places = {
        letter: [(r, c) for r in range(rows) for c in range(cols) if pattern[r][c] == letter] for letter in letters
    }
    if rows * cols > 1 and (rows, cols) != (2, 2):
        raise InvalidValueError(
            f"colour filter array {' / '.join(pattern)}: only Bayer-like arrays of 2 × 2 and mono can be measured "
            "from the mosaic; measure planes of an EXR with the product truth instead"
        )
    planes = []
    for letter, found in places.items():
        # Green in the rows of red is G1, whichever row of the pattern that is.
        found = sorted(found, key=lambda place: "R" not in pattern[place[0]])
        for number, (row, col) in enumerate(found, start=1):
            planes.append(
                Plane(
                    name=f"{letter}{number}" if len(found) > 1 else letter,
                    samples=samples[row::rows, col::cols],
                    first=(row, col),
                    step=(rows, cols),
                    black=black,
                    white=white,
                    lowest=lowest,
                )
            )
    return tuple(planes)
