"""Photosites of a window from its frequencies: a transform back, or sums over each block of them as it is made.

Where photosites are few beside frequencies, as of a window seen from far scenery, sums take less, and no more is held
than a block: the photosites' own grid of frequencies, on which aliases meet, may be hundreds of megabytes a channel.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from camsim.arrays import F64
from camsim.rendering.fourier.blocks import Block, Place
from camsim.rendering.fourier.inverse import across_waves, down_waves, filled_in, inverse, seen
from camsim.rendering.fourier.tile import Tile


class Collected(Protocol):
    """What adds up blocks."""

    def room(self, block: Block) -> tuple[F64, Place]:
        """Return what a kernel adds a block to, (channels, rows, columns, 2), and where."""
        ...

    def take(self, block: Block, values: F64) -> None:
        """Take what was added to it."""
        ...

    def images(self) -> list[F64]:
        """Return the photosites (rows, cols) of each channel, once; what they came from is lost."""
        ...


def collected(tile: Tile, channels: int) -> Collected:
    """Return what takes the least."""
    return Singly(tile, channels) if tile.singly else OnGrid(tile, channels)


class OnGrid:
    """On the photosites' own grid of frequencies."""

    def __init__(self, tile: Tile, channels: int) -> None:
        self._tile = tile
        # Filled here: threads that touch fresh pages at once wait for one another.
        self._total = np.full((channels, *tile.sums, 2), 0.0)

    def room(self, block: Block) -> tuple[F64, Place]:
        """Return all of the grid."""
        return self._total, block.place(self._tile)

    def take(self, block: Block, values: F64) -> None:
        """It is there."""

    def images(self) -> list[F64]:
        """Transform back, one channel after the other."""
        return [inverse(own.view(complex)[..., 0], self._tile) for own in self._total]


class Singly:
    """Every photosite a sum of waves of its own."""

    def __init__(self, tile: Tile, channels: int) -> None:
        self._tile, self._found = tile, np.zeros((channels, *tile.coarse))

    def room(self, block: Block) -> tuple[F64, Place]:
        """Return a block by itself."""
        values = np.zeros((len(self._found), block.count_j, block.count_i, 2))
        return values, block.place(self._tile)._replace(column=0, row=0, rows=block.count_j)

    def take(self, block: Block, values: F64) -> None:
        """Add its waves to all photosites."""
        down = down_waves(self._tile, block.first_j + np.arange(block.count_j))
        across = across_waves(self._tile, block.column + np.arange(block.count_i))
        for found, own in zip(self._found, values.view(complex)[..., 0], strict=True):
            found += seen(down, own, across)

    def images(self) -> list[F64]:
        """Fill in what lies between."""
        return [filled_in(own, self._tile) for own in self._found]
