"""How much of a line's rings edges hear from some distance on, where what is nearer is cut out by a taper.

A side at a distance h from a photosite sees rings of f cycles a length as ∫ C(r)·exp(2πi·f·r)·h/(r·s) dr, where
s = √(r² − h²) goes along it from its foot. At the foot r stands still: a line is heard, about √(h/f) of it. Elsewhere
r grows by s/r ≥ 0.6 of the way: there it is the ends that are heard, 1/(2π√(f·r))·h/s of what a line is. A taper is no
end: it is as smooth as its band is narrow beside f. So of sides that pass a photosite nearer than where the taper
begins nothing is heard from where they leave it, but for their far ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.rendering.edges import Edges

OBLIQUE = 0.8  # h/r, up to which a side goes away from a photosite
END = 0.5  # times √(λN/r): what an end is heard of a line, twice what it is
TINY = 1e-9  # pitches
SHORT = 0.5  # times a length over √(r·λN): what a short side is


@dataclass(frozen=True, slots=True, eq=False)
class Loudness:
    """Sides of a scene seen from a frame, pitches.

    length  : of each;  nearest: to a photosite, at least;  beside: how far its line passes one, at most
    ends    : (sides, 2) how far its ends are from one, at least;  at_most: the same
    fastest, slowest : rings' wavelengths: of fast ones a short side is more of a line, of slow ones an end is
    """

    length: F64
    nearest: F64
    beside: F64
    ends: F64
    at_most: F64
    fastest: float
    slowest: float

    @classmethod
    def of(cls, edges: Edges, shape: tuple[int, int], extent: float, fastest: float, slowest: float) -> Loudness:
        """Return them of edges seen from a frame's first photosite; extent: how far a photosite reaches."""
        size = np.array([shape[1] - 1.0, shape[0] - 1.0])
        way = edges.end - edges.start
        length = np.hypot(*way.T)
        corners = size * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
        from_start = edges.start[:, None] - corners
        across = np.abs(from_start[..., 0] * way[:, None, 1] - from_start[..., 1] * way[:, None, 0]).max(axis=1)
        beside = across / np.maximum(length, TINY) + extent
        at = np.stack([edges.start, edges.end], axis=1)
        gap = np.maximum(np.maximum(at - size, -at), 0.0)
        at_most = np.hypot(*np.moveaxis(np.maximum(np.abs(at), np.abs(at - size)), 2, 0)) + extent
        to_sides, _ = distances(edges, shape)
        nearest, ends = (np.maximum(away - extent, 0.0) for away in (to_sides, np.hypot(gap[..., 0], gap[..., 1])))
        return cls(length, nearest, beside, ends, at_most, fastest, slowest)

    def beyond(self, distance: float) -> tuple[F64, F64]:
        """Return where sides are heard from a taper at a distance on, and what part of a line's."""
        away = np.maximum(self.nearest, distance)
        part = np.minimum(1.0, SHORT * self.length / np.sqrt(away * self.fastest))
        far = np.maximum(self.ends, distance)
        # Rings fade at least as r^(−5/2): what is farther than ``away`` is told by what is heard there.
        ends = END * np.sqrt(self.slowest / far) * (away[:, None] / far) ** 2.5
        of_ends = np.where(self.at_most >= OBLIQUE * distance, ends, 0.0).sum(axis=1)
        return away, np.where(self.beside <= OBLIQUE * away, np.minimum(part, of_ends), part)


def distances(edges: Edges, shape: tuple[int, int]) -> tuple[F64, float]:
    """Return how far every side is from the frame, at least, and how far one may be from a photosite."""
    low, high = np.minimum(edges.start, edges.end), np.maximum(edges.start, edges.end)
    size = np.array([shape[1] - 1.0, shape[0] - 1.0])
    gap = np.maximum(np.maximum(low - size, -high), 0.0)
    extent = np.maximum(np.maximum(high, size - low), 0.0).max(axis=0)
    return np.hypot(gap[:, 0], gap[:, 1]), float(np.hypot(*extent))
