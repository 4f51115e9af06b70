"""Visibility of the patches of a lattice: visible ones, hidden ones, and the visible parts of those that are cut."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.rendering.edges import shares_within
from camsim.rendering.fields.layer import Rings
from camsim.scene.patches import edges_of, pieces_of

ALONG = 0.25  # patches between points along an outline; BESIDE: margin around them that the outline may touch
BESIDE = 0.26
WHOLE = 1.0 - 1e-12


class Cover(NamedTuple):
    """Visibility of patches (rows, cols) of side 1, the first at (0, 0).

    whole : (rows, cols) mask of patches that are entirely visible
    cut   : (m, 2) row and column of patches that are partly visible
    start, end, owner : (n, 2) edges of the visible parts, relative to the patch's centre, and (n,) index into ``cut``;
                        inside where cross(end − start, x − start) > 0
    """

    whole: np.ndarray
    cut: I64
    start: F64
    end: F64
    owner: I64


def cover_of(outline: Rings, shape: tuple[int, int]) -> Cover:
    """Return the visibility of patches within a closed outline (start, end), in units of patches."""
    start, end = outline
    touched = _touched(start, end, shape)
    whole = _inside(start, end, shape) & ~touched
    cut = np.argwhere(touched)
    if not len(cut):
        return Cover(whole, cut, np.empty((0, 2)), np.empty((0, 2)), np.empty(0, np.int64))
    pieces, area = pieces_of(start, end, cut)
    full = area >= WHOLE
    whole[tuple(cut[full].T)] = True
    retained = ~full & (area > 1.0 - WHOLE)
    return Cover(whole, cut[retained], *edges_of(pieces[retained], cut[retained]))


def _touched(start: F64, end: F64, shape: tuple[int, int]) -> np.ndarray:
    """Return a mask (rows, cols) of the patches that the outline may cut."""
    low, high = shares_within(start, end, np.array([-1.0, -1.0]), np.array([shape[1] + 1.0, shape[0] + 1.0]))
    seen = high > low
    a, along, low, high = start[seen], (end - start)[seen], low[seen], high[seen]
    count = np.ceil((high - low) * np.hypot(*along.T) / ALONG).astype(np.int64) + 1
    owner = np.repeat(np.arange(len(a)), count)
    part = (np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count)) / np.maximum(count[owner] - 1, 1)
    place = a[owner] + (low[owner] + part * (high - low)[owner])[:, None] * along[owner]
    touched = np.zeros(shape, bool)
    for dx in (-BESIDE, BESIDE):
        for dy in (-BESIDE, BESIDE):
            col, row = np.floor(place[:, 0] + dx).astype(np.int64), np.floor(place[:, 1] + dy).astype(np.int64)
            within = (col >= 0) & (col < shape[1]) & (row >= 0) & (row < shape[0])
            touched[row[within], col[within]] = True
    return touched


def _inside(start: F64, end: F64, shape: tuple[int, int]) -> np.ndarray:
    """Return a mask (rows, cols) of the patches whose centre lies within the outline."""
    rows, cols = shape
    low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    first = np.clip(np.ceil(low - 0.5), 0, rows).astype(np.int64)
    stop = np.clip(np.ceil(high - 0.5), 0, rows).astype(np.int64)
    count = np.maximum(stop - first, 0)
    owner = np.repeat(np.arange(len(start)), count)
    row = first[owner] + np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count)
    part = (row + 0.5 - start[owner, 1]) / (end[owner, 1] - start[owner, 1])
    x = start[owner, 0] + part * (end[owner, 0] - start[owner, 0])
    crossings = np.zeros((rows, cols + 1), np.int64)
    np.add.at(crossings, (row, np.clip(np.ceil(x - 0.5), 0, cols).astype(np.int64)), 1)
    inside: np.ndarray = np.cumsum(crossings[:, :-1], axis=1) % 2 == 1
    return inside
