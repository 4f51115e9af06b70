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

    On a map of ``grain`` photosites a cell, every patch of touching cells is cut into bands from its top, and each band
    into windows from its left, where there is something: what a single corner marks is one window.

    >>> marked = np.zeros((12, 20), np.uint8)
    >>> marked[2:6, 3:6] = marked[9:11, 15:18] = 1
    >>> windows(marked, 2, 4)
    [Window(row=2, col=2, rows=4, cols=4), Window(row=8, col=14, rows=4, cols=4)]
    """
    rows, cols = marked.shape
    cells = np.zeros((-(-rows // grain), -(-cols // grain)), bool)
    for row in range(len(cells)):
        any_row = marked[row * grain : (row + 1) * grain].any(axis=0)
        cells[row] = np.logical_or.reduceat(any_row, np.arange(0, cols, grain))
    label, _ = scipy.ndimage.label(cells, structure=np.ones((3, 3)))
    found = []
    for number, (down, across) in enumerate(scipy.ndimage.find_objects(label), start=1):
        patch: Marks = np.equal(label[down, across], number)
        for row, col in _covered(patch, side // grain):
            first_row, first_col = (down.start + row) * grain, (across.start + col) * grain
            found.append(Window(first_row, first_col, min(side, rows - first_row), min(side, cols - first_col)))
    return found


def _covered(patch: Marks, side: int) -> Iterator[tuple[int, int]]:
    """Yield first row and column of squares that hold all cells of a patch."""
    row = 0
    while row < len(patch):
        band = patch[row : row + side]
        if not band[0].any():
            row += 1
            continue
        filled: Marks = np.logical_or.reduce(band, axis=0)
        col = 0
        while col < filled.size:
            if filled[col]:
                yield row, col
                col += side
            else:
                col += 1
        row += side
