"""Squares of sums of plane waves on lattices, spread once: against the sums themselves."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest

from camsim.gridded import grid, held_bytes, is_large, power_rows, powers, sums
from camsim.rendering.fourier.patterns import FEWEST_SAMPLES, rows_at_once

BANDS = [(1.0, 0.7), (1.55, 0.3), (2.9, 1.0), (0.01, 1.54)]  # whole grids and half ones, along one axis or both


@pytest.fixture(autouse=True)
def every_lattice(monkeypatch):
    monkeypatch.setattr(grid, "SMALL", 0)
    monkeypatch.setattr(powers, "AT_ONCE", 3000)  # several strips of each


def all_powers(points, shape, bands, precision, **how):
    """All rows, each of which must come once."""
    found = np.full(shape, np.nan)
    for rows, some in power_rows(points, tuple, shape, bands, precision, **how):
        assert np.isnan(found[rows]).all()
        found[rows] = some
    assert not np.isnan(found).any()
    return found


def points(rng, bands, count=300):
    y, x = (rng.uniform(-band, band, count) for band in bands)
    return y, x, rng.standard_normal(count) + 1j * rng.standard_normal(count)


def directly(y, x, strengths, shape):
    rows, columns = (np.arange(size) - size // 2 for size in shape)
    return (np.exp(-1j * np.outer(rows, y)) * strengths) @ np.exp(-1j * np.outer(x, columns))


@pytest.mark.parametrize("bands", BANDS, ids=str)
@pytest.mark.parametrize("shape", [(1, 1), (2, 301), (160, 97), (401, 400)], ids=str)
@pytest.mark.parametrize("precision", [1e-3, 1e-6, 1e-9, 1e-11, 1e-14])
def test_squares_of_sums(rng, bands, shape, precision):
    y, x, strengths = points(rng, bands)
    exact = np.abs(directly(y, x, strengths, shape))
    parts = [(y[some], x[some], strengths[some]) for some in (slice(0, 90), slice(90, None))]
    found = np.sqrt(all_powers(parts, shape, bands, precision))
    assert np.abs(found - exact).max() <= max(2.0 * precision, 3e-15) * np.abs(strengths).sum()


@pytest.mark.parametrize("shape", [(161, 97), (160, 97), (401, 400)], ids=str)
def test_of_opposite_points_one_is_enough(rng, shape):
    y, x, strengths = points(rng, (1.5, 0.9))
    y[0] = x[0] = 0.0  # its own opposite, which is given by half
    strengths[0] *= 0.5
    exact = np.abs(directly(y, x, strengths, shape) + directly(-y, -x, strengths, shape))
    found = np.sqrt(all_powers([(y, x, strengths)], shape, (1.5, 0.9), 1e-13, half=True))
    assert np.abs(found - exact).max() <= 1e-13 * np.abs(strengths).sum()


def test_parts_that_lie_together_are_spread_to_few_cells(rng, monkeypatch):
    cells = []
    spread = grid.spread
    monkeypatch.setattr(grid, "spread", lambda p, s, size, **how: cells.append(size) or spread(p, s, size, **how))
    y, x, strengths = points(rng, (0.1, 0.1))
    moved = y + 1.0, x - 0.5, strengths
    found = np.sqrt(all_powers([moved], (300, 300), (1.5, 1.5), 1e-9))
    assert max(cells[0]) < 100
    assert np.abs(found - np.abs(directly(*moved, (300, 300)))).max() <= 2e-9 * np.abs(strengths).sum()


def test_small_lattices_are_left_to_finufft(rng, monkeypatch):
    monkeypatch.setattr(grid, "SMALL", 1000)
    assert is_large((40, 25))
    assert not is_large((40, 24))
    y, x, strengths = points(rng, (1.5, 1.5))
    exact = np.abs(directly(y, x, strengths, (40, 24))) ** 2
    np.testing.assert_allclose(
        all_powers([(y, x, strengths)], (40, 24), (1.5, 1.5), 1e-12), exact, atol=1e-9 * exact.max()
    )


@pytest.mark.parametrize("middle", [(0.0, 0.0), (0.4, -1.2), (2.9, 3.1), (-3.0, 0.1)], ids=str)
@pytest.mark.parametrize("extent", [0.01, 0.7, 1.5, 3.0])
@pytest.mark.parametrize("shape", [(1, 1), (2, 301), (160, 97), (401, 400)], ids=str)
@pytest.mark.parametrize("precision", [1e-3, 1e-9, 1e-13])
def test_sums(rng, shape, extent, middle, precision):
    """Wherever points lie: in a corner of the grid, all round, or beyond its ends."""
    y, x, strengths = points(rng, (extent, extent))
    y, x = y + middle[0], x + middle[1]
    times = [np.exp(1j * rng.uniform(0.0, 6.0, size)) * rng.uniform(0.5, 1.0, size) for size in shape]
    exact = directly(y, x, strengths, shape) * times[0][:, None] * times[1]
    found = sums(y, x, strengths, shape, (times[0], times[1]), precision)
    assert np.abs(found - exact).max() <= max(2.0 * precision, 3e-15) * np.abs(strengths).sum()


@pytest.mark.parametrize("precision", [1e-6, 1e-10, 1e-13])
@pytest.mark.parametrize("shape", [(1001, 2501), (150, 9001), (3001, 1501)], ids=str)
def test_what_is_held_is_what_is_told(rng, monkeypatch, shape, precision):
    monkeypatch.setattr(powers, "AT_ONCE", 50_000)
    bands = (powers.JUST_RAD,) * 2
    y, x, strengths = points(rng, bands)
    arrays, down = [], powers._down

    def counted(cells, *how):
        lines = down(cells, *how)
        arrays.append(cells.nbytes + lines.nbytes)
        return lines

    monkeypatch.setattr(powers, "_down", counted)
    # Arrays are counted, not what the process holds: the collector takes finufft's when it likes.
    strips = max(some.nbytes for _, some in power_rows([(y, x, strengths)], tuple, shape, bands, precision))
    assert 0.6 < (max(arrays) + 3 * strips) / held_bytes(shape, precision) < 1.1


@pytest.mark.parametrize("pattern", [(100, 100), (5000, 5000), (40_000, 40_000), (10**9, 10**9), (3, 10**8)], ids=str)
@pytest.mark.parametrize("spare_bytes", [1e9, -1.0])
def test_as_many_rows_as_fit_are_made_at_a_time(pattern, spare_bytes):
    taken = functools.partial(held_bytes, precision=1e-9)
    rows, (all_rows, columns) = rows_at_once(SimpleNamespace(pattern_bytes=taken), pattern, spare_bytes), pattern
    assert rows == all_rows or taken((rows, columns)) <= spare_bytes or rows * columns <= FEWEST_SAMPLES + columns
    strips = -(-all_rows // rows)
    if strips > 1 and (fewer := -(-all_rows // (strips - 1))) * columns > FEWEST_SAMPLES + columns:
        assert taken((fewer, columns)) > spare_bytes
