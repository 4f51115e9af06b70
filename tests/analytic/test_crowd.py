"""Cells of many edges and the far form at many points: against quadrature over every edge, and as whole images."""

import numpy as np
import pytest

import camsim
from camsim.rendering.boundary.crowd import FEWEST, cell_at_points, gather
from camsim.rendering.boundary.far import Moments
from camsim.rendering.edges import Edges
from tests.truth.closed_forms import edges_by_quadrature

C1, C3, C5 = 0.2, 0.04, -0.01
SPOTS = np.array([(-0.7, -0.2), (0.7, 0.2), (-0.1, 0.4), (0.1, -0.4)])  # of a lopsided footprint, even about its centre


def outlines(rng, count, size):
    """Edges of squares strewn over a square of ``size``, (n, 2) starts and ends."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.4
    centres = rng.uniform(-0.5, 0.5, (count, 2)) * size
    turns = rng.uniform(0, 2 * np.pi, count)
    spin = np.array([[np.cos(turns), np.sin(turns)], [-np.sin(turns), np.cos(turns)]]).transpose(2, 0, 1)
    points = corners @ spin + centres[:, None]
    return points.reshape(-1, 2), np.roll(points, -1, axis=1).reshape(-1, 2)


def of(start, end):
    nobody = np.zeros(len(start), np.int64)
    return Edges(start=start, end=end, left=nobody, right=nobody)


def moments(spots=SPOTS):
    z = spots[:, 0] + 1j * spots[:, 1]
    harmonic = (complex(np.mean(v)) for v in (z**2, z**3 * z.conj(), z**4, z**6))
    return Moments(float(0.5 * np.mean(np.abs(z) ** 2)), float(np.mean(np.abs(z) ** 4)), *harmonic)


@pytest.mark.parametrize(("nodes", "allowed"), [(6, 3e-4), (10, 1e-6), (14, 3e-7)])
def test_a_cell_sends_what_its_edges_send(nodes, allowed):
    start, end = outlines(np.random.default_rng(5), 200, 12.0)
    far = np.array([1.0, C1, C3, C5])[None, None] / (2 * np.pi)
    order, cells = gather(of(start, end), np.zeros(len(start), np.int64), far, nodes)
    assert sorted(order) == list(range(len(start)))
    assert cells.x.size > 4
    points = np.array([(20.0, 0.0), (-15.0, 14.0), (3.0, -25.0)])
    total = np.zeros((1, len(points)))
    cell_at_points(
        0, 1.0, 2.0, points[:, 0] - 1.0, points[:, 1] - 2.0, moments(), cells, np.empty((8, len(points))), total
    )
    expected = [edges_by_quadrature(point, start, end, SPOTS, (C1, C3, C5)) for point in points]
    assert np.abs(total[0] - expected).max() < allowed


def test_of_a_wide_footprint_moments_up_to_the_sixth_count():
    """Of the angle alone, under sides of which no outline is whole: that would be 0 whatever the moments."""
    start, end = (ends[::3] for ends in outlines(np.random.default_rng(5), 200, 6.0))
    far = np.array([1.0, 0.0, 0.0, 0.0])[None, None] / (2 * np.pi)
    _, cells = gather(of(start, end), np.zeros(len(start), np.int64), far, 14)
    points = np.array([(16.0, 0.0), (-12.0, 11.0), (3.0, -16.0)])
    total = np.zeros((1, len(points)))
    spots = 2.0 * SPOTS
    cell_at_points(0, 0.0, 0.0, points[:, 0], points[:, 1], moments(spots), cells, np.empty((8, len(points))), total)
    expected = [edges_by_quadrature(point, start, end, spots, (0.0, 0.0, 0.0)) for point in points]
    assert np.abs(total[0] - expected).max() < 1e-8  # the eighth's


def test_every_edge_is_in_one_cell_and_within_its_box():
    rng = np.random.default_rng(6)
    start = rng.normal(size=(3000, 2)) * 50
    end = start + rng.normal(size=start.shape) * 10 ** rng.uniform(-3, 2, (3000, 1))
    order, cells = gather(of(start, end), np.zeros(3000, np.int64), np.ones((1, 1, 4)), 4)
    assert cells.first_edge[-1] == 3000
    one = np.repeat(np.arange(cells.x.size), np.diff(cells.first_edge))
    for points in (start[order], end[order]):
        assert np.all(np.abs(points[:, 0] - cells.x[one]) <= cells.half_x[one] * (1 + 1e-12) + 1e-12)
        assert np.all(np.abs(points[:, 1] - cells.y[one]) <= cells.half_y[one] * (1 + 1e-12) + 1e-12)
    children = np.concatenate(
        [np.arange(a, b) for a, b in zip(cells.first_child[:-1], cells.first_child[1:], strict=True)]
    )
    assert sorted(children) == list(range(1, cells.x.size))


def test_a_handful_of_edges_has_no_cells():
    start, end = outlines(np.random.default_rng(7), (FEWEST - 1) // 4, 12.0)
    order, cells = gather(of(start, end), np.zeros(len(start), np.int64), np.ones((1, 1, 4)), 4)
    assert cells.x.size == 0
    assert list(order) == list(range(len(start)))


@pytest.mark.parametrize(
    "olpf", [[], [camsim.FourSpotOlpf(split_um=3.0, split_y_um=1.0, rotate_deg=20.0)]], ids=["square", "lopsided"]
)
def test_crowds_equal_the_fourier_engine(olpf):
    """Two greys, so that cells carry pairs of spectra; more than half of the edges reach a photosite through cells."""
    rng = np.random.default_rng(8)
    shapes = [
        camsim.Rectangle(
            width_um=rng.uniform(4, 8),
            height_um=rng.uniform(4, 8),
            centre_um=((i % 24 - 11.5) * 12.0, (i // 24 - 11.5) * 12.0),
            rotate_deg=rng.uniform(0, 90),
            reflectance=(0.0, 0.5)[i % 2],
        )
        for i in range(24 * 24)
    ]
    images = [
        camsim.render(
            camsim.Scene(background=1.0, shapes=shapes),
            [camsim.Airy(f_number=4.0), camsim.SquarePhotosite(side_um=4.0), *olpf],
            camsim.Grid(rows=40, cols=48, pitch_um=4.0),
            wavelength_nm=550.0,
            tolerance=tolerance,
            method=method,
        ).image
        for method, tolerance in (("fourier", 1e-7), ("boundary", 1e-3), ("boundary", 1e-5))
    ]
    assert np.abs(images[1] - images[0]).max() < 1e-3
    assert np.abs(images[2] - images[0]).max() < 1e-5
