"""From frequencies to photosites: whichever way is taken, the sum of waves itself."""

import dataclasses

import numpy as np
import pytest

from camsim.rendering.fourier.blocks import blocks
from camsim.rendering.fourier.inverse import inverse
from camsim.rendering.fourier.photosites import OnGrid, Singly
from camsim.rendering.fourier.tile import Tile

TILE = Tile(
    row=0, col=0, rows=30, cols=44, inner=(2.0, 2.0), outer=(4.0, 4.0), periods=(64, 50), cut=0.04, low=(0.0, 0.0),
    high=(43.0, 29.0),
)  # fmt: skip


@pytest.mark.parametrize(("cut", "one_by_one", "rows"), [(0.04, True, 5), (0.3, False, 31), (0.7, False, 50)])
def test_photosites_are_the_sum_of_all_waves(cut, one_by_one, rows):
    tile = dataclasses.replace(TILE, cut=cut)
    assert tile.one_by_one is one_by_one
    assert tile.sums[0] == rows
    px, py = tile.periods
    j, i = np.fft.fftfreq(tile.sums[0], 1.0 / tile.sums[0]), np.arange(tile.sums[1])
    rng = np.random.default_rng(2)
    values = rng.normal(size=tile.sums) + 1j * rng.normal(size=tile.sums)
    # What a real image has where i is 0, and where it is half of the period.
    for own in (0, *([px // 2] if tile.sums[1] > px // 2 else [])):
        mirrored = values[-np.arange(tile.sums[0]) % tile.sums[0], own].conj()
        values[:, own] = 0.5 * (values[:, own] + mirrored)
    twice = np.where((i > 0) & (2 * i < px), 2.0, 1.0)
    y, x = np.arange(tile.rows), np.arange(tile.cols)
    down, across = np.exp(2j * np.pi * np.outer(y, j) / py), np.exp(2j * np.pi * np.outer(i, x) / px)
    expected = (down @ (values * twice) @ across).real / (px * py)
    assert np.abs(inverse(values, tile) - expected).max() < 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("cut", [0.3, 0.7, 1.9])
def test_few_photosites_as_sums_over_blocks_or_from_their_grid(cut):
    """Aliases meet on the grid; as sums each block is seen by itself."""
    rng = np.random.default_rng(3)
    tile = dataclasses.replace(TILE, rows=2, cols=3, cut=cut)
    ways = [OnGrid(tile, 2), Singly(tile, 2)]
    for block in blocks(tile, 150):
        values = rng.normal(size=(2, block.count_j, block.count_i, 2))
        for way in ways:
            total, place = way.room(block)
            for j in range(block.count_j):
                row = (place.row + j) % place.rows
                total[:, row, place.column : place.column + block.count_i] += values[:, j]
            way.take(block, total)
    own, right = (np.array(way.images()) for way in (ways[1], ways[0]))
    assert np.abs(own - right).max() < 1e-12 * np.abs(right).max()
