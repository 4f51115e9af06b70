"""A window's transform on the photosites' own grid of frequencies, against sums over all frequencies one by one."""

import numpy as np
import pytest

from camsim.rendering.aberrated.window_kernels import COLUMNS, Table, add_edges, add_strip
from camsim.rendering.aberrated.windows import windows
from camsim.rendering.edges import corners_of
from camsim.rendering.fourier.blocks import Place, strips
from camsim.rendering.fourier.edge_transforms import Corners, turn_across
from camsim.rendering.fourier.inverse import inverse
from camsim.rendering.fourier.tile import Tile

SPECTRA, CHANNELS, SETS = 2, 2, 3


def outlines(rng, period):
    """A polygon with sides along both axes, and a triangle over it of another spectrum: (start, end, jump)."""
    first = period * np.array([(0.1, 0.2), (0.7, 0.2), (0.7, 0.5), (0.4, 0.8), (0.1, 0.8)])
    second = period * rng.uniform(0.1, 0.9, (3, 2))
    corners = [(first, (1.0, 0.0)), (second, (-0.3, 0.7))]
    start = np.concatenate([own for own, _ in corners])
    end = np.concatenate([np.roll(own, -1, axis=0) for own, _ in corners])
    return start, end, np.concatenate([np.tile(jump, (len(own), 1)) for own, jump in corners])


def transforms(start, end, jump, fx, fy):
    """4π²|k|² times the regions' transforms (spectra, places), and their areas: by Green's theorem, edge by edge."""
    along, middle = end - start, 0.5 * (start + end)
    wave = np.exp(-2j * np.pi * (np.multiply.outer(fx, middle[:, 0]) + np.multiply.outer(fy, middle[:, 1])))
    across = np.multiply.outer(fx, along[:, 1]) - np.multiply.outer(fy, along[:, 0])
    sinc = np.sinc(np.multiply.outer(fx, along[:, 0]) + np.multiply.outer(fy, along[:, 1]))
    area = 0.5 * (start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]) @ jump
    return np.einsum("fe,es->sf", 2j * np.pi * across * wave * sinc, jump), area


@pytest.mark.parametrize(("period", "cut"), [(12, 1.7), (15, 2.3), (16, 2.03), (9, 0.9), (24, 0.2), (64, 0.31)])
@pytest.mark.parametrize("by_edges", [True, False])
def test_a_window_is_the_sum_of_all_its_frequencies(period, cut, by_edges):
    rng = np.random.default_rng(period)
    count = int(cut * period) + 1
    tile = Tile.square((0, 0, 7, 5), inner=2.0, outer=3.0, period=period, cut=cut, near=2.0)
    start, end, jump = outlines(rng, period)
    j, i = (part.ravel() for part in np.mgrid[1 - count : count, 1 - count : count])
    inside = np.hypot(i, j) < cut * period
    i, j = i[inside], j[inside]
    # Transfers of real patterns: at −k the conjugate.
    shape = SETS, 2 * count - 1, 2 * count - 1
    half = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    lens = half + half[:, ::-1, ::-1].conj()
    fields = np.zeros((SETS, 2, count, 2, COLUMNS * (1 + count // COLUMNS)))
    for side, rows in ((0, lens[:, count - 1 :]), (1, lens[:, count - 1 :: -1])):
        fields[:, side, :, 0, :count], fields[:, side, :, 1, :count] = (
            rows[..., count - 1 :].real,
            rows[..., count - 1 :].imag,
        )
    weights = rng.normal(size=(SPECTRA, CHANNELS, SETS))
    scene, areas = transforms(start, end, jump, i / period, j / period)
    scene[:, (i == 0) & (j == 0)] = areas[:, None]
    every = np.einsum("skb,sf,bf->kf", weights, scene, lens[:, j + count - 1, i + count - 1])
    y, x = np.mgrid[:7, :5]
    wave = np.exp(2j * np.pi * (np.multiply.outer(y, j) + np.multiply.outer(x, i)) / period)
    right = np.einsum("kf,rcf->krc", every, wave).real / period**2

    table, total = Table(fields, weights, areas, period, cut), np.zeros((CHANNELS, 2, *tile.sums))
    targets = total.shape[2] // 2 + 1
    for first, stop in ((0, targets // 3), (targets // 3, targets)):  # as threads share them
        if by_edges:
            corners = Corners(*corners_of(start, end), jump)
            across = np.empty((2, len(corners.points), fields.shape[4]))
            turn_across(
                Place(0, 0, fields.shape[4], 1, period, period, cut, 0, 0, 1), corners.points, across, 0, len(across[0])
            )
            add_edges(total, table, corners, across, first, stop)
            continue
        for strip in strips(tile, 40, fewest=2):
            down, along = np.mgrid[strip.first_j : strip.first_j + strip.count_j, : strip.count_i] / period
            own = transforms(start, end, jump, along.ravel(), down.ravel())[0]
            add_strip(total, table, strip.first_j, own.reshape(SPECTRA, *along.shape), first, stop)
    found = np.stack([inverse(real + 1j * imaginary, tile) for real, imaginary in total])
    assert np.abs(found - right).max() < 1e-11 * np.abs(right).max()


def test_windows_hold_all_that_is_marked_and_no_more():
    rng = np.random.default_rng(5)
    for _ in range(30):
        marked = (rng.random((40, 53)) < rng.choice([0.002, 0.02, 0.3])).astype(np.uint8)
        held = np.zeros_like(marked)
        for row, col, rows, cols in windows(marked, 3, 11):
            own = marked[row : row + rows, col : col + cols]
            assert own.shape == (rows, cols)
            assert max(rows, cols) <= 11
            assert own[:, 0].any()
            assert own[:, -1].any()
            held[row : row + rows, col : col + cols] = 1
        assert (held >= marked).all()
