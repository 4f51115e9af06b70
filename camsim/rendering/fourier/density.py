"""Where a scene's edges are, roughly: what a tile's transforms take depends on those in its box alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.rendering.edges import Edges

SQUARES = 64  # along either side of a scene


class Density(NamedTuple):
    """Corners of a scene, and how many edges there are, and how long, in squares of it: summed from its low corner."""

    low: F64
    high: F64
    sums: F64  # (2, rows + 1, columns + 1)

    @classmethod
    def of(cls, edges: Edges) -> Density:
        """Count edges by their middles."""
        low, high = edges.box
        step = np.maximum(high - low, np.finfo(float).tiny) / SQUARES
        middle = 0.5 * (edges.start + edges.end) - low
        square, sums = np.zeros(len(edges), np.int64), np.zeros((2, SQUARES + 1, SQUARES + 1))
        for axis, times in ((0, 1), (1, SQUARES)):
            square += times * np.clip(middle[:, axis] / step[axis], 0.0, SQUARES - 1.0).astype(np.int64)
        for one, weights in zip(sums, (None, edges.length), strict=True):
            here = np.bincount(square, weights, SQUARES**2).reshape(SQUARES, SQUARES)
            one[1:, 1:] = here.cumsum(axis=0).cumsum(axis=1)
        return cls(low, high, sums)

    def within(self, low: F64, high: F64) -> tuple[F64, F64]:
        """Return how many edges there are in squares that boxes (..., 2) touch, and how long they are together."""
        step = np.maximum(self.high - self.low, np.finfo(float).tiny) / SQUARES
        x0, y0 = np.moveaxis(np.clip(np.floor((low - self.low) / step), 0, SQUARES).astype(int), -1, 0)
        x1, y1 = np.moveaxis(np.clip(np.ceil((high - self.low) / step), 0, SQUARES).astype(int), -1, 0)
        count, length = self.sums[:, y1, x1] - self.sums[:, y0, x1] - self.sums[:, y1, x0] + self.sums[:, y0, x0]
        return count, length
