"""Counts for the noise distribution of darks: of differences of two pairs at a time, and of single codes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64

_BLOCKS = 64
_TAIL, _CORE = 14, 14
_LEAST_COUNT = 100
_MOST_PAIRS = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairCounts:
    """Counts (blocks, bins, bins) of two pairs' differences; ``bin_of`` (n,) gives the bin of each of ``lattice`` (n,).

    Differences on the lattice are in steps between codes.
    """

    counts: F64
    lattice: I64
    bin_of: I64
    step_dn: float
    variance_dn2: float

    @classmethod
    def of(cls, frames: Sequence[I64], step_dn: float) -> PairCounts:
        """Count equal darks (rows, cols) of integer codes."""
        pairs = [
            np.rint((a.astype(np.float64) - b) / step_dn).astype(np.int64)
            for a, b in zip(frames[::2], frames[1::2], strict=False)
        ]
        # The offset of a frame is not noise of a photosite.
        pairs = [pair - round(float(np.median(pair))) for pair in pairs]
        far = [np.abs(pair) for pair in pairs]
        top = max(int(each.max()) for each in far)
        counted = sum(np.bincount(each.ravel(), minlength=top + 1) for each in far)
        edges = _edges(np.asarray(counted, np.int64))
        bin_of = np.searchsorted(edges, np.arange(top + 1), side="right") - 1
        bins = len(edges)
        blocks = min(_BLOCKS, len(frames[0]))
        block_of = np.arange(len(frames[0])) * blocks // len(frames[0])
        both = list(itertools.combinations(range(len(pairs)), 2))
        # Every pair is used equally often.
        both = both if len(both) <= _MOST_PAIRS else [(k, (k + 1) % len(pairs)) for k in range(len(pairs))]
        placed = [bin_of[each] for each in far]
        counts = np.zeros(blocks * bins * bins)
        for a, b in both:
            index = (block_of[:, None] * bins + placed[a]) * bins + placed[b]
            counts += np.bincount(index.ravel(), minlength=counts.size)
        return cls(
            counts=counts.reshape(blocks, bins, bins),
            lattice=np.arange(top + 1),
            bin_of=bin_of,
            step_dn=step_dn,
            variance_dn2=float(np.mean([np.mean(pair.astype(np.float64) ** 2) for pair in pairs])) * step_dn**2 / 2.0,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SingleCounts:
    """Counts (m, n) of codes on a lattice (n,) of steps; each line is a cell of one frame, of mean (m,) steps."""

    counts: F64
    lattice: I64
    mean: F64

    @classmethod
    def of(cls, frames: Sequence[I64], step_dn: float, period: tuple[int, int]) -> SingleCounts:
        """Count darks (rows, cols) of integer codes; ``period``: of the filter array."""
        cells = [frame[row :: period[0], col :: period[1]] for frame in frames for row, col in np.ndindex(period)]
        steps = [np.rint(cell / step_dn).astype(np.int64).ravel() for cell in cells]
        low, high = min(int(each.min()) for each in steps), max(int(each.max()) for each in steps)
        return cls(
            counts=np.stack([np.bincount(each - low, minlength=high - low + 1) for each in steps]).astype(np.float64),
            lattice=np.arange(low, high + 1),
            mean=np.array([float(each.mean()) for each in steps]),
        )


def _edges(counted: I64) -> I64:
    """Return first lattice points of bins: uniform in the core, increasingly wide in the tail."""
    above = 1.0 - np.concatenate([[0.0], np.cumsum(counted)[:-1]]) / counted.sum()  # of |d| ≥ k
    least = _LEAST_COUNT / counted.sum()
    wanted = np.concatenate([
        np.linspace(1.0, 0.08, _CORE, endpoint=False), np.geomspace(0.08, max(least, 1e-9), _TAIL)
    ])  # fmt: skip
    edges = {0}
    for share in wanted[wanted >= least]:
        edges.add(int(np.argmin(np.abs(above - share))))
    return np.array(sorted(edges))
