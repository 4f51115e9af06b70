"""Windows of the frame as they are transformed, and their frequencies block by block: what stays in a cache."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True, kw_only=True)
class Tile:
    """A window of the frame and how it is transformed; lengths in pitches.

    row, col, rows, cols : the window
    inner, outer : radii of a round taper; of a square one half its sides along x (``inner_y`` and so on along y)
    periods      : along x and y, whole
    cut          : highest frequency kept, cycles/pitch
    low, high    : corners of what the scene is clamped to, from the tile's first photosite
    """

    row: int
    col: int
    rows: int
    cols: int
    inner: tuple[float, float]
    outer: tuple[float, float]
    periods: tuple[int, int]
    cut: float
    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def points(self) -> float:
        """Frequencies that are computed: half of those within the band, the others are their mirror images."""
        return 0.5 * math.pi * self.cut**2 * self.periods[0] * self.periods[1]


class Place(NamedTuple):
    """A block as the kernels read it: its frequencies (i/px, j/py), and where their sums go on the photosites' grid."""

    first_i: int
    first_j: int
    count_i: int
    count_j: int
    px: int
    py: int
    cut: float
    column: int
    row: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Neighbouring frequencies (i/Px, j/Py), all in one alias of the half plane 0 … Px/2.

    first_i, count_i : of i;  first_j, count_j: of j
    column, row      : where the first of them falls on the photosites' own grid of frequencies (rows go round)
    """

    first_i: int
    count_i: int
    first_j: int
    count_j: int
    column: int
    row: int

    def place(self, tile: Tile) -> Place:
        """Return what the kernels read."""
        px, py = tile.periods
        return Place(self.first_i, self.first_j, self.count_i, self.count_j, px, py, tile.cut, self.column, self.row)


def _aliases(tile: Tile) -> Iterator[tuple[int, int, int, int]]:
    """Yield the band's aliases of the half plane 0 … Px/2: number, first and last i, and the largest |j| in them."""
    px, py = tile.periods
    half = px // 2 + 1
    furthest_i = math.floor(tile.cut * px)
    for p in range(-(furthest_i // px) - 1, furthest_i // px + 1):
        first_i, last_i = max(p * px, -furthest_i), min(p * px + half - 1, furthest_i)
        if first_i > last_i:
            continue
        nearest = 0 if first_i <= 0 <= last_i else min(abs(first_i), abs(last_i))
        yield p, first_i, last_i, math.floor(py * math.sqrt(max(tile.cut**2 - (nearest / px) ** 2, 0.0)))


def _rows_of_block(most: int, columns: int) -> int:
    return max(1, most // columns)


def count_blocks(tile: Tile, most: int) -> tuple[int, int]:
    """Return how many blocks ``blocks`` yields, and their rows together: without them, which may be 10⁸.

    >>> tile = Tile(row=0, col=0, rows=1, cols=1, inner=(2.0, 2.0), outer=(4.0, 4.0), periods=(12, 10), cut=1.7,
    ...             low=(0.0, 0.0), high=(1.0, 1.0))
    >>> cut = list(blocks(tile, 20))
    >>> count_blocks(tile, 20) == (len(cut), sum(block.count_j for block in cut))
    True
    """
    count = rows = 0
    for _, first_i, last_i, high in _aliases(tile):
        count += -(-(2 * high + 1) // _rows_of_block(most, last_i - first_i + 1))
        rows += 2 * high + 1
    return count, rows


def blocks(tile: Tile, most: int) -> Iterator[Block]:
    """Cut the band into blocks of at most about ``most`` frequencies."""
    px, py = tile.periods
    for p, first_i, last_i, high in _aliases(tile):
        band = _rows_of_block(most, last_i - first_i + 1)
        for first_j in range(-high, high + 1, band):
            yield Block(
                first_i=first_i,
                count_i=last_i - first_i + 1,
                first_j=first_j,
                count_j=min(band, high + 1 - first_j),
                column=first_i - p * px,
                row=first_j % py,
            )
