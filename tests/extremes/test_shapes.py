"""Scenes at the end of what can be drawn: empty, endless, tiny, far away, degenerate, with thousands of corners."""

import numpy as np
import pytest
from examples import (
    BACKGROUND,
    OPTICS,
    TOLERANCE,
    image_of,
    moved,
    worst,
)
from tolerances import ROUNDING

import camsim
from tests.truth import rays

F8 = OPTICS["f/8"]  # λN is one pitch
POINT = [camsim.Airy(f_number=8.0)]
SAME = 100 * ROUNDING
SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def by_rays(corners, point, lambda_n=1.0):
    """Light on a point sample from one white polygon on black."""
    return rays.coverage_by_rays(corners, np.asarray(point, float), lambda r: rays.rayleigh_energy(r, lambda_n))


def at_origin(corners, point, optics=POINT, **settings):
    """The same by camsim, the point at the middle of a frame of one photosite."""
    return image_of(moved([(corners, 1.0)], shift=-np.asarray(point, float)), optics, 1, 1, background=0.0, **settings)[
        0, 0
    ]


@pytest.fixture(params=OPTICS.values(), ids=OPTICS, scope="module")
def optics(request):
    return request.param


@pytest.mark.parametrize("distance", [1e3, 1e12])
def test_a_shape_far_away_does_not_matter(optics, distance):
    """Its share of the light at a distance d is at most its area times the PSF there, λN/(π³d³)·2 at its crests."""
    image = image_of([(SQUARE * 8 + distance, 1.0)], optics)
    assert worst(image, BACKGROUND) <= 256 * 2 * 6 / (np.pi**3 * distance**3) + SAME


@pytest.mark.parametrize("side", [1e-3, 1e-150, 1e-300])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.1, -0.2)])
def test_a_shape_far_smaller_than_a_photosite(side, place):
    """Its light is its area times the irradiance of the PSF, π/4λN² at the very middle."""
    shape = SQUARE * side / 2
    shape = shape + place if side > 1e-15 else shape
    image = image_of([(shape, 1.0)], POINT, 3, 3, background=0.0)
    assert worst(image, 0.0) <= side**2 * np.pi / 4 + TOLERANCE
    middle = rays.airy_psf(np.hypot(*(place if side > 1e-15 else (0.0, 0.0))), 1.0) * side**2
    assert image[1, 1] == pytest.approx(middle, abs=1e-7)


@pytest.mark.parametrize("angle_deg", [30.0, 180.0 - 1e-7, 315.0])
def test_a_photosite_at_the_very_corner(angle_deg):
    """A point at the tip of a wedge sees its angle over 2π, however sharp the PSF."""
    angle = np.radians(angle_deg)
    far = 1e9
    turns = np.linspace(0.2, 0.2 + angle, 5)
    wedge = np.concatenate([[(0.0, 0.0)], far * np.stack([np.cos(turns), np.sin(turns)], axis=1)])
    assert at_origin(wedge, (0, 0)) == pytest.approx(angle / (2 * np.pi), abs=TOLERANCE)


@pytest.mark.parametrize("point", [(0.0, 0.0), (29.7, 0.4)])
def test_an_outline_of_2000_corners(point):
    """A gear of a thousand teeth, each a fraction of λN."""
    turn = 2 * np.pi * np.arange(2000) / 2000
    radius = 30.0 + 0.4 * (np.arange(2000) % 2)
    gear = radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert at_origin(gear, point) == pytest.approx(by_rays(gear, point), abs=TOLERANCE)


@pytest.mark.parametrize("points", [[(0, 0), (1e-12, 0), (0, 1e-12)], [(5, 5), (5 + 1e-15, 5), (5, 5 + 1e-15)]])
def test_corners_nearer_than_a_float_can_tell(points):
    assert worst(image_of([(np.array(points), 1.0)], F8), BACKGROUND) <= SAME
