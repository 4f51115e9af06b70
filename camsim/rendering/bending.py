"""A scene's edges behind a lens with distortion: straight edges become curves, approximated by short straight sides.

Distortion acts on the scene before the blur, so edges are mapped first and the image stays a sum over edges. The sides
enclose the area of the curve: on average it lies two thirds of the sagitta from a chord, and the corner between two
sides is moved outwards to compensate half of either's deficit. The sides then oscillate about the curve by up to two
thirds of a sagitta. The effect on a photosite is at most this times the line spread, and vanishes for equal sides
shorter than the waves that the system passes. A corner of the scene must stay in place, so the side next to it lacks an
area of a third of the sagitta times its length, which counts in full, times the peak of the PSF. If a side is half as
long as the next, a quarter of that area lies half a side from its place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.optics.protocols import Varies
from camsim.rendering.grid import Grid

TAIL, PEAK = math.pi**3 / 2.0, 1.3  # an Airy pattern's line spread is 1/(TAIL·x²), x in λN, and PEAK in its middle
STEP, MOST_STEPS = 1.02, 500  # ratio of radii in the search for the preimage of a corner: up to 2e4 times as far
MORE = 2.0  # margin over a corner's displacement: a polynomial need not be monotonic
FULL = 24.0  # λN: distance from the window up to which the line spread's peak is assumed
MOST_HALVINGS = 40  # 2⁻⁴⁰ of a side is rounding
QUARTERS = np.array([0.25, 0.5, 0.75])  # places along a side where it is held against its chord


def undistorted(grid: Grid, lens: Varies) -> Grid:
    """Return a window that contains the preimage of a window under the distortion, with a margin.

    The largest displacement is assumed to be that at the corners or at their preimages; for barrel distortion, the
    latter.
    """
    first = np.array(grid.first_centre) * grid.pitch_um
    size = np.array([grid.cols - 1, grid.rows - 1]) * grid.pitch_um
    corners = np.array([first + size * share for share in ((0, 0), (0, 1), (1, 0), (1, 1))])
    away, times = np.hypot(*corners.T), np.ones(4)
    for _ in range(MOST_STEPS):
        short = np.hypot(*lens.distorted(times[:, None] * corners).T) < away
        if not short.any():
            break
        times[short] *= STEP
    moved = max(np.hypot(*(lens.distorted(corners) - corners).T).max(), ((times - 1.0) * away).max())
    more, frame = math.ceil(MORE * moved / grid.pitch_um) + 1, grid.frame or (grid.rows, grid.cols)
    row, col = grid.origin
    return Grid(
        rows=grid.rows + 2 * more,
        cols=grid.cols + 2 * more,
        pitch_um=grid.pitch_um,
        origin=(row - more, col - more),
        frame=frame,
    )


class Sides(NamedTuple):
    """Straight sides of distorted edges: first and last points (n, 2), and the edge of each (n,)."""

    start: F64
    end: F64
    owner: I64


@dataclass(frozen=True, kw_only=True, eq=False)
class Bending:
    """The approximation of distorted edges by straight sides.

    lens    : gives the distortion;  blur_um: λN at the shortest wavelength
    peak_per_um : largest value of a photosite's line spread, in any direction
    allowed : error of one edge, relative to its contrast
    """

    lens: Varies
    grid: Grid
    blur_um: float
    peak_per_um: float
    allowed: float

    def sides(self, start_um: F64, end_um: F64) -> Sides:
        """Return the distorted images of straight edges (n, 2), µm, as straight sides on the sensor."""
        count = len(start_um)
        low, high, owner = np.zeros(count), np.ones(count), np.arange(count)
        done: list[tuple[I64, F64, F64]] = []
        for _ in range(MOST_HALVINGS):
            fine = self._fine(start_um[owner], end_um[owner], low, high)
            done.append((owner[fine], low[fine], high[fine]))
            owner, low, high = owner[~fine], low[~fine], high[~fine]
            if not owner.size:
                break
            middle = 0.5 * (low + high)
            owner = np.concatenate([owner, owner])
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        else:
            done.append((owner, low, high))
        owner, low, high = (np.concatenate(parts) for parts in zip(*done, strict=True))
        order = np.lexsort((low, owner))
        return self._drawn(start_um, end_um, owner[order], low[order], high[order])

    def _places(self, start: F64, end: F64, share: F64) -> F64:
        # Exact to the bit at 0 and 1, where the next edge begins: otherwise the outline would break.
        return self.lens.distorted((1.0 - share)[:, None] * start + share[:, None] * end)

    def _fine(self, start: F64, end: F64, low: F64, high: F64) -> np.ndarray:
        """Return a mask of the parts of edges that a straight side approximates well enough."""
        a, b = self._places(start, end, low), self._places(start, end, high)
        off = np.zeros(len(low))
        for quarter in QUARTERS:
            there = self._places(start, end, low + quarter * (high - low))
            gap = there - a - quarter * (b - a)
            off = np.maximum(off, np.hypot(gap[:, 0], gap[:, 1]) / (4.0 * quarter * (1.0 - quarter)))
        spread = self._line_spread(a, b)
        length = np.hypot(*(b - a).T)
        lacks = off * np.minimum(length / self.blur_um, 1.0) * spread / 3.0  # longer sides act locally
        one = np.where((low == 0.0) | (high == 1.0), 2.0, np.minimum(length / (4.0 * self.blur_um), 1.0))
        short = (length <= 0.5 * self.blur_um) & (one * lacks <= self.allowed)
        fine: np.ndarray = short | (2.0 / 3.0 * off * spread + one * lacks <= self.allowed)
        return fine

    def _line_spread(self, a: F64, b: F64) -> F64:
        """Return the largest line spread of a side between two points at any photosite of the window, 1/µm."""
        first = np.array(self.grid.first_centre) * self.grid.pitch_um
        last = first + np.array([self.grid.cols - 1, self.grid.rows - 1]) * self.grid.pitch_um
        gap = np.maximum(np.maximum(first - np.maximum(a, b), np.minimum(a, b) - last), 0.0)
        x = np.maximum(np.hypot(gap[:, 0], gap[:, 1]) / self.blur_um - FULL, 0.0)
        spread = np.minimum(PEAK, 1.0 / (TAIL * np.maximum(x, 1e-9) ** 2)) / self.blur_um
        lower: F64 = np.minimum(spread, self.peak_per_um)
        return lower

    def _drawn(self, start_um: F64, end_um: F64, owner: I64, low: F64, high: F64) -> Sides:
        start, end = start_um[owner], end_um[owner]
        a, b = self._places(start, end, low), self._places(start, end, high)
        arrow = self._places(start, end, 0.5 * (low + high)) - 0.5 * (a + b)
        inner = owner[1:] == owner[:-1]
        length = np.hypot(*(b - a).T)[:, None]
        lacks = arrow * length
        outward = ((lacks[1:] + lacks[:-1]) / (1.5 * (length[1:] + length[:-1])))[inner]
        b[:-1][inner] += outward
        a[1:][inner] += outward
        there = np.any(a != b, axis=1)  # a side of zero length has no direction
        return Sides(a[there], b[there], owner[there])
