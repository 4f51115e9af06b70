"""Scenes at the end of what can be drawn: empty, endless, tiny, far away, degenerate, with thousands of corners."""

import numpy as np
import pytest
from examples import (
    ARROW,
    BACKGROUND,
    OPTICS,
    PICTURE,
    TOLERANCE,
    image_of,
    moved,
    worst,
)
from tolerances import METHOD, ROUNDING

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


def test_an_empty_scene_is_its_background(optics):
    assert worst(image_of([], optics), BACKGROUND) == 0.0
    assert worst(image_of([], optics, background=0.0), 0.0) == 0.0


@pytest.mark.parametrize("side", [1e4, 1e7, 1e12])
def test_a_shape_that_covers_all(optics, side):
    """What is missing are four half-planes at a distance of side/2, each 2λN/(π³h), h the distance."""
    image = image_of([(SQUARE * side / 2, 0.9)], optics)
    lambda_n = optics[0].f_number / 8.0
    assert worst(image, 0.9) <= (0.9 - BACKGROUND) * 4 * 2 * lambda_n / (np.pi**3 * (side / 2 - 20)) + TOLERANCE


@pytest.mark.parametrize("distance", [1e3, 1e6, 1e9, 1e12])
def test_a_shape_far_away_does_not_matter(optics, distance):
    """Its share of the light at a distance d is at most its area times the PSF there, λN/(π³d³)·2 at its crests."""
    image = image_of([(SQUARE * 8 + distance, 1.0)], optics)
    assert worst(image, BACKGROUND) <= 256 * 2 * 6 / (np.pi**3 * distance**3) + SAME


@pytest.mark.parametrize("side", [1e-3, 1e-6, 1e-12, 1e-150, 1e-200, 1e-300])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.5, 0.5), (0.1, -0.2)])
def test_a_shape_far_smaller_than_a_photosite(side, place):
    """Its light is its area times the irradiance of the PSF, π/4λN² at the very middle."""
    shape = SQUARE * side / 2
    shape = shape + place if side > 1e-15 else shape
    image = image_of([(shape, 1.0)], POINT, 3, 3, background=0.0)
    assert worst(image, 0.0) <= side**2 * np.pi / 4 + TOLERANCE
    middle = rays.airy_psf(np.hypot(*(place if side > 1e-15 else (0.0, 0.0))), 1.0) * side**2
    assert image[1, 1] == pytest.approx(middle, abs=1e-7)


@pytest.mark.parametrize("width", [1e-13, 1e-9, 1e-6])
def test_a_sliver(optics, width):
    """A crack as long as the frame is wide: its width times the line spread, which is below 2/λN."""
    lambda_n = optics[0].f_number / 8.0
    crack = np.array([(-9.0, -3.1), (9.0, 2.9), (9.0 - 0.3 * width, 2.9 + width), (-9.0 - 0.3 * width, -3.1 + width)])
    assert worst(image_of([(crack, 1.0)], optics), BACKGROUND) <= 2 * width / lambda_n + SAME


@pytest.mark.parametrize("point", [(0.0, 0.0), (0.3, 0.45), (2.0, -1.5)])
def test_a_thin_line_is_its_width_times_the_line_spread(point):
    """The line spread by adding up the PSF along the line."""
    width, half = 3e-3, 200.0
    line = SQUARE * (half, width / 2)
    s = np.linspace(-half, half, 200_001) - point[0]
    spread = np.trapezoid(rays.airy_psf(np.hypot(s, point[1]), 1.0), s)
    assert at_origin(line, point, tolerance=1e-7) == pytest.approx(width * spread, abs=METHOD * 1e-7)


def test_an_edge_through_the_middle_of_photosites(optics):
    """The half-plane x > 0: photosites on the edge see exactly half of it, those beside it share the rest."""
    half_plane = np.array([(0, -1e7), (1e7, -1e7), (1e7, 1e7), (0, 1e7)])
    image = image_of([(half_plane, 1.0)], optics, 5, 9, background=0.0)
    assert worst(image[:, 4], 0.5) <= TOLERANCE
    assert worst(image + image[:, ::-1], 1.0) <= METHOD * TOLERANCE
    across = image_of([(half_plane[:, ::-1], 1.0)], optics, 9, 5, background=0.0)
    assert worst(across, image.T) <= METHOD * TOLERANCE


def test_an_edge_along_the_border_of_photosites(optics):
    half_plane = np.array([(0, -1e7), (1e7, -1e7), (1e7, 1e7), (0, 1e7)])
    image = image_of([(half_plane, 1.0)], optics, 4, 10, background=0.0)
    assert worst(image + image[:, ::-1], 1.0) <= METHOD * TOLERANCE
    assert np.diff(image[0]).min() > 0.0


@pytest.mark.parametrize("angle_deg", [30.0, 45.0, 90.0, 180.0 - 1e-7, 270.0, 315.0])
def test_a_photosite_at_the_very_corner(angle_deg):
    """A point at the tip of a wedge sees its angle over 2π, however sharp the PSF."""
    angle = np.radians(angle_deg)
    far = 1e9
    turns = np.linspace(0.2, 0.2 + angle, 5)
    wedge = np.concatenate([[(0.0, 0.0)], far * np.stack([np.cos(turns), np.sin(turns)], axis=1)])
    assert at_origin(wedge, (0, 0)) == pytest.approx(angle / (2 * np.pi), abs=TOLERANCE)


@pytest.mark.parametrize("which", range(4))
def test_points_on_corners_and_edges(which):
    """On a corner, in the middle of an edge and a hair beside both: no jump, and what rays say."""
    corner = ARROW[which]
    middle = 0.5 * (ARROW[which] + ARROW[(which + 1) % 4])
    for point in (corner, middle):
        there = at_origin(ARROW, point)
        assert there == pytest.approx(by_rays(ARROW, point), abs=TOLERANCE)
        for hair in ((1e-12, 0.0), (0.0, -1e-9), (1e-7, 1e-7)):
            assert at_origin(ARROW, point + hair) == pytest.approx(there, abs=METHOD * TOLERANCE)


def test_corners_on_the_border_of_the_frame(optics):
    """And on photosites' centres and corners; a window about the same photosites sees the same."""
    rows, cols = 8, 10
    corners = np.array([(-5, -4), (4.5, -3.5), (5, 4), (0, 4), (-4.5, 0.5)])
    image = image_of([(corners, 1.0)], optics, rows, cols, background=0.0)
    wide = image_of([(corners, 1.0)], optics, rows + 6, cols + 6, background=0.0)
    assert worst(image, wide[3:-3, 3:-3]) <= METHOD * TOLERANCE
    beside = image_of(moved([(corners, 1.0)], shift=(1e-9, -1e-9)), optics, rows, cols, background=0.0)
    assert worst(image, beside) <= METHOD * TOLERANCE


@pytest.mark.parametrize("offset", [(1_000_000, 1_000_000), (-1_000_000, 3), (123457, -999999)])
def test_a_million_pitches_from_the_axis(optics, offset):
    """A window far out on a huge frame, with the scene there: 1e6 pitches leave 1e-10 of a pitch in a float64."""
    col, row = offset
    rows, cols = 20, 24
    window = {"origin": (row, col), "frame": (rows, cols)}
    found = image_of(moved(PICTURE, shift=offset), optics, rows, cols, **window)
    assert worst(found, image_of(PICTURE, optics, rows, cols)) <= 1e-9


def test_points_twice_and_points_on_a_straight_line(optics):
    a, b, c, d = ARROW
    doubled = np.array([a, a, b, c, c, c, d, a])
    collinear = np.array([a, a + 0.25 * (b - a), a + 0.5 * (b - a), b, c, 0.5 * (c + d), d])
    image = image_of([(ARROW, 0.9)], optics)
    assert worst(image_of([(doubled, 0.9)], optics), image) <= SAME
    assert worst(image_of([(collinear, 0.9)], optics), image) <= METHOD * TOLERANCE


def test_shapes_within_shapes(optics):
    """A target of squares, each inside the last, black and white: its image is the alternating sum."""
    sides = (9.0, 7.5, 5.5, 4.0, 2.0, 0.3)
    target = [(SQUARE * s, float(i % 2)) for i, s in enumerate(sides)]
    expected = 1.0 + sum(
        (-1) ** (i + 1) * image_of([(SQUARE * s, 1.0)], optics, background=0.0) for i, s in enumerate(sides)
    )
    assert worst(image_of(target, optics, background=1.0), expected) <= 7 * TOLERANCE


@pytest.mark.parametrize("point", [(0.0, 0.0), (29.7, 0.4), (-31.0, 5.0), (12.0, -60.0)])
def test_an_outline_of_2000_corners(point):
    """A gear of a thousand teeth, each a fraction of λN."""
    turn = 2 * np.pi * np.arange(2000) / 2000
    radius = 30.0 + 0.4 * (np.arange(2000) % 2)
    gear = radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert at_origin(gear, point) == pytest.approx(by_rays(gear, point), abs=TOLERANCE)


@pytest.mark.parametrize("point", [(0.0, 0.0), (-3.2, 1.4), (11.3, 14.0)])
def test_many_shapes(point):
    """Ten by ten squares, by the sum of what each alone gives."""
    places = 2.5 * (np.indices((10, 10)).reshape(2, -1).T - 4.5)
    shapes = [(SQUARE * 0.6 + place, 1.0) for place in places]
    found = image_of(moved(shapes, shift=np.negative(point)), POINT, 1, 1, background=0.0)[0, 0]
    assert found == pytest.approx(sum(by_rays(corners, point) for corners, _ in shapes), abs=TOLERANCE)


@pytest.mark.parametrize("points", [[(0, 0), (1e-12, 0), (0, 1e-12)], [(5, 5), (5 + 1e-15, 5), (5, 5 + 1e-15)]])
def test_corners_nearer_than_a_float_can_tell(points):
    assert worst(image_of([(np.array(points), 1.0)], F8), BACKGROUND) <= SAME


@pytest.mark.parametrize("number", [1e160, 1e300, -1e155, 1e16])
def test_what_lies_beyond_any_scene_is_refused(number):
    with pytest.raises(camsim.CamsimError, match=r"1e\+15"):
        camsim.Polygon(points_um=[(0, 0), (number, 0), (0, 1)], reflectance=0.5)
    with pytest.raises(camsim.CamsimError, match=r"1e\+15"):
        camsim.Disc(radius_um=1.0, centre_um=(0.0, number), reflectance=0.5)
    with pytest.raises(camsim.CamsimError, match=r"1e\+15"):
        camsim.Rectangle(width_um=abs(number), height_um=1.0, reflectance=0.5)
