"""Squares of cells of a lattice, and what outlines are about them: each is one, or parted into quarters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.check.patch_nodes import NEXT_TO, crossing
from camsim.rendering.check.scene_samples import ASKED_AT, Segments

QUARTERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
AT_ONCE = 1 << 12  # blocks


class Blocks(NamedTuple):
    """Blocks of one size.

    side    : of each, cells;  at: (n, 2) columns and rows of their first cells
    seen    : (n,) whether the places where they are asked are seen;  cut: (n,) whether an outline is in them
    block, segment : (m,) pairs of a block and a segment that reaches it, or its rim
    """

    side: int
    at: I64
    seen: np.ndarray
    cut: np.ndarray
    block: I64
    segment: I64

    @classmethod
    def of(cls, segments: Segments, side: int, at: I64) -> Blocks:
        """Return some blocks, each compared with all segments."""
        start, end = segments
        found = [np.empty((2, 0), np.int64)]
        seen = np.zeros(len(at), bool)
        for k, place in enumerate(at):
            x, y = place + ASKED_AT * side
            crosses = (start[:, 1] <= y) != (end[:, 1] <= y)
            seen[k] = np.count_nonzero(crossing(start[crosses], end[crosses], y) <= x) % 2
            about = np.flatnonzero(_reaches(start, end, place - NEXT_TO, place + side + NEXT_TO))
            found.append(np.stack([np.full(about.size, k), about]))
        block, segment = np.concatenate(found, axis=1)
        return cls(side, at, seen, _cut(segments, side, at, block, segment), block, segment)

    @property
    def sides(self) -> I64:
        """How many segments reach each."""
        return np.bincount(self.block, minlength=len(self.at))

    def some(self, which: np.ndarray) -> Blocks:
        """Return those that a mask (n,) says."""
        pairs = which[self.block]
        number = np.cumsum(which) - 1
        own = self.at[which], self.seen[which], self.cut[which], number[self.block[pairs]], self.segment[pairs]
        return Blocks(self.side, *own)

    def quarters(self, segments: Segments) -> Blocks:
        """Return the quarters of all.

        From the place where a block is asked the way to those of its quarters lies in it, along a row and a column:
        only what reaches the block may cross it.
        """
        side = self.side // 2
        at = (self.at[:, None] + side * QUARTERS).reshape(-1, 2)
        start, end = (part[self.segment] for part in segments)
        x0, y0 = (self.at + ASKED_AT * self.side)[self.block].T
        owners, pairs, turns = [], [], np.zeros(len(at), np.int64)
        for quarter in range(len(QUARTERS)):
            owner = len(QUARTERS) * self.block + quarter
            x, y = (at + ASKED_AT * side)[owner].T
            along = (start[:, 1] <= y0) != (end[:, 1] <= y0)
            along &= (crossing(start, end, y0) <= x0) != (crossing(start, end, y0) <= x)
            down = (start[:, 0] <= x) != (end[:, 0] <= x)
            height = crossing(start[:, ::-1], end[:, ::-1], x)
            down &= (height <= y0) != (height <= y)
            turns += np.bincount(owner, weights=along ^ down, minlength=len(at)).astype(np.int64)
            low = at[owner] - NEXT_TO
            own = np.flatnonzero(_reaches(start, end, low, low + side + 2.0 * NEXT_TO))
            owners.append(owner[own])
            pairs.append(self.segment[own])
        block, segment = np.concatenate(owners), np.concatenate(pairs)
        seen = np.repeat(self.seen, len(QUARTERS)) ^ (turns % 2 == 1)
        return Blocks(side, at, seen, _cut(segments, side, at, block, segment), block, segment)

    def outlines(self, segments: Segments, k: int) -> Segments:
        """Return what bounds what is seen of a block, its side 1: segments, and uprights along its left and right."""
        own = self.segment[self.block == k]
        a, b = ((part[own] - self.at[k]) / self.side for part in segments)
        # What lies to the left of it does not count: where it begins, the block's left side is seen or not.
        left_a, left_b = a[:, 0] < 0.0, b[:, 0] < 0.0
        turns = crossing(a[:, ::-1], b[:, ::-1], 0.0)
        beginning = np.stack([np.zeros(own.size), turns], axis=1)
        enters = left_a != left_b
        a, b = np.where((enters & left_a)[:, None], beginning, a), np.where((enters & left_b)[:, None], beginning, b)
        a, b, heights = a[~(left_a & left_b)], b[~(left_a & left_b)], turns[enters]
        crosses = (a[:, 1] <= ASKED_AT) != (b[:, 1] <= ASKED_AT)
        before = np.count_nonzero(crossing(a[crosses], b[crosses], ASKED_AT) <= ASKED_AT)
        seen = bool(self.seen[k]) ^ bool((before + np.count_nonzero(heights <= ASKED_AT)) % 2)
        heights = np.concatenate([[-1.0] if seen else [], np.clip(heights, -1.0, 2.0)])
        heights = np.append(heights, [2.0] * (heights.size % 2))
        left = _uprights(0.0, heights)
        a, b = np.concatenate([a, left[0]]), np.concatenate([b, left[1]])
        # Where a row has crossed segments an odd number of times it still is seen on the right.
        right = _uprights(1.0, np.concatenate([a[:, 1], b[:, 1]]))
        return np.concatenate([a, right[0]]), np.concatenate([b, right[1]])


def walk(segments: Segments, shape: tuple[int, int], whole: Callable[[Blocks], np.ndarray]) -> Iterator[Blocks]:
    """Yield blocks of which something is seen, as large as may be; ``whole``: (n,) which need not be parted."""
    side = 1 << (max(shape) - 1).bit_length()
    waiting = [Blocks.of(segments, side, np.zeros((1, 2), np.int64))]
    while waiting:
        blocks = waiting.pop()
        blocks = blocks.some(blocks.seen | blocks.cut)
        done = whole(blocks)
        if done.any():
            yield blocks.some(done)
        number = np.cumsum(~done) - 1
        for first in range(0, np.count_nonzero(~done), AT_ONCE // len(QUARTERS)):
            part = ~done & (number >= first) & (number < first + AT_ONCE // len(QUARTERS))
            waiting.append(blocks.some(part).quarters(segments))


def _uprights(x: float, heights: F64) -> Segments:
    """Return those between the first and the second of heights in order, the third and the fourth …"""
    heights = np.sort(heights)
    top, bottom = (np.stack([np.full(heights.size // 2, x), heights[k::2]], axis=1) for k in (0, 1))
    some = top[:, 1] < bottom[:, 1]
    return top[some], bottom[some]


def _cut(segments: Segments, side: int, at: I64, block: I64, segment: I64) -> np.ndarray:
    """Return (n,) which blocks a segment is in; one along a side is not."""
    low: F64 = at[block].astype(np.float64) + NEXT_TO
    high: F64 = low + (side - 2.0 * NEXT_TO)
    inside = _reaches(segments[0][segment], segments[1][segment], low, high)
    return np.bincount(block[inside], minlength=len(at)) > 0


def _reaches(start: F64, end: F64, low: F64, high: F64) -> np.ndarray:
    """Return (n,) whether segments reach boxes: no line, upright, level or along it, parts one from the other."""
    apart = (np.maximum(start, end) < low).any(axis=1) | (np.minimum(start, end) > high).any(axis=1)
    way, half = end - start, 0.5 * (high - low)
    to_middle = start - (low + half)
    beside = np.abs(way[:, 0] * to_middle[:, 1] - way[:, 1] * to_middle[:, 0])
    reach: np.ndarray = beside <= np.abs(way[:, 0]) * half[..., 1] + np.abs(way[:, 1]) * half[..., 0]
    return ~apart & reach
