"""Where pieces of outlines lie about a frame: their ends and how strong these are, and how far they are from places."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, kinds_of
from camsim.kept import cached_property
from camsim.rendering.check.beziers import polynomials
from camsim.rendering.check.records import Outlines
from camsim.rendering.check.scenery import Pieces

LOOKED_AT = 24  # places in the frame where ends are heard
AT_ONCE = 1 << 16  # places × pieces that are looked at together: there may be millions of pieces


@dataclass(frozen=True, kw_only=True, eq=False)
class Whereabouts:
    """Pieces about a frame, pitches; Bézier curves are short, and as far away as their chords.

    corners : (4,) low x, low y, high x, high y of the outermost photosites
    """

    pieces: Pieces
    corners: F64

    @property
    def outlines(self) -> Outlines:
        """Of the pieces, chords among them."""
        return self.pieces.outlines

    @cached_property
    def length(self) -> F64:
        """Of each piece (n,)."""
        return self.outlines.length

    @cached_property
    def _lines(self) -> tuple[F64, F64, F64]:
        """Directions of straight pieces and their lengths (n,), which are 0 of others."""
        o, straight = self.outlines, self.outlines.turn_rad == 0.0
        size = np.where(straight, self.length, 1.0)
        return o.dx / size, o.dy / size, np.where(straight, size, 0.0)

    @cached_property
    def ends(self) -> tuple[F64, F64]:
        """Ends of pieces (n, 2), and how strong each is: how its direction jumps, at most as at a right angle (1).

        Jumps of four may cancel where their rings do not: they count as the root of how many meet.
        """
        o, (tx, ty, _) = self.outlines, self._lines
        straight = o.turn_rad == 0.0
        first, last, leaves, comes = o.x + 1j * o.y, o.x + o.dx + 1j * (o.y + o.dy), tx + 1j * ty, tx + 1j * ty
        if not straight.all():
            begin, finish = (np.exp(1j * angle) for angle in (o.from_rad, o.from_rad + o.turn_rad))
            centre = o.x + 1j * o.y
            first, last = (
                np.where(straight, first, centre + o.dx * begin),
                np.where(straight, last, centre + o.dx * finish),
            )
            leaves, comes = np.where(straight, leaves, 1j * begin), np.where(straight, comes, 1j * finish)
        curves = np.flatnonzero(self.pieces.bezier >= 0)
        if curves.size:
            _, c1, c2, c3 = polynomials(self.pieces.curves[self.pieces.bezier[curves]]).T
            for ways, t in ((leaves, -1.0), (comes, 1.0)):
                way = c1 + 2.0 * t * c2 + 3.0 * c3
                size = np.abs(way)
                ways[curves] = np.where(size > 0.0, way / np.where(size > 0.0, size, 1.0), ways[curves])
        places, index = kinds_of(np.round(np.concatenate([first, last]), 9))
        turns = np.concatenate([leaves, -comes])
        jump = np.hypot(*(np.bincount(index, part, places.size) for part in (turns.real, turns.imag)))
        meeting = np.bincount(index, minlength=places.size)
        strength = np.where(meeting > 3, np.sqrt(meeting), np.minimum(jump / math.sqrt(2.0), 1.0))
        return places.view(np.float64).reshape(-1, 2), strength

    @cached_property
    def listeners(self) -> F64:
        """Places (n, 2) of the frame: ends of outlines, moved into it, and its middle."""
        ends = self.ends[0]
        some = ends[:: max(1, len(ends) // LOOKED_AT)]
        low, high = self.corners[:2], self.corners[2:]
        return np.concatenate([np.minimum(np.maximum(some, low), high), [0.5 * (low + high)]])

    @property
    def farthest(self) -> float:
        """No piece reaches farther than this from any photosite."""
        o = self.outlines
        straight = o.turn_rad == 0.0
        # The centre of what hardly bends is far away: a part of a circle lies about its middle.
        part = ~straight & (np.abs(o.turn_rad) < 2.0)
        middle_rad = o.from_rad + 0.5 * o.turn_rad
        from_x = o.x + np.where(part, o.dx * np.cos(middle_rad), 0.0)
        from_y = o.y + np.where(part, o.dx * np.sin(middle_rad), 0.0)
        more = np.where(straight, 0.0, np.where(part, 0.5 * np.abs(o.turn_rad), 1.0) * o.dx)
        x = np.concatenate([from_x, from_x + np.where(straight, o.dx, 0.0)])
        y = np.concatenate([from_y, from_y + np.where(straight, o.dy, 0.0)])
        x0, y0, x1, y1 = self.corners
        more[self.pieces.bezier >= 0] = self.length[self.pieces.bezier >= 0]
        across = np.maximum(np.abs(x - x0), np.abs(x - x1)) + np.tile(more, 2)
        down = np.maximum(np.abs(y - y0), np.abs(y - y1)) + np.tile(more, 2)
        return float(np.hypot(across, down).max(initial=0.0))

    def some_of(self, places: F64) -> Iterator[F64]:
        """Yield places (n, 2), some at a time."""
        step = max(1, AT_ONCE // max(1, len(self.length)))
        yield from (places[first : first + step] for first in range(0, len(places), step))

    def feet(self, places: F64) -> tuple[F64, np.ndarray]:
        """Return (places, pieces): distance from each straight piece's line, and whether its foot lies on the piece."""
        h, s = self._lines_from(places)
        return h, (s > 0.0) & (s < self._lines[2])

    def within(self, places: F64, radius: float) -> F64:
        """Return how much (places, pieces) of each straight piece lies within a radius of places."""
        h, s = self._lines_from(places)
        half = np.sqrt(np.maximum(radius * radius - h * h, 0.0))
        within: F64 = np.maximum(np.minimum(s + half, self._lines[2]) - np.maximum(s - half, 0.0), 0.0)
        return within

    def _lines_from(self, places: F64) -> tuple[F64, F64]:
        """Return (places, pieces): distance from each straight piece's line, and where along it the foot lies."""
        tx, ty, _ = self._lines
        dx, dy = self.outlines.x - places[:, :1], self.outlines.y - places[:, 1:]
        return dx * ty - dy * tx, -(dx * tx + dy * ty)

    def heard_beyond(self, radii: F64) -> F64:
        """Return Σ strength²·(radius/distance)⁵ of all ends and lines beyond each radius, where that is the most."""
        ends, strength = self.ends
        most = np.zeros_like(radii)
        for places in self.some_of(self.listeners) if radii.size else ():
            h, beside = self.feet(places)
            gap = np.hypot(ends[:, 0] - places[:, :1], ends[:, 1] - places[:, 1:])
            distance = np.concatenate([gap, np.abs(h)], axis=1)
            loud = np.maximum(distance / radii[0], 1.0) ** -5.0
            loud *= np.concatenate([np.broadcast_to(strength**2, gap.shape), 4.0 * beside], axis=1)
            shells = np.searchsorted(radii, distance) + (radii.size + 1) * np.arange(len(places))[:, None]
            summed = np.bincount(shells.ravel(), loud.ravel(), (radii.size + 1) * len(places))
            beyond = np.cumsum(summed.reshape(len(places), -1)[:, ::-1], axis=1)[:, -2::-1]
            most = np.maximum(most, (radii / radii[0]) ** 5 * beyond.max(axis=0))
        return most
