"""Tiled arrays: a small array repeated periodically, without storing the whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from camsim.core.arrays import F64, U8


@dataclass(frozen=True, slots=True, eq=False)
class Tiled:
    """A small array (p, q) repeated over (rows, cols), of which only the parts requested are created.

    >>> index = Tiled(np.array([[0, 1], [1, 2]], np.uint8), (3, 5))
    >>> index[1:]
    array([[1, 2, 1, 2, 1],
           [0, 1, 0, 1, 0]], dtype=uint8)
    >>> index[np.array([0, 2]), np.array([1, 2])], len(index)
    (array([1, 0], dtype=uint8), 3)
    """

    period: U8
    shape: tuple[int, int]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, place: Any) -> U8:
        rows, cols = place[-2:] if isinstance(place, tuple) else (place, slice(None))
        row = np.arange(self.shape[0])[rows] % self.period.shape[0]
        col = np.arange(self.shape[1])[cols] % self.period.shape[1]
        if not (isinstance(rows, slice) and isinstance(cols, slice)):
            found: U8 = self.period[row, col]
            return found
        count = len(self.period)
        some = self.period[row[:count, None], col]
        found = np.empty((row.size, col.size), np.uint8)
        for k, one in enumerate(some):  # ten times as fast as a gather
            found[k::count] = one
        return found


Channels: TypeAlias = U8 | Tiled
"""The channel of each photosite, (rows, cols); ``[:]`` makes it an array."""


def multiply(rows: F64, channel: Channels, first: int, values: F64, out: F64) -> None:
    """Write rows of a frame from its row ``first`` on, each photosite multiplied by the value of its channel.

    out : array for the result, of the same shape as the rows; may be the rows themselves

    >>> rows = np.ones((2, 3))
    >>> multiply(rows, Tiled(np.array([[0, 1], [1, 2]], np.uint8), (9, 3)), 1, np.array([2.0, 3.0, 4.0]), rows)
    >>> rows
    array([[3., 4., 3.],
           [2., 3., 2.]])
    """
    if values.size == 1:
        if values[0] != 1.0 or out is not rows:
            np.multiply(rows, values[0], out=out)
        return
    if not isinstance(channel, Tiled):
        np.multiply(rows, values[channel[first : first + len(rows)]], out=out)
        return
    period = len(channel.period)
    for row in range(min(period, len(rows))):  # eight times as fast as a gather
        np.multiply(rows[row::period], values[channel[first + row : first + row + 1]], out=out[row::period])
