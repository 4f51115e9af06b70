"""Bessel functions and Gauss's rules against mpmath."""

import mpmath
import numpy as np
import pytest
import scipy

from camsim.numerics.bessel import FAR, bessel_j0_j1
from camsim.numerics.bessel_kernels import FAR as FAR_OF_ORDERS
from camsim.numerics.bessel_kernels import HANKEL, bessel_downwards, bessel_upwards
from camsim.numerics.quadrature import gauss_legendre


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


@pytest.mark.parametrize("first", [0.0, FAR_OF_ORDERS, 300.0])
def test_bessel_functions_of_all_orders_and_their_integrals(first):
    x, most = first + 0.37 * np.arange(40), 18
    j, integral, some = np.zeros((most + 2, 64)), np.zeros((most + 2, 64)), np.zeros((8, 64))
    orders, begin, end = np.arange(most), np.uint64(0), np.uint64(40)
    right = scipy.special.jv(orders[:, None], x)
    # ∫ J_m(t) t dt, by parts of one radian.
    nodes, weights = gauss_legendre(24)
    ends = np.concatenate([np.arange(0.0, first, 1.0), x])
    half, middle = 0.5 * np.diff(ends, prepend=0.0), 0.5 * (ends + np.concatenate([[0.0], ends[:-1]]))
    t = middle[:, None] + half[:, None] * nodes
    parts = np.einsum("mkn,kn->mk", scipy.special.jv(orders[:, None, None], t), t * (half[:, None] * weights))
    of_right = np.cumsum(parts, axis=1)[:, -40:]
    bessel_downwards(2.0, 0.5 * x, end, j, integral, some)
    assert j[:most, :40] == pytest.approx(right, abs=1e-13)
    assert integral[:most, :40] == pytest.approx(of_right, abs=1e-11)
    if first:
        bessel_upwards(2.0, 0.5 * x, begin, end, HANKEL, j, integral, some)
        assert j[:most, :40] == pytest.approx(right, abs=1e-12)
        assert integral[:most:2, :40] == pytest.approx(of_right[::2], abs=1e-10)
