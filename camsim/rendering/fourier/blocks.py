"""A window's frequencies block by block: what stays in a cache."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from camsim.arrays import C128
from camsim.rendering.fourier.tile import Tile


class Place(NamedTuple):
    """A block as the kernels read it: its frequencies (i/px, j/py), and where their sums go on the photosites' grid.

    column, row : of the first;  rows: of that grid, which go round
    """

    first_i: int
    first_j: int
    count_i: int
    count_j: int
    px: int
    py: int
    cut: float
    column: int
    row: int
    rows: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Neighbouring frequencies (i/Px, j/Py), all in one alias of the half plane 0 … Px/2.

    first_i, count_i : of i;  first_j, count_j: of j
    column           : where the first of them falls on the photosites' own grid of frequencies
    """

    first_i: int
    count_i: int
    first_j: int
    count_j: int
    column: int

    def place(self, tile: Tile) -> Place:
        """Return what the kernels read."""
        px, py = tile.periods
        rows = tile.sums[0]
        row = self.first_j % rows
        return Place(self.first_i, self.first_j, self.count_i, self.count_j, px, py, tile.cut, self.column, row, rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class Strip:
    """Rows of the half plane i ≥ 0 from its left side to the band's end, whatever aliases they are in.

    first_j, count_j : of j;  count_i: of i, from 0 on
    """

    first_j: int
    count_j: int
    count_i: int

    @property
    def points(self) -> int:
        """Frequencies that are spread to."""
        return self.count_j * self.count_i

    def blocks(self, tile: Tile, most: int) -> Iterator[Block]:
        """Cut into blocks of one alias, of at most about ``most`` frequencies; those of i < 0 are mirrored."""
        px = tile.periods[0]
        last_i = self.count_i - 1
        for p in range(-(last_i // px) - 1, last_i // px + 1):
            first_i, stop_i = max(p * px, -last_i), min(p * px + px // 2, last_i) + 1
            if first_i >= stop_i:
                continue
            low = self.first_j if p >= 0 else 1 - self.first_j - self.count_j
            band = _rows_of_block(most, stop_i - first_i)
            for first_j in range(low, low + self.count_j, band):
                yield Block(
                    first_i=first_i,
                    count_i=stop_i - first_i,
                    first_j=first_j,
                    count_j=min(band, low + self.count_j - first_j),
                    column=first_i - p * px,
                )

    def part(self, values: C128, block: Block) -> C128:
        """Return a block (count_j, count_i) of a real function's transform from the strip's ``values``."""
        if block.first_i >= 0:
            row = block.first_j - self.first_j
            return values[row : row + block.count_j, block.first_i : block.first_i + block.count_i]
        row, column = -block.first_j - self.first_j, -block.first_i
        turned = values[row - block.count_j + 1 : row + 1, column - block.count_i + 1 : column + 1]
        return turned[::-1, ::-1].conj()


def count_strips(tile: Tile, most: int, fewest: int) -> tuple[int, float]:
    """Return how many strips there are, and about how many frequencies in all of them."""
    rows, widest = 2 * math.floor(tile.ends[1] * tile.periods[1]) + 1, math.floor(tile.ends[0] * tile.periods[0]) + 1
    count = min(rows, max(fewest, -(-rows * widest // most)))
    # Each row of a strip is as long as its longest.
    return count, min(rows * widest, tile.points + rows * widest / count)


def strips(tile: Tile, most: int, fewest: int = 1) -> list[Strip]:
    """Cut the half plane i ≥ 0 into strips of at most about ``most`` frequencies, the same number of rows in each.

    >>> tile = Tile(row=0, col=0, rows=1, cols=1, inner=(2.0, 2.0), outer=(4.0, 4.0), periods=(12, 10), cut=1.7,
    ...             low=(0.0, 0.0), high=(1.0, 1.0))
    >>> [(strip.first_j, strip.count_j, strip.count_i) for strip in strips(tile, 300)]
    [(-17, 12, 20), (-5, 11, 21), (6, 12, 20)]
    >>> [(strip.first_j, strip.count_j, strip.count_i) for strip in strips(tile, 1000, fewest=2)]
    [(-17, 18, 21), (1, 17, 21)]
    """
    px, py = tile.periods
    high, widest = math.floor(tile.ends[1] * py), math.floor(tile.ends[0] * px) + 1
    rows, found = 2 * high + 1, []
    count = min(rows, max(fewest, -(-rows * widest // most)))
    for k in range(count):
        first, stop = round(k * rows / count) - high, round((k + 1) * rows / count) - high
        nearest = max(first, 1 - stop, 0)
        last_i = math.floor(px * math.sqrt(max(tile.cut**2 - (nearest / py) ** 2, 0.0)))
        found.append(Strip(first_j=first, count_j=stop - first, count_i=min(last_i + 1, widest)))
    return found


def _aliases(tile: Tile) -> Iterator[tuple[int, int, int, int]]:
    """Yield the band's aliases of the half plane 0 … Px/2: number, first and last i, and the largest |j| in them."""
    px, py = tile.periods
    half = px // 2 + 1
    furthest_i, furthest_j = math.floor(tile.ends[0] * px), math.floor(tile.ends[1] * py)
    for p in range(-(furthest_i // px) - 1, furthest_i // px + 1):
        first_i, last_i = max(p * px, -furthest_i), min(p * px + half - 1, furthest_i)
        if first_i > last_i:
            continue
        nearest = 0 if first_i <= 0 <= last_i else min(abs(first_i), abs(last_i))
        high = math.floor(py * math.sqrt(max(tile.cut**2 - (nearest / px) ** 2, 0.0)))
        yield p, first_i, last_i, min(high, furthest_j)


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
    px = tile.periods[0]
    for p, first_i, last_i, high in _aliases(tile):
        band = _rows_of_block(most, last_i - first_i + 1)
        for first_j in range(-high, high + 1, band):
            yield Block(
                first_i=first_i,
                count_i=last_i - first_i + 1,
                first_j=first_j,
                count_j=min(band, high + 1 - first_j),
                column=first_i - p * px,
            )
