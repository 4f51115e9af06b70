"""Discs keep the tolerance although they are rendered as polygons; the truth is a Hankel integral over frequencies."""

import numpy as np
import pytest

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering.render import plan_render
from tests.truth import closed_forms, rays


def rendered(shapes, lambda_n, tolerance, method="auto", *, size=3, side=0.0, background=0.0, **window):
    grid = {"rows": size, "cols": size, "pitch_um": 1.0} | window
    return camsim.render(
        camsim.Scene(background=background, shapes=shapes),
        [camsim.Airy(f_number=lambda_n), camsim.SquarePhotosite(side_um=side)],
        camsim.Grid(**grid),
        wavelength_nm=1000.0,
        tolerance=tolerance,
        method=method,
    )


def disc(radius, centre=(0.0, 0.0), reflectance=1.0):
    return camsim.Disc(radius_um=radius, centre_um=centre, reflectance=reflectance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
@pytest.mark.parametrize(("radius", "lambda_n"), [(3.0, 0.3), (20.0, 1.0), (60.0, 1.0), (2.0, 6.0)])
def test_a_disc_under_a_point(radius, lambda_n, tolerance):
    for distance in radius + lambda_n * np.array([-1.5, -0.5, 0.0, 1.0]):
        if distance >= 0.0:
            found = rendered([disc(radius, (distance, 0.0))], lambda_n, tolerance, size=1)
            exact = closed_forms.disc_by_frequencies(radius, lambda_n, distance)
            assert found.image[0, 0] == pytest.approx(exact, abs=tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-6])
@pytest.mark.parametrize(("radius", "lambda_n"), [(3.3, 0.5), (20.2, 0.5), (61.1, 1.0), (40.3, 3.0)])
def test_the_centre_of_a_disc(radius, lambda_n, tolerance):
    """There the rings of the whole outline meet; its light is the encircled energy."""
    found = rendered([disc(radius)], lambda_n, tolerance, "boundary")
    assert found.image[1, 1] == pytest.approx(closed_forms.disc_at_its_centre(radius, lambda_n), abs=tolerance)
    assert found.error_estimate <= tolerance


@pytest.mark.parametrize(
    ("radius", "lambda_n", "tolerance"), [(40.05, 0.1, 1e-7), (15.0, 0.1, 1e-6), (10.0, 0.2, 1e-5)]
)
def test_the_centre_of_the_largest_discs_whose_rings_matter(radius, lambda_n, tolerance):
    """J0² + J1² swings by 1/(πx²): by 1.3 to 2 tolerances here, all of which is lost where the rings are left out."""
    x = np.pi * radius / lambda_n
    assert 1.2 * tolerance < 1.0 / (np.pi * x * x) < 2.2 * tolerance
    found = rendered([disc(radius)], lambda_n, tolerance)
    assert found.image[1, 1] == pytest.approx(closed_forms.disc_at_its_centre(radius, lambda_n), abs=tolerance)


@pytest.mark.parametrize(("right", "down"), [(30, -20), (17, 35)])
@pytest.mark.parametrize(("radius", "lambda_n", "tolerance"), [(20.2, 0.5, 1e-5), (61.1, 1.0, 1e-6), (40.3, 3.0, 1e-4)])
def test_the_centre_of_a_disc_in_a_window(right, down, radius, lambda_n, tolerance):
    """Where the rings meet is found in any part of a frame."""
    window = {"rows": 5, "cols": 7, "origin": (40 + down - 1, 40 + right - 2), "frame": (81, 81)}
    found = rendered([disc(radius, (right, down))], lambda_n, tolerance, "boundary", **window)
    assert found.image[1, 2] == pytest.approx(closed_forms.disc_at_its_centre(radius, lambda_n), abs=tolerance)
    assert found.error_estimate <= tolerance


@pytest.mark.parametrize("sides", [16, 64])
def test_the_middle_of_a_polygon_whose_sides_touch_a_circle(sides):
    """Judged by rays out of the middle, which know nothing of rings."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    corners = 20.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    truth = rays.coverage_by_rays(corners, np.zeros(2), lambda r: rays.rayleigh_energy(r, 0.5))
    for tolerance in (1e-4, 1e-6):
        found = rendered([camsim.Polygon(points_um=corners, reflectance=1.0)], 0.5, tolerance, "boundary")
        assert found.image[1, 1] == pytest.approx(truth, abs=tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_disc_that_another_shape_cuts(tolerance):
    """Where an outline is cut, no other part of it makes up for its polygon; the other engine's finest is the truth."""
    bar = camsim.Rectangle(width_um=40.0, height_um=2.0, rotate_deg=31.0, reflectance=1.0)
    auto, fourier = (
        rendered([disc(12.0, (3.0, 2.0), 0.0), bar], 1.0, asked, method, size=30, background=1.0).image
        for method, asked in (("auto", tolerance), ("fourier", 1e-7))
    )
    assert np.abs(auto - fourier).max() <= tolerance


@pytest.mark.parametrize("radius", [15.717, 13.0])
def test_rounded_squares_whose_sides_and_corners_meet_in_the_middle(radius):
    """Sides belong to a circle of their own and to those of the corners beside them; Fourier sums are the truth."""
    half = np.array([18.12, 17.996])
    quarter = np.linspace(0.0, 0.5 * np.pi, 50)
    corners = []
    for turn, sign in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        a = quarter + 0.5 * np.pi * turn
        corners.append(np.array(sign) * (half - radius) + radius * np.stack([np.cos(a), np.sin(a)], axis=1))
    square = camsim.Polygon(points_um=np.concatenate(corners) + np.array([0.28, -0.49]), reflectance=1.0)
    boundary, fourier = (
        rendered([square], 1.6311618894, asked, method, size=24, side=1.0).image
        for method, asked in (("boundary", 4e-5), ("fourier", 1e-7))
    )
    assert np.abs(boundary - fourier).max() <= 0.5 * 4e-5


def test_rings_of_a_crowd_of_discs_are_followed_to_their_rims():
    """A quarter of 400 were, and the others up to 2.7 tolerances off in their centres.

    A tenth of the crowd is cut by its neighbours, which leaves most of a turn.
    """
    at = [(57.2 * i, 57.2 * j) for i in range(-10, 10) for j in range(-10, 10)]
    cut = [disc(8.0, (x + 26.0, y)) for x, y in at[::10]]
    crowd = [disc(26.0, place, 0.0) for place in at]
    choice = plan_render(
        camsim.Scene(background=1.0, shapes=[*crowd, *cut]),
        OpticalSystem.of([camsim.Airy(f_number=2.0)]),
        camsim.Grid(rows=1400, cols=1400, pitch_um=1.0),
        response=np.ones((1, 1)),
        wavelength_nm=np.array([500.0]),
        tolerance=1e-5,
        method="boundary",
    )
    assert choice.plan.settings.near > 26.0
