"""The Fourier engine against quadrature, against the boundary engine, and against itself by other roads."""

import json
from pathlib import Path

import numpy as np
import pytest
from tolerances import ROUNDING

import camsim
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import OpticalSystem
from camsim.rendering.render import plan_render

CASES = json.loads((Path(__file__).parents[1] / "data" / "oracle-values.json").read_text())["cases"]
OUTLINE = np.array([(-9.3, -12.1), (14.2, -7.7), (3.3, 15.9), (-2.0, 2.5)])
AIRY, SQUARE = camsim.Airy(f_number=2.4), camsim.SquarePhotosite(side_um=1.0)


def polygon_image(
    stages, tolerance, *, outline=OUTLINE, shape=(1, 1), origin=None, levels=(1.0, 0.0), wavelength_nm=500.0
):
    """A polygon of one level on another, at a pitch of 1 µm, unchecked; origin: the first photosite's centre."""
    outline = np.asarray(outline, float)
    if origin is not None:  # the frame stays about the axis, and the scene moves
        outline = outline - origin + [(1 - shape[1]) / 2, (1 - shape[0]) / 2]
    scene = camsim.Scene(
        background=levels[0],
        shapes=[camsim.Polygon(points_um=tuple(map(tuple, outline.tolist())), reflectance=levels[1])],
    )
    plan = plan_render(
        scene,
        OpticalSystem.of(stages),
        camsim.Grid(rows=shape[0], cols=shape[1], pitch_um=1.0),
        response=np.ones((1, 1)),
        wavelength_nm=np.array([wavelength_nm]),
        tolerance=tolerance,
        method="fourier",
    ).plan
    return np.concatenate(list(plan.bands(np.zeros(shape, np.uint8), lambda done: None)))


def oracle_error(case, tolerance):
    stages = [camsim.Airy(f_number=2.0 * case["L"]), camsim.SquarePhotosite(side_um=case["box"])]
    if case["olpf"]:
        stages.append(camsim.FourSpotOlpf(split_um=case["olpf"]))
    outline = np.array(case["polygon"]) - [case["x"], case["y"]]
    return abs(polygon_image(stages, tolerance, outline=outline, levels=(0.0, 1.0))[0, 0] - case["value"])


def test_reference_values():
    assert len(CASES) == 296
    assert max(oracle_error(case, 1e-6) for case in CASES[::9]) <= 1e-6
    assert max(oracle_error(case, 1e-8) for case in CASES[::24] if case["L"] <= 2.0) <= 1e-8


def test_any_tolerance_is_kept(rng):
    """No point above the diagonal, wherever between the limits it lies."""
    for index in rng.integers(len(CASES), size=20):
        tolerance = 10 ** rng.uniform(-7, -2)
        assert oracle_error(CASES[index], tolerance) <= tolerance, (CASES[index], tolerance)


@pytest.mark.parametrize("tolerance", [1e-12, 0.02, 0.0, float("nan")])
def test_tolerances_that_cannot_be_kept_are_refused(tolerance):
    with pytest.raises(
        InvalidValueError, match=r"outside 1e-11 … 0\.01, what the Fourier engine renders to|is no error to keep below"
    ):
        polygon_image([AIRY], tolerance)


class Box:
    """A blur of the user's own besides the lens: what a photosite of 1 µm does."""

    place = None

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return np.sinc(fx_per_um) * np.sinc(fy_per_um)


def test_a_transfer_without_an_end_is_refused():
    with pytest.raises(UnsupportedError, match="does not end by 4096 cycles/µm; give the stage a cutoff_per_um"):
        polygon_image([Box()], 1e-6)


def test_an_l_is_three_squares():
    corners = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.0), (0.0, 0.0), (0.0, 0.5), (-0.5, 0.5))
    parts = [
        polygon_image([AIRY, camsim.SquarePhotosite(side_um=0.5)], 1e-6, shape=(6, 7), origin=(-3 + x, 4 + y))
        for x, y in ((-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25))
    ]
    for points in (corners, corners[::-1]):
        photosite = camsim.PolygonPhotosite(points_um=points)
        image = polygon_image([AIRY, photosite], 1e-6, shape=(6, 7), origin=(-3.0, 4.0))
        assert np.abs(image - np.mean(parts, axis=0)).max() <= 2e-6
    assert np.abs(image - image.mean()).max() > 0.1


def test_a_measured_pattern_beside_the_centre_shifts_the_image():
    def lens(row, col):
        samples = np.zeros((7, 7))
        samples[row, col] = 1.0
        return camsim.MeasuredPsf(irradiance=tuple(map(tuple, samples)), spacing_um=0.5)

    # A point's light falls one sample to the right and two down of where it should.
    image = polygon_image([lens(5, 4), SQUARE], 1e-6, shape=(20, 20))
    expected = polygon_image([lens(3, 3), SQUARE], 1e-6, shape=(20, 20), outline=OUTLINE + np.array([0.5, 1.0]))
    assert np.abs(image - expected).max() <= 2e-6
    assert np.abs(image - polygon_image([lens(3, 3), SQUARE], 1e-6, shape=(20, 20))).max() > 0.1


def test_samples_of_a_gaussian_make_that_gaussian():
    x = 0.4 * np.arange(-20, 21)
    row = np.exp(-0.5 * x**2)
    measured = camsim.MeasuredPsf(irradiance=tuple(map(tuple, np.outer(row, row))), spacing_um=0.4)
    gaussian = camsim.Gaussian(sigma_um=1.0)
    images = [polygon_image([lens, SQUARE], 1e-6, shape=(20, 20)) for lens in (measured, gaussian)]
    assert np.abs(images[0] - images[1]).max() <= 2e-6


@pytest.mark.parametrize(("ratio", "rotate_deg"), [(2.0, 30.0), (16.0, 90.0), (16.0, 7.0)])
def test_an_ellipse_is_a_round_pattern_in_a_stretched_world(ratio, rotate_deg):
    """A Gaussian so much wider along a direction: the scene is squeezed along it, and the pattern is round."""
    angle = np.deg2rad(rotate_deg)
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    narrow = 2.0 / ratio
    lens = camsim.EllipticalGaussian.from_axes(sigma_um=2.0, sigma_across_um=narrow, rotate_deg=rotate_deg)
    squeezed = (OUTLINE @ axes.T) / [ratio, 1.0]
    for x, y in ((0.0, 0.0), (5.0, -3.0), (12.0, -9.0)):
        where = axes @ [x, y] / [ratio, 1.0]
        expected = polygon_image([camsim.Gaussian(sigma_um=narrow)], 1e-6, outline=squeezed, origin=tuple(where))
        assert polygon_image([lens], 1e-6, origin=(x, y))[0, 0] == pytest.approx(expected[0, 0], abs=3e-6)


def test_what_lies_millions_of_pitches_away_is_clamped():
    far = np.array([(-1e7, -3.3), (2e7, 4.4), (1e7, 5e6)])
    image = polygon_image([camsim.Gaussian(sigma_um=1.5), SQUARE], 1e-6, outline=far, shape=(9, 9))
    grid = camsim.Grid(rows=9, cols=9, pitch_um=1.0)
    scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=tuple(map(tuple, far)), reflectance=0.0)])
    optics = [camsim.Gaussian(sigma_um=1.5), SQUARE]
    boundary = camsim.render(scene, optics, grid, wavelength_nm=500.0, tolerance=1e-6, method="boundary")
    assert np.abs(image - boundary.image).max() <= 2e-6


@pytest.mark.parametrize("spots", [0.0, 4.0])
def test_a_photosite_as_tall_as_another_is_wide_sees_as_far(spots):
    """A black polygon just above the frame, and one just to the left of it, which only such photosites reach."""
    beside = np.array([(-3.0, -5.5), (3.0, -5.5), (4.0, -3.0), (-4.0, -3.2)])
    images = []
    for turned in (False, True):
        sides = {"width_um": 0.3, "height_um": 5.0}
        splits = {"split_um": 0.1, "split_y_um": spots}
        if turned:
            sides = {"width_um": sides["height_um"], "height_um": sides["width_um"]}
            splits = {"split_um": splits["split_y_um"], "split_y_um": splits["split_um"]}
        stages = [camsim.Gaussian(sigma_um=0.1), camsim.RectangularPhotosite(**sides)]
        stages += [camsim.FourSpotOlpf(**splits)] if spots else []
        # Turned, x and y are exchanged, and with them the way round.
        outline = beside[::-1, ::-1] if turned else beside
        image = polygon_image(stages, 1e-6, outline=outline, shape=(5, 5))
        images.append(image.T if turned else image)
    assert images[0].min() < 0.8
    assert np.abs(images[0] - images[1]).max() <= 2e-6


def test_scenery_wholly_elsewhere_and_wholly_around():
    lens = [camsim.Gaussian(sigma_um=1.0), SQUARE]
    for elsewhere in ([(1000, 1000), (1100, 1000), (1050, 1100)], [(1000, -5), (1100, -5), (1050, 5)]):
        assert np.abs(polygon_image(lens, 1e-6, outline=elsewhere, shape=(3, 4)) - 1.0).max() <= ROUNDING
    around = [(-1e6, -1e6), (1e6, -1e6), (1e6, 1e6), (-1e6, 1e6)]
    assert np.abs(polygon_image(lens, 1e-6, outline=around, shape=(3, 4))).max() <= 2e-6
