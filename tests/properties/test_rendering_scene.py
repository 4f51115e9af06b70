"""Laws of rendering: what a scene's surfaces and their arrangement do to its image."""

import numpy as np
import pytest
from examples import (
    ARROW,
    BACKGROUND,
    OPTICS,
    PICTURE,
    PITCH_UM,
    SLAB,
    TOLERANCE,
    TRIANGLE,
    WAVELENGTH_NM,
    grid_of,
    image_of,
    scene_of,
    worst,
)
from tolerances import METHOD, ROUNDING

import camsim
from camsim.scene import arrange

F8 = OPTICS["f/8, OLPF"]
SAME = 100 * ROUNDING  # what only the order of sums may change


TWO = {name: OPTICS[name] for name in ("f/1.4, fill factor 0.5", "f/8, OLPF")}


@pytest.fixture(params=TWO.values(), ids=TWO, scope="module")
def optics(request):
    return request.param


@pytest.fixture(scope="module")
def masks(optics):
    """Each visible part of PICTURE alone, white on black."""
    arrow = image_of([(ARROW, 1.0), (TRIANGLE, 0.0), (SLAB, 0.0)], optics, background=0.0)
    triangle = image_of([(TRIANGLE, 1.0), (SLAB, 0.0)], optics, background=0.0)
    slab = image_of([(SLAB, 1.0)], optics, background=0.0)
    return arrow, triangle, slab


@pytest.mark.parametrize("background", [0.0, 0.18])
def test_linear_in_reflectance(optics, masks, background):
    """The image is the background plus every visible part's mask times its contrast."""
    reflectances = (0.9, 0.05, 0.5)
    shapes = list(zip((ARROW, TRIANGLE, SLAB), reflectances, strict=True))
    expected = background + sum((r - background) * mask for r, mask in zip(reflectances, masks, strict=True))
    # Each mask is within the tolerance; so is the image, relative to its brightest surface.
    allowed = TOLERANCE * (sum(abs(r - background) for r in reflectances) + 1.0)
    assert worst(image_of(shapes, optics, background=background), expected) <= allowed


def test_complement(optics):
    """Black on white and white on black add up to white."""
    black = image_of([(corners, 0.0) for corners, _ in PICTURE], optics, background=1.0)
    white = image_of([(corners, 1.0) for corners, _ in PICTURE], optics, background=0.0)
    assert worst(black + white, 1.0) <= SAME


@pytest.mark.parametrize("factor", [1e-9, 1e-3])
def test_very_dark_scenes_scale(factor):
    """The tolerance is relative to a perfect diffuser, however dark the surfaces are."""
    shapes = [(corners, reflectance * factor) for corners, reflectance in PICTURE]
    found = camsim.render(scene_of(shapes, BACKGROUND * factor), F8, grid_of(20, 24), wavelength_nm=WAVELENGTH_NM)
    assert found.error_estimate <= TOLERANCE
    expected = image_of(PICTURE, F8) * factor
    assert worst(found.image, expected) <= METHOD * TOLERANCE


def test_cut_across_its_edges_is_the_whole(optics):
    """New corners in the middle of edges: the same light, but other sums."""
    a, b, c = TRIANGLE
    p, q = a + 0.37 * (b - a), a + 0.61 * (c - a)
    halves = [(np.array([a, p, q]), 0.7), (np.array([p, b, c, q]), 0.7)]
    assert worst(image_of(halves, optics), image_of([(TRIANGLE, 0.7)], optics)) <= METHOD * TOLERANCE


@pytest.mark.parametrize("spectrum", [0.7, camsim.Curve((300.0, 900.0), (0.7, 0.7), outside="hold")])
def test_neighbours_of_equal_spectrum_leave_no_edge(spectrum):
    left = np.array([(-5, -5), (0.3, -5), (0.3, 5), (-5, 5)])
    right = np.array([(0.3, -5), (6, -5), (6, 5), (0.3, 5)])
    arrangement = arrange(scene_of([(left, spectrum), (right, spectrum)]))
    inside = np.abs(arrangement.start_um[:, 0] - 0.3 * PITCH_UM) < 1e-9
    inside &= np.abs(arrangement.end_um[:, 0] - 0.3 * PITCH_UM) < 1e-9
    assert not inside.any()
    # A photosite astride the border, far from the outline, sees nothing of it.
    image = image_of([(left * 40, spectrum), (right * 40, spectrum)], F8, 3, 3)
    assert worst(image, 0.7) <= (0.7 - BACKGROUND) * 4 * 2 / (np.pi**2 * 150)


def test_a_shape_of_the_backgrounds_spectrum_is_invisible():
    assert worst(image_of([(ARROW, BACKGROUND)], F8), BACKGROUND) == 0.0
    # So is a spectrum that equals it wherever there is light.
    curve = camsim.Curve((450.0, 550.0), (BACKGROUND, BACKGROUND), outside="hold")
    assert worst(image_of([(ARROW, curve)], F8), BACKGROUND) <= SAME


def test_neighbours_share_one_edge_with_both_spectra():
    """Side by side as the left one alone plus the right one alone, also where borders meet only partly."""
    left = np.array([(-6, -5), (0.3, -4), (1.1, 4), (-5, 5)])
    right = np.array([(0.3, -4), (6, -5), (6, 5), (1.1, 4)])
    beside = np.array([(0.3, -4), (6, -5), (6, 9), (1.6, 9)])  # its border runs on past (1.1, 4)
    for neighbour in (right, beside):
        both = image_of([(left, 0.8), (neighbour, 0.1)], F8)
        apart = image_of([(left, 0.8)], F8) + image_of([(neighbour, 0.1)], F8) - BACKGROUND
        assert worst(both, apart) <= 2 * METHOD * TOLERANCE
