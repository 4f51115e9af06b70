"""Which sides of a scene the check takes for heard beyond a taper: as ``fourier/loudness.py``, found in another way.

Every side is cut where it goes away from a photosite at 0.6 of its own pace: between the cuts it is heard as a line,
from its nearest place on, and beyond them by its ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.rendering.edges import Edges

STANDING = 0.75  # distances from the line, on either side of the foot
OF_END = 0.5  # times √(λN/r)


class Sides(NamedTuple):
    """Sides seen from a frame, pitches.

    near, far : (sides,) of what is heard as a line, over all of the frame; −inf: none
    length    : (sides,) of that
    ends, to  : (sides, 2) how far its ends are, at least and at most;  fastest, slowest: rings' wavelengths
    """

    near: F64
    far: F64
    length: F64
    ends: F64
    to: F64
    fastest: float
    slowest: float

    @classmethod
    def of(cls, edges: Edges, shape: tuple[int, int], extent: float, fastest: float, slowest: float) -> Sides:
        """Return them of edges seen from a frame's first photosite; extent: how far a photosite reaches."""
        way = edges.end - edges.start
        whole = np.maximum(np.hypot(*way.T), 1e-9)
        along = way / whole[:, None]
        size = np.array([shape[1] - 1.0, shape[0] - 1.0])
        near, far, length = np.full(len(edges), np.inf), np.full(len(edges), -np.inf), np.zeros(len(edges))
        ends, to = np.full((len(edges), 2), np.inf), np.zeros((len(edges), 2))
        for corner in (np.zeros(2), size * (1.0, 0.0), size * (0.0, 1.0), size):
            start = edges.start - corner
            first = np.einsum("nx,nx->n", start, along)
            height = np.abs(start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0])
            stands = STANDING * (height + extent) + extent
            low, high = np.maximum(first, -stands), np.minimum(first + whole, stands)
            there = low <= high
            farthest = np.hypot(height, np.maximum(np.abs(low), np.abs(high)))
            nearest = np.hypot(height, np.clip(0.0, first, first + whole))
            near = np.minimum(near, nearest)
            far = np.where(there, np.maximum(far, farthest + extent), far)
            length = np.where(there, np.maximum(length, high - low), length)
            own = np.hypot(height[:, None], np.stack([first, first + whole], axis=1))
            ends, to = np.minimum(ends, own), np.maximum(to, own + extent)
        between = 0.5 * float(np.hypot(*size)) + extent  # no photosite lies farther from a corner
        near, ends = (np.maximum(own - between, 0.0) for own in (near, ends))
        return cls(near, far + between, length, ends, to, fastest, slowest)

    def beyond(self, distance: float) -> tuple[F64, F64]:
        """Return where sides are heard from a taper at a distance on, and what part of a line's."""
        away = np.maximum(self.near, distance)
        lines = np.where(self.far >= distance, np.minimum(1.0, 0.5 * self.length / np.sqrt(away * self.fastest)), 0.0)
        at = np.maximum(self.ends, distance)
        ends = OF_END * np.sqrt(self.slowest / at) * (away[:, None] / at) ** 2.5 * (self.to >= 0.8 * distance)
        return away, lines + ends.sum(axis=1)
