"""Bessel functions, Gauss's rules, lengths of transforms and outlines against mpmath and SciPy."""

import mpmath
import numpy as np
import pytest
import scipy.fft
from scipy.sparse import coo_array, csgraph

from camsim.numerics.bessel import FAR, bessel_j0_j1
from camsim.numerics.quadrature import gauss_legendre
from camsim.numerics.quintics import quintic_cells
from camsim.rendering.edges import Edges
from camsim.rendering.fast_length import fast_length
from camsim.rendering.prune import joined_outlines


def test_bessel_functions_are_right_to_rounding():
    ends = [0.0, 1e-300, 1e-8, FAR, np.nextafter(FAR, 99.0)]
    x = np.concatenate([ends, np.linspace(0.1, 40.0, 150), np.geomspace(40.0, 1e6, 60)])
    with mpmath.workdps(30):
        truth = [np.array([float(mpmath.besselj(order, mpmath.mpf(v))) for v in x]) for order in (0, 1)]
    size = 1.0 / np.sqrt(np.maximum(x, 1.0))
    for values, right in zip(bessel_j0_j1(x), truth, strict=True):
        assert np.abs((values - right) / size).max() < 6e-15
    small = x < 1.0
    assert bessel_j0_j1(x)[1][small] == pytest.approx(truth[1][small], rel=1e-15)
    assert bessel_j0_j1(x.reshape(5, -1))[1].shape == (5, len(x) // 5)


@pytest.mark.parametrize("order", [1, 2, 7, 60, 181, 400])
def test_gausss_rules_are_right_to_rounding(order):
    nodes, weights = gauss_legendre(order)
    with mpmath.workdps(40):
        for node, weight in list(zip(nodes, weights, strict=True))[:: max(1, order // 8)]:
            x = mpmath.mpf(node)
            for _ in range(3):  # Newton's steps from so near double the digits
                value = mpmath.legendre(order, x)
                slope = order * (mpmath.legendre(order - 1, x) - x * value) / (1 - x * x)
                x -= value / slope
            assert abs(float(x - node)) < 2e-16
            assert weight == pytest.approx(float(2 / ((1 - x * x) * slope**2)), rel=2e-13)
    assert (nodes == -nodes[::-1]).all()
    assert weights.sum() == pytest.approx(2.0, abs=2e-15)


def test_lengths_of_transforms_are_scipys():
    for least in [*range(1, 500), 4621, 99991, 1000003, 33554467]:
        for real in (False, True):
            assert fast_length(least, real=real) == scipy.fft.next_fast_len(least, real=real)


def test_edges_that_share_ends_are_one_outline():
    rng = np.random.default_rng(5)
    for most in rng.integers(1, 60, 50):
        a, b = rng.integers(0, most, (2, rng.integers(1, 60)))
        side = np.zeros(len(a), np.int64)
        edges = Edges(start=np.stack([a, a], 1) + 0.5, end=np.stack([b, b], 1) + 0.5, left=side, right=side)
        shared = coo_array((np.ones(len(a)), (a, b)), shape=(most, most))
        component = csgraph.connected_components(shared, directed=False)[1][a]
        outline, count = joined_outlines(edges)
        assert count == len(np.unique(component))
        assert count == len(np.unique(np.stack([component, outline]), axis=1).T)


def test_quintics_of_many_cells():
    """Right for waves as finely as was said, from one end of a cell to the other, whichever thread filled it."""
    waves = np.array([[0.02], [0.3]])
    place = np.arange(-2.0, 30_000.0)
    cells = quintic_cells(np.cos(waves * place))
    assert cells.shape == (2, place.size - 5, 6)
    begin = np.arange(place.size - 5.0)
    for t in (0.0, 0.4, 1.0):
        between = np.polynomial.polynomial.polyval(t, np.moveaxis(cells, -1, 0))
        off = np.abs(between - np.cos(waves * (begin + t))).max(axis=1)
        assert (off <= 5e-3 * waves.ravel() ** 6 + 1e-12).all()
