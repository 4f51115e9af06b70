"""Photosites against truths derived another way: rays, the line spread, exact clipping in the sharp limit."""

import math

import numpy as np
import pytest
import shapely

import camsim
from tests.truth import rays

TRIANGLE = [(-3.1, -2.2), (6.7, -1.4), (0.9, 4.8)]
ARROW = [(-4.0, -3.0), (4.0, 0.0), (-4.0, 3.0), (-1.0, 0.0)]


def one_photosite(polygon, point, lambda_n, *, side=0.0, split=0.0, tolerance=1e-6):
    shifted = [(x - point[0], y - point[1]) for x, y in polygon]
    optics = [camsim.Airy(f_number=lambda_n * 2.0), camsim.SquarePhotosite(side_um=side)]
    if split:
        optics.append(camsim.FourSpotOlpf(split_um=split))
    scene = camsim.Scene(background=0.0, shapes=[camsim.Polygon(points_um=shifted, reflectance=1.0)])
    grid = camsim.Grid(rows=1, cols=1, pitch_um=1.0)
    return camsim.render(scene, optics, grid, wavelength_nm=500.0, tolerance=tolerance).image[0, 0]


@pytest.mark.parametrize("polygon", [TRIANGLE, ARROW], ids=["triangle", "arrow"])
@pytest.mark.parametrize("point", [(0.3, 0.2), (-2.9, -2.0), (7.4, 3.0), (15.0, -9.0)])
@pytest.mark.parametrize("lambda_n", [0.35, 1.7])
def test_point_samples_equal_rays(polygon, point, lambda_n):
    expected = rays.coverage_by_rays(polygon, np.array(point), lambda r: rays.rayleigh_energy(r, lambda_n))
    assert one_photosite(polygon, point, lambda_n) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("distance", [-6.0, -0.8, 0.0, 0.31, 2.5])
def test_middle_of_a_long_edge_tends_to_the_half_plane(distance):
    # A square of half-width S about the foot, edge through it: what it lacks of the half-plane is at most the tail of
    # three far half-planes, 2·λN/(π³S) each.
    half = 4000.0
    square = [(-half, 0.0), (half, 0.0), (half, 2 * half), (-half, 2 * half)]
    lacking = 3 * 2.0 * 1.3 / (math.pi**3 * half)
    expected = rays.half_plane(distance, 1.3)
    assert one_photosite(square, (0.0, distance), 1.3) == pytest.approx(expected, abs=1e-6 + lacking)


@pytest.mark.parametrize(("turn_deg", "lambda_n", "tolerance"), [(12.0, 1.3, 1e-6), (78.0, 0.3, 1e-4)])
def test_a_long_edge_through_many_tiles_is_the_half_plane(turn_deg, lambda_n, tolerance):
    """What a photosite sees of it hangs on its distance alone, and with what lies as far on the other side is all."""
    half, turn = 4000.0, math.radians(turn_deg)
    along = half * np.array([math.cos(turn), math.sin(turn)])
    inward = np.array([-along[1], along[0]])
    square = [-along, along, along + 2 * inward, 2 * inward - along]
    scene = camsim.Scene(background=0.0, shapes=[camsim.Polygon(points_um=square, reflectance=1.0)])
    lens, grid = camsim.Airy(f_number=2.0 * lambda_n), camsim.Grid(rows=40, cols=60, pitch_um=1.0)
    image = camsim.render(scene, [lens], grid, wavelength_nm=500.0, tolerance=tolerance, method="boundary").image
    lacking = 3 * 2.0 * lambda_n / (math.pi**3 * half)
    assert np.abs(image + image[::-1, ::-1] - 1.0).max() <= 2.0 * (tolerance + lacking)
    y, x = np.indices(image.shape) + np.array(grid.first_centre)[::-1, None, None]
    distance = (x * inward[0] + y * inward[1]) / half
    for place in np.argsort(np.abs(distance), axis=None)[:120:30]:
        expected = rays.half_plane(distance.flat[place], lambda_n)
        assert image.flat[place] == pytest.approx(expected, abs=tolerance + lacking)


def test_sharp_limit_is_the_clipped_area():
    # f/0.02 at 500 nm: λN is a hundredth of the pitch; what is left of blur at a distance h is 0.065·λN/h.
    grid = camsim.Grid(rows=9, cols=11, pitch_um=1.0)
    scene = camsim.Scene(background=0.0, shapes=[camsim.Polygon(points_um=TRIANGLE, reflectance=1.0)])
    optics = [camsim.Airy(f_number=0.02), camsim.SquarePhotosite(side_um=1.0)]
    image = camsim.render(scene, optics, grid, wavelength_nm=500.0, tolerance=1e-4).image
    triangle = shapely.Polygon(TRIANGLE)
    expected = [
        [triangle.intersection(shapely.box(x - 5.5, y - 4.5, x - 4.5, y - 3.5)).area for x in range(11)]
        for y in range(9)
    ]
    assert np.abs(image - expected).max() < 0.01
