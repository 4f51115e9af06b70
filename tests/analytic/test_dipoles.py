"""Short edges from afar as two dipoles each: against dense quadrature over the edges, and what the bound says."""

import numpy as np
import pytest

from camsim.rendering.boundary.dipole import GAUSS, dipole_at_points, longest_dipoles
from camsim.rendering.boundary.far import Moments
from tests.truth.closed_forms import edges_by_quadrature

POWERS = (0.2, 0.04, -0.01)
SQUARE = np.array([(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)])
LOPSIDED = np.array([(-0.7, -0.2), (0.7, 0.2), (-0.1, 0.4), (0.1, -0.4)])


def moments(spots):
    z = spots[:, 0] + 1j * spots[:, 1]
    harmonic = (complex(np.mean(v)) for v in (z**2, z**3 * z.conj(), z**4, z**6))
    return Moments(float(0.5 * np.mean(np.abs(z) ** 2)), float(np.mean(np.abs(z) ** 4)), *harmonic)


def by_two_nodes(points, start, end, spots):
    far = np.array([1.0, *POWERS]) / (2 * np.pi)
    total, sends = np.zeros(len(points)), np.empty((8, len(points)))
    for a, b in zip(start, end, strict=True):
        for side in (-GAUSS, GAUSS):
            x, y = a + (0.5 + side) * (b - a)
            dipole_at_points(x, y, points[:, 0].copy(), points[:, 1].copy(), moments(spots), sends)
            dx, dy = 0.5 * (b - a)
            total += far @ (dx * sends[0::2] + dy * sends[1::2])
    return total


@pytest.mark.parametrize("spots", [SQUARE, LOPSIDED], ids=["square", "lopsided"])
def test_a_dipole_is_a_very_short_edge(spots):
    rng = np.random.default_rng(1)
    start = rng.uniform(-1, 1, (6, 2))
    end = start + rng.normal(size=(6, 2)) * 1e-2
    points = np.array([(40.0, 0.0), (-30.0, 28.0), (6.0, -50.0)])
    expected = [edges_by_quadrature(point, start, end, spots, POWERS) for point in points]
    assert np.abs(by_two_nodes(points, start, end, spots) - expected).max() < 1e-10


@pytest.mark.parametrize("allowed", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("bend", [0.0, 0.02])
def test_a_line_of_edges_that_passes_by_keeps_what_is_allowed(allowed, bend):
    """Straight and round a centre; the far form's powers are there, its moments are another's affair."""
    near = 5.0
    length = longest_dipoles(near, allowed)
    along = np.arange(-60.0, 60.0 + length, length)
    corners = np.stack([along, near + 0.5 * bend * along**2], axis=1)
    point, spot = np.zeros((1, 2)), np.zeros((1, 2))
    lost = by_two_nodes(point, corners[:-1], corners[1:], spot)[0] - edges_by_quadrature(
        point[0], corners[:-1], corners[1:], spot, POWERS
    )
    assert abs(lost) < allowed


def test_one_edge_loses_nearly_what_the_bound_is_made_of():
    near, length = 5.0, 2.0
    start, end = np.array([[-0.5 * length, near]]), np.array([[0.5 * length, near]])
    point, spot = np.zeros((1, 2)), np.zeros((1, 2))
    far_only = np.array([1.0, 0.0, 0.0, 0.0])
    sends = np.empty((8, 1))
    angle = 0.0
    for side in (-GAUSS, GAUSS):
        dipole_at_points(side * length, near, np.zeros(1), np.zeros(1), moments(spot), sends)
        angle += float(far_only @ (0.5 * length * sends[0::2, 0]))
    exact = edges_by_quadrature(point[0], start, end, spot, (0.0, 0.0, 0.0)) * 2 * np.pi
    u = 0.5 * length / near
    assert abs(abs(angle - exact) / (8 / 45 * u**5) - 1.0) < 0.1
