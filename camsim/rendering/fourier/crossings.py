"""How many outlines a pupil's spikes meet: what they leave out comes from where these cross them, not from all edges.

What a region hears of an oscillation along a spike is told by its outline where the spike crosses it: a chain of a
thousand short edges crosses it no more often than one long edge does. So edges are projected along every spike, and
what each leaves out is spread over the width that it covers there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.optics.spikes import Spike
from camsim.rendering.edges import Edges

BINS = 2.0  # of a spike's width
BESIDE = 8.0  # widths of a spike to either side of the frame: beyond, a hundredth of its light
ALIKE = 1e-9  # sines of angles between sides that are parallel


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Axis:
    """Edges as they lie across parallel spikes: the lower and upper ends in order, and the ends of the bins."""

    low: F64
    high: F64
    by_low: np.ndarray
    by_high: np.ndarray
    bins: F64

    @classmethod
    def of(cls, across: F64, edges: Edges, shape: tuple[int, int], width: float, moved: float) -> _Axis:
        """Project edges, seen from the first photosite of a frame."""
        ends = np.stack([edges.start @ across, edges.end @ across])
        low, high = ends.min(axis=0), ends.max(axis=0)
        frame = np.multiply.outer([0.0, shape[1] - 1.0], across[:1]) + across[1] * np.array([0.0, shape[0] - 1.0])
        beside = BESIDE * width + moved
        first, last = float(frame.min()) - beside, float(frame.max()) + beside
        count = int(np.ceil(BINS * (last - first) / width))
        by_low, by_high = np.argsort(low, kind="stable"), np.argsort(high, kind="stable")
        return cls(
            low=low[by_low], high=high[by_high], by_low=by_low, by_high=by_high,
            bins=np.linspace(first, last, count + 1),
        )  # fmt: skip

    def most(self, each: F64) -> float:
        """Return the most that any bin's width of a spike meets of what each edge has on all of its own."""
        covered = _up_to(self.bins, self.low, each[self.by_low]) - _up_to(self.bins, self.high, each[self.by_high])
        met: float = np.diff(covered).max() / (self.bins[1] - self.bins[0])
        return met


def _up_to(bins: F64, ends: F64, each: F64) -> F64:
    """Return Σ each·(bin − end) of all ends below a bin, for every bin."""
    count = np.searchsorted(ends, bins)
    first = ends[0]
    sums = np.concatenate([np.zeros((2, 1)), np.cumsum([each, each * (ends - first)], axis=1)], axis=1)
    total: F64 = sums[0, count] * (bins - first) - sums[1, count]
    return total


class Crossings:
    """Edges that spikes of a width meet on their way from a frame, moved by a wavefront at the most so far."""

    def __init__(
        self, spikes: Sequence[Spike], edges: Edges, shape: tuple[int, int], width: float, moved: float = 0.0
    ) -> None:
        apart: list[F64] = []
        for spike in spikes:
            if all(abs(float(spike.along @ other)) > ALIKE for other in apart):
                apart.append(spike.across)
        self._axes = [_Axis.of(across, edges, shape, width, moved) for across in apart]

    def most(self, each: F64, least: float) -> float:
        """Return the most that spikes of any photosite leave out, of what edges may each; ``least``: any one of them.

        Both ways of all spikes are added up; besides, between two spikes there is light that meets no edge.
        """
        return sum(axis.most(each) + least for axis in self._axes)
