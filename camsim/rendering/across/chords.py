"""Chords in place of sides that hardly leave them: distortion bends edges by thousandths of a pitch, in many sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.across.pieces import runs_of
from camsim.rendering.edges import Edges


@dataclass(frozen=True, kw_only=True, eq=False)
class Chords:
    """Edges with chords in place of bent ones.

    edges  : chords, and what was left as it is;  which: of these are chords
    points : of each chord's own bent edge, from one end to the other
    """

    edges: Edges
    which: I64
    points: tuple[F64, ...]


def chords_of(edges: Edges, highest: float, shortest: float = 0.0) -> Chords:
    """Return edges with chords of runs for sides that are nowhere farther from them than ``highest``.

    shortest : of what becomes a chord
    """
    kept: list[I64] = []
    points: list[F64] = []
    spans: list[tuple[int, int]] = []
    for run in runs_of(edges):
        own = np.concatenate([edges.start[run], edges.end[run[-1:]]])
        length = np.append(0.0, np.cumsum(edges.length[run]))
        waiting = [(0, run.size)]
        while waiting:
            a, b = waiting.pop()
            whole = length[b] - length[a]
            if b - a > 1 and whole >= shortest:
                height = float(np.abs(heights(own[a : b + 1])[1]).max()) if np.any(own[a] != own[b]) else np.inf
                if height <= highest:
                    spans.append((int(run[a]), int(run[b - 1])))
                    points.append(own[a : b + 1])
                    continue
                # Heights go as the square of lengths: not two sides on the average would be one.
                if height == np.inf or (b - a) ** 2 * highest >= 4.0 * height:
                    middle = int(np.clip(np.searchsorted(length, length[a] + 0.5 * whole), a + 1, b - 1))
                    waiting += [(a, middle), (middle, b)]
                    continue
            kept.append(run[a:b])
    if not spans:
        return Chords(edges=edges, which=np.zeros(0, np.int64), points=())
    first, last = np.array(spans).T
    rest = np.concatenate(kept) if kept else np.zeros(0, np.int64)
    # In the order of the outlines, or edges would not be seen to go on in one another.
    order = np.argsort(np.concatenate([rest, first]), kind="stable")
    places_of = np.empty(order.size, np.int64)
    places_of[order] = np.arange(order.size)
    begin, end = np.concatenate([rest, first])[order], np.concatenate([rest, last])[order]
    return Chords(
        edges=Edges(start=edges.start[begin], end=edges.end[end], left=edges.left[begin], right=edges.right[begin]),
        which=places_of[rest.size :],
        points=tuple(points),
    )


def heights(points: F64) -> tuple[F64, F64]:
    """Return how far along a chord points (n, 2) lie, and how far to its left."""
    chord = points[-1] - points[0]
    tx, ty = chord / np.hypot(*chord)
    x, y = (points - points[0]).T
    return x * tx + y * ty, y * tx - x * ty
