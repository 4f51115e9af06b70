"""Scenery in islands: outlines far from one another, each seen through its own part of a lens's pattern.

A pattern that is sampled is taken over a rectangle, from the nearest to the farthest that photosites lie from edges.
What lies between islands is nothing: several small rectangles do for one that holds them all. An image is linear in
its outlines, as long as edges that hang together stay together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.edges import Edges
from camsim.rendering.fourier import prices
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.prune import outline_boxes

GAPS = 6  # along an axis that are tried, the widest first
PER_AREA = 1e-6  # seconds of one core for a square 1/cut-off of a rectangle: its samples', and what is spread there
PER_DISTANCE = 1.1  # nodes for each 1/cut-off along an axis, out to the farthest
TAPERED = 4.0  # 1/cut-off: a taper's width, over the square root of its rectangle's sides in that unit
OPEN = 1e-9  # of the farthest place: what ends of outlines may miss one another by
LEAST = 0.9  # of what all at once takes, by this rule, where it is worth asking what islands really take


@dataclass(frozen=True, slots=True)
class _Sight:
    """What photosites see: from the first to the last (``size``, pitches), of outlines in boxes (n, 2)."""

    kernel: Kernel
    wavelengths: int
    size: F64
    footprint: F64
    low: F64
    high: F64

    def seconds(self, low: F64, high: F64) -> F64:
        """Return about what boxes (n, 2) take, each by itself."""
        nearest = np.maximum(-high - self.footprint, -self.kernel.reach)
        farthest = np.minimum(self.size - low + self.footprint, self.kernel.reach)
        sides = np.maximum(farthest - nearest, 0.0) * self.kernel.cutoff
        wide = sides + TAPERED * np.sqrt(sides.prod(axis=-1))[..., None] ** 0.5
        nodes = PER_DISTANCE * self.kernel.cutoff * np.maximum(np.abs(nearest), np.abs(farthest))
        each = PER_AREA * wide.prod(axis=-1) + prices.PER_PUPIL_NODE * nodes.prod(axis=-1)
        seen = sides.min(axis=-1) > 0.0
        seconds: F64 = np.where(seen, self.wavelengths * each, 0.0)
        return seconds

    def cut(self, which: I64) -> list[I64]:
        """Return outlines as islands: cut at gaps, as long as that takes less."""
        low, high = self.low[which], self.high[which]
        best, parts = LEAST * float(self.seconds(low.min(axis=0), high.max(axis=0))), None
        for axis in (0, 1):
            order = np.argsort(low[:, axis], kind="stable")
            first_low, first_high = low[order], high[order]
            # What begins behind the farthest end of all before lies behind a gap.
            before_low, before_high = np.minimum.accumulate(first_low), np.maximum.accumulate(first_high)
            after_low = np.minimum.accumulate(first_low[::-1])[::-1]
            after_high = np.maximum.accumulate(first_high[::-1])[::-1]
            gap = first_low[1:, axis] - before_high[:-1, axis]
            widest = np.argsort(-gap, kind="stable")[:GAPS]
            widest = widest[gap[widest] > 0.0]
            each = self.seconds(before_low[widest], before_high[widest])
            each = each + self.seconds(after_low[widest + 1], after_high[widest + 1])
            if each.size and each.min() < best:
                best, place = float(each.min()), int(widest[each.argmin()]) + 1
                parts = which[order[:place]], which[order[place:]]
        return [which] if parts is None else [island for part in parts for island in self.cut(part)]


def islands(
    edges: Edges, window: tuple[tuple[float, float], tuple[int, int]], kernel: Kernel, wavelengths: int, footprint: F64
) -> list[Edges]:
    """Return a scene's edges as islands that are likely to take less one by one: as one where there are none such.

    window : the first photosite's centre, and rows and columns;  footprint: how far one sees along x and along y
    """
    origin, (rows, cols) = window
    outline, low, high = outline_boxes(edges)
    size = np.array([cols - 1.0, rows - 1.0])
    sight = _Sight(kernel, wavelengths, size, footprint, low - origin, high - origin)
    found = sight.cut(np.arange(len(low)))
    number = np.empty(len(low), np.int64)
    for k, which in enumerate(found):
        number[which] = k
    own = [edges.some(number[outline] == k) for k in range(len(found))]
    return own if all(map(_closed, own)) else [edges]


def _closed(edges: Edges) -> bool:
    """Whether what has a spectrum is closed: of outlines that only look like one an island may have a part."""
    count = 1 + int(max(edges.left.max(), edges.right.max()))
    along = edges.end - edges.start
    ways = [np.bincount(edges.left, e, count) - np.bincount(edges.right, e, count) for e in along.T]
    return bool(np.abs(ways).max() <= OPEN * float(1.0 + np.abs(edges.points).max()))
