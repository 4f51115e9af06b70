"""Laws of rendering: a scene that is mirrored, turned, shifted or enlarged gives an image that is."""

import math

import numpy as np
import pytest
from examples import (
    OPTICS,
    PICTURE,
    PITCH_UM,
    TOLERANCE,
    WAVELENGTH_NM,
    grid_of,
    image_of,
    moved,
    worst,
)
from tolerances import METHOD, ROUNDING

import camsim
from camsim.rendering.boundary import image as boundary_image

MOVES = {
    "mirror in x": ([[-1, 0], [0, 1]], lambda image: image[:, ::-1]),
    "mirror in y": ([[1, 0], [0, -1]], lambda image: image[::-1]),
    "transpose": ([[0, 1], [1, 0]], lambda image: image.T),
    "quarter turn clockwise": ([[0, -1], [1, 0]], lambda image: np.rot90(image, -1)),
    "half turn": ([[-1, 0], [0, -1]], lambda image: np.rot90(image, 2)),
    "quarter turn anticlockwise": ([[0, 1], [-1, 0]], lambda image: np.rot90(image, 1)),
}


TWO = {name: OPTICS[name] for name in ("f/1.4, fill factor 0.5", "f/8, OLPF")}


@pytest.fixture(params=TWO.values(), ids=TWO, scope="module")
def optics(request):
    return request.param


@pytest.fixture(scope="module")
def image(optics):
    return image_of(PICTURE, optics, 20, 24)


@pytest.mark.parametrize(("matrix", "turned"), MOVES.values(), ids=MOVES)
def test_the_image_is_the_scenes_way_round(optics, image, matrix, turned):
    expected = turned(image)
    found = image_of(moved(PICTURE, matrix), optics, *expected.shape)
    assert worst(found, expected) <= METHOD * TOLERANCE
    # The picture has no symmetry of its own that would let a wrong turn pass.
    assert image.shape != expected.shape or worst(image, expected) > 0.05


def test_row_0_is_at_the_top_and_column_0_at_the_left():
    """A white corner at negative x and y lights photosite (0, 0) and no other corner of the frame."""
    square = np.array([(-10, -8), (-6, -8), (-6, -4), (-10, -4)])
    image = image_of([(square, 1.0)], OPTICS["f/8"], 16, 20, background=0.0)
    assert image[0, 0] > 0.5
    assert max(image[0, -1], image[-1, 0], image[-1, -1]) < 0.01
    # x − y of its centre is (−8, −6) pitches: 8 columns left of the middle, 6 rows above it.
    rows, cols = np.indices(image.shape)
    bright = image > 0.5
    assert (rows[bright].mean() - 7.5, cols[bright].mean() - 9.5) == (-6.0, -8.0)


@pytest.mark.parametrize("shift", [(-5, 4), (0, 64)])
def test_a_shift_by_whole_pitches_shifts_the_image(optics, image, shift):
    right, down = shift
    found = image_of(moved(PICTURE, shift=shift), optics, 20 + 2 * abs(down), 24 + 2 * abs(right))
    top, left = abs(down) + down, abs(right) + right
    assert worst(found[top : top + 20, left : left + 24], image) <= METHOD * TOLERANCE


@pytest.mark.parametrize("shape", [(24, 150), (150, 24)], ids=["wide", "tall"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_a_large_frame_is_made_of_the_numbers_of_small_ones(monkeypatch, shape, tolerance):
    """A large frame begins with larger tiles, which hand down to smaller ones what is far from all of their places."""

    def image(most_tiles):
        monkeypatch.setattr(boundary_image, "MOST_TILES", most_tiles)
        return camsim.render(
            camsim.Scene(background=0.0, shapes=[far_off, camsim.Disc(radius_um=3 * PITCH_UM, reflectance=0.5)]),
            [camsim.Airy(f_number=2.0), camsim.SquarePhotosite(side_um=PITCH_UM)],
            grid_of(*shape),
            wavelength_nm=WAVELENGTH_NM,
            tolerance=tolerance,
            method="boundary",
        ).image

    corners = np.array([(-70, -60), (-40, -55), (-60, -20)]) * PITCH_UM
    far_off = camsim.Polygon(points_um=corners.tolist(), reflectance=1.0)
    assert worst(image(1), image(100_000)) <= tolerance


def test_a_rectangle_turns_clockwise_as_displayed():
    """By 30° its right end goes down, to larger y; a picture of it is darker there."""
    grid = grid_of(24, 24)
    turned = camsim.Rectangle(width_um=60.0, height_um=8.0, rotate_deg=30.0, reflectance=0.0)
    cos, sin = math.cos(math.pi / 6), math.sin(math.pi / 6)
    corners = [(x * cos - y * sin, x * sin + y * cos) for x, y in ((-30, -4), (30, -4), (30, 4), (-30, 4))]
    by_hand = camsim.Polygon(points_um=corners, reflectance=0.0)
    images = [
        camsim.render(
            camsim.Scene(background=1.0, shapes=[shape]),
            OPTICS["f/8"],
            grid,
            wavelength_nm=WAVELENGTH_NM,
        ).image
        for shape in (turned, by_hand)
    ]
    assert worst(*images) <= 100 * ROUNDING
    row_right = np.average(np.arange(24), weights=1 - images[0][:, 17])
    row_left = np.average(np.arange(24), weights=1 - images[0][:, 6])
    assert row_right - row_left == pytest.approx(11 * math.tan(math.pi / 6), abs=0.3)


def test_the_direction_of_an_outline_does_not_matter(optics, image):
    shapes = [(corners[::-1], reflectance) for corners, reflectance in PICTURE]
    assert worst(image_of(shapes, optics), image) <= 100 * ROUNDING
