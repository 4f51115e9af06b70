"""Edges of a scene, for every engine: straight and directed, with a spectrum on either side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, kinds_of
from camsim.core.cached import cached_property
from camsim.rendering.grid import Grid


@dataclass(frozen=True, kw_only=True, eq=False)
class Edges:
    """Edges in pitches.

    start, end  : (n, 2) x and y of their ends
    left, right : (n,) index of the spectrum on either side as one walks along (0: the background)
    """

    start: F64
    end: F64
    left: I64
    right: I64

    def __len__(self) -> int:
        """Number of edges."""
        return len(self.start)

    def some(self, which: np.ndarray) -> Edges:
        """Return the edges selected by a mask or by indices; the same object if a mask selects all."""
        if which.dtype == bool and which.all():
            return self
        return Edges(start=self.start[which], end=self.end[which], left=self.left[which], right=self.right[which])

    @cached_property
    def length(self) -> F64:
        """Length (n,) of each edge."""
        along = self.end - self.start
        length: F64 = np.hypot(along[:, 0], along[:, 1])
        return length

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner (2,) of the bounding box of all edges; there must be at least one."""
        # Column by column: numpy reduces rows of two one by one.
        columns = list(zip(self.start.T, self.end.T, strict=True))
        low = np.array([min(a.min(), b.min()) for a, b in columns])
        return low, np.array([max(a.max(), b.max()) for a, b in columns])

    @cached_property
    def along(self) -> F64:
        """Unit vector (n, 2) along each edge."""
        along: F64 = (self.end - self.start) / self.length[:, None]
        return along

    @property
    def points(self) -> F64:
        """End points of all edges (2n, 2), the starts first."""
        return np.concatenate([self.start, self.end])

    @cached_property
    def corners(self) -> tuple[F64, I64, I64]:
        """The distinct end points (m, 2), and the indices (n,) of each edge's start and end among them."""
        return corners_of(self.start, self.end)

    @cached_property
    def turning(self) -> float:
        """Number of straight edges, where the sides of a curve count only by the sine of the angle between them."""
        a, b = self.along[:-1], self.along[1:]
        sine = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        goes_on = (self.end[:-1, 0] == self.start[1:, 0]) & (self.end[:-1, 1] == self.start[1:, 1])
        ahead = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] > 0.0
        return float(np.where(goes_on & ahead, sine, 1.0).sum()) + min(len(self), 1)

    def farthest(self, grid: Grid) -> float:
        """Return the largest distance of a photosite's centre from an end, pitches."""
        first = np.array(grid.first_centre)
        last = first + np.array([grid.cols - 1, grid.rows - 1])
        farthest = 0.0
        for ends in (self.start, self.end):
            gap = np.maximum(np.abs(ends - first), np.abs(ends - last))
            farthest = max(farthest, float(np.hypot(gap[:, 0], gap[:, 1]).max(initial=0.0)))
        return farthest

    def pairs(self) -> tuple[I64, I64]:
        """Return the pairs of spectra (m, 2) on the sides of edges, left and right, and each edge's pair (n,)."""
        spectra = int(self.right.max(initial=0)) + 1
        both, pair = kinds_of(self.left * spectra + self.right)
        return np.stack(np.divmod(both, spectra), axis=1), pair


def corners_of(start: F64, end: F64) -> tuple[F64, I64, I64]:
    """Return the distinct end points (m, 2) of edges, and the indices (n,) of each edge's start and end."""
    begin, finish = (np.ascontiguousarray(ends).view(np.complex128).ravel() for ends in (start, end))
    # Most edges continue in the next one, so few ends must be sorted.
    loose = np.append(finish[:-1] != begin[1:], True)[: len(begin)]
    places, index = kinds_of(np.concatenate([begin, finish[loose]]))
    begins, ends = index[: len(begin)], np.append(index[1 : len(begin)], 0)[: len(begin)]
    ends[loose] = index[len(begin) :]
    return places.view(np.float64).reshape(-1, 2), begins, ends


def shares_within(start: F64, end: F64, low: F64, high: F64) -> tuple[F64, F64]:
    """Return the fractions (n,) of each segment at which it enters and leaves the box ``low`` … ``high`` (x, y).

    Liang–Barsky clipping. A segment that misses the box leaves it before it enters: the first fraction is the larger.

    >>> shares_within(np.array([[-1.0, 0.5]]), np.array([[3.0, 0.5]]), np.zeros(2), np.ones(2))
    (array([0.25]), array([0.5]))
    """
    along = end - start
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, b = (low - start) / along, (high - start) / along
    # 0/0: along a side of the box, which counts as within.
    on_side = np.isnan(a) | np.isnan(b)
    enters, leaves = np.where(on_side, 0.0, np.minimum(a, b)), np.where(on_side, 1.0, np.maximum(a, b))
    # Column by column: numpy reduces rows of two one by one.
    return np.maximum(0.0, np.maximum(*enters.T)), np.minimum(1.0, np.minimum(*leaves.T))
