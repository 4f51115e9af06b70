"""Which photosites see more of the difference than lines, and windows that hold all of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
import scipy

from camsim.arrays import U8

Marks: TypeAlias = npt.NDArray[np.bool_]


class Window(NamedTuple):
    """Rows and columns of photosites."""

    row: int
    col: int
    rows: int
    cols: int


def windows(marked: U8, grain: int, side: int) -> list[Window]:
    """Return windows of at most ``side`` photosites along a side that hold all photosites that are marked.

    On a map of ``grain`` photosites a cell, every patch of touching cells is cut into bands from its first marked row,
    and each band into windows from its first marked column on: what a single corner marks is one window.

    >>> marked = np.zeros((12, 20), np.uint8)
    >>> marked[2:6, 3:6] = marked[9:11, 15:18] = 1
    >>> windows(marked, 2, 4)
    [Window(row=2, col=3, rows=4, cols=3), Window(row=9, col=15, rows=2, cols=3)]
    """
    rows, cols = marked.shape
    cells = np.zeros((-(-rows // grain), -(-cols // grain)), bool)
    for row in range(len(cells)):
        any_row = marked[row * grain : (row + 1) * grain].any(axis=0)
        cells[row] = np.logical_or.reduceat(any_row, np.arange(0, cols, grain))
    label, _ = scipy.ndimage.label(cells, structure=np.ones((3, 3)))
    found = []
    for number, (down, across) in enumerate(scipy.ndimage.find_objects(label), start=1):
        patch: Marks = np.equal(label[down, across], number).repeat(grain, axis=0).repeat(grain, axis=1)
        own = marked[down.start * grain : down.stop * grain, across.start * grain : across.stop * grain]
        for window in _covered(patch[: own.shape[0], : own.shape[1]] & (own != 0), side):
            found.append(window._replace(row=down.start * grain + window.row, col=across.start * grain + window.col))
    return found


def _covered(marked: Marks, side: int) -> Iterator[Window]:
    """Yield windows that hold all marked photosites of a patch."""
    down: Marks = np.any(marked, axis=1)
    for row, rows in _pieces(down, side):
        across: Marks = np.any(marked[row : row + rows], axis=0)
        for col, cols in _pieces(across, side):
            yield Window(row, col, rows, cols)


def _pieces(filled: Marks, side: int) -> Iterator[tuple[int, int]]:
    """Yield first places and lengths of at most ``side`` that hold all that are filled, and begin and end with one."""
    places = np.flatnonzero(filled)
    while places.size:
        count = int(np.searchsorted(places, places[0] + side))
        yield int(places[0]), int(places[count - 1] - places[0] + 1)
        places = places[count:]
