"""The paper's methods: what they compute is exact where it can be, and their error shrinks and is reported."""

import numpy as np
import pytest
import shapely
from scipy.special import ndtr

import camsim
from camsim.errors import UnknownNameError, UnsupportedError

GRID = camsim.Grid(rows=14, cols=17, pitch_um=1.0)
OUTLINE = [(-5.3, -4.1), (3.9, -3.2), (1.2, 4.4), (-0.5, 0.3)]
SCENE = camsim.Scene(background=0.2, shapes=[camsim.Polygon(points_um=OUTLINE, reflectance=0.9)])
BOX = camsim.SquarePhotosite(side_um=1.0)
POINT = camsim.SquarePhotosite(side_um=0.0)


def rendered(optics, method, samples=None, scene=SCENE, grid=GRID):
    return camsim.render(scene, optics, grid, wavelength_nm=550.0, method=method, samples=samples, tolerance=1e-6)


def centres(grid=GRID):
    x = np.arange(grid.cols) - (grid.cols - 1) / 2
    y = np.arange(grid.rows) - (grid.rows - 1) / 2
    return np.meshgrid(x, y)


@pytest.mark.parametrize("side", [1.0, 0.6])
def test_area_is_exact_clipping(side):
    polygon = shapely.Polygon(OUTLINE)
    x, y = centres()
    half = side / 2
    boxes = shapely.box(x - half, y - half, x + half, y + half)
    share = shapely.area(shapely.intersection(boxes, polygon)) / side**2
    image = rendered([camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=side)], "area").image
    np.testing.assert_allclose(image, 0.2 + 0.7 * share, atol=1e-7)


def test_uniform_pixel_is_a_convolution_on_the_lattice():
    sigma = 0.8
    image = rendered([camsim.Gaussian(sigma_um=sigma), BOX], "uniform-pixel").image
    wide = camsim.Grid(rows=GRID.rows + 10, cols=GRID.cols + 10, pitch_um=1.0)
    area = rendered([camsim.Gaussian(sigma_um=sigma), BOX], "area", grid=wide).image
    tap = np.exp(-0.5 * (np.arange(-5, 6) / sigma) ** 2)
    kernel = np.outer(tap, tap) / tap.sum() ** 2
    windows = np.lib.stride_tricks.sliding_window_view(area, (11, 11))
    np.testing.assert_allclose(image, np.einsum("rcij,ij->rc", windows, kernel), atol=1e-9)


def test_strips_equal_the_error_function_and_the_boundary_engine():
    upright = camsim.Scene(
        background=1.0, shapes=[camsim.Rectangle(width_um=7.0, height_um=5.0, centre_um=(0.3, -0.2), reflectance=0.0)]
    )
    lens = camsim.Gaussian(sigma_um=1.1)
    x, y = centres()
    across = ndtr((x - 0.3 + 3.5) / 1.1) - ndtr((x - 0.3 - 3.5) / 1.1)
    down = ndtr((y + 0.2 + 2.5) / 1.1) - ndtr((y + 0.2 - 2.5) / 1.1)
    np.testing.assert_allclose(rendered([lens], "strips", scene=upright).image, 1.0 - across * down, atol=1e-9)
    exact = camsim.render(SCENE, [lens], GRID, wavelength_nm=550.0, tolerance=1e-9)
    np.testing.assert_allclose(rendered([lens], "strips").image, exact.image, atol=2e-9)


@pytest.mark.parametrize("lens", [camsim.Gaussian(sigma_um=1.0), camsim.Airy(f_number=3.0)], ids=["gaussian", "airy"])
def test_importance_converges_and_reports_its_error(lens):
    errors, optics = [], [lens, BOX, camsim.FourSpotOlpf(split_um=0.75)]
    exact = rendered(optics, "boundary").image
    for samples in (121, 2025, 40_401):
        rendering = rendered(optics, "importance", samples)
        errors.append(np.sqrt(np.mean((rendering.image - exact) ** 2)))
        assert 0.0 < rendering.error_estimate <= np.abs(rendering.image - exact).max() + 1e-6
    assert errors[1] < 0.5 * errors[0]
    if isinstance(lens, camsim.Gaussian):
        assert errors[2] < 0.2 * errors[1]
    else:  # cut at 18 λN: what lies beyond is a bias that no number of samples mends
        assert errors[2] > 1e-4


def test_unsuited_requests_name_a_way_out():
    with pytest.raises(UnsupportedError, match=r"strips needs a Gaussian lens .* this is Airy .* use boundary"):
        rendered([camsim.Airy(f_number=8.0), BOX], "strips")
    with pytest.raises(UnsupportedError, match="only importance takes a number"):
        rendered([camsim.Gaussian(sigma_um=1.0)], "uniform", 50)
    with pytest.raises(UnknownNameError, match="did you mean 'importance'"):
        rendered([camsim.Gaussian(sigma_um=1.0)], "importanse")


def test_point_samples_count_what_lies_inside():
    image = rendered([camsim.Gaussian(sigma_um=1e-6), POINT], "importance", 1).image
    x, y = centres()
    inside = shapely.contains_xy(shapely.Polygon(OUTLINE), x, y)
    np.testing.assert_allclose(image, np.where(inside, 0.9, 0.2), atol=1e-12)


def test_strips_of_any_covariance_against_fourier_transforms():
    shape = camsim.Polygon(points_um=[(-31, -22), (28, -30), (33, 19), (5, 8), (-20, 31)], reflectance=0.1)
    scene = camsim.Scene(background=1.0, shapes=[shape])
    lens = camsim.EllipticalGaussian.from_axes(sigma_um=6.0, sigma_across_um=2.0, rotate_deg=30.0)
    grid = camsim.Grid(rows=20, cols=23, pitch_um=4.0)
    exact = camsim.render(scene, [lens], grid, wavelength_nm=550.0, tolerance=1e-11, method="fourier").image
    strips = camsim.render(scene, [lens], grid, wavelength_nm=550.0, method="strips")
    assert np.abs(strips.image - exact).max() < 1e-8
    assert strips.error_estimate < 1e-8
