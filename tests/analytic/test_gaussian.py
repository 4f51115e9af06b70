"""Gaussian patterns have closed forms: the engine against the error function, from 1e-2 to 1e-9."""

import numpy as np
import pytest
from scipy.special import ndtr

import camsim
from tests.truth.closed_forms import gaussian_strip

SIZE, WIDTH, HEIGHT = 48, 22.0, 15.0


def black_rectangle(sigma, side, tolerance, rotate_deg=0.0):
    scene = camsim.Scene(
        background=1.0,
        shapes=[camsim.Rectangle(width_um=WIDTH, height_um=HEIGHT, rotate_deg=rotate_deg, reflectance=0.0)],
    )
    optics = [camsim.Gaussian(sigma_um=sigma), camsim.SquarePhotosite(side_um=side)]
    grid = camsim.Grid(rows=SIZE, cols=SIZE, pitch_um=1.0)
    return camsim.render(scene, optics, grid, wavelength_nm=550.0, tolerance=tolerance)


@pytest.mark.parametrize(("sigma", "side"), [(0.2, 1.0), (0.9, 0.0), (0.9, 1.0), (6.0, 1.0)])
def test_upright_rectangle_equals_the_error_function(sigma, side):
    x = np.arange(SIZE) - (SIZE - 1) / 2
    across = np.array([gaussian_strip(v, WIDTH / 2, sigma, side) for v in x])
    down = np.array([gaussian_strip(v, HEIGHT / 2, sigma, side) for v in x])
    expected = 1.0 - np.outer(down, across)
    for tolerance in (1e-2, 1e-5, 1e-9):
        rendering = black_rectangle(sigma, side, tolerance)
        assert np.abs(rendering.image - expected).max() <= tolerance
        assert rendering.error_estimate <= tolerance


def test_turned_rectangle_equals_the_error_function_in_its_own_frame():
    rendering = black_rectangle(1.3, 0.0, 1e-8, rotate_deg=23.0)
    x = np.arange(SIZE) - (SIZE - 1) / 2
    angle = np.deg2rad(23.0)
    u = x[None, :] * np.cos(angle) + x[:, None] * np.sin(angle)
    v = x[:, None] * np.cos(angle) - x[None, :] * np.sin(angle)
    across = ndtr((u + WIDTH / 2) / 1.3) - ndtr((u - WIDTH / 2) / 1.3)
    down = ndtr((v + HEIGHT / 2) / 1.3) - ndtr((v - HEIGHT / 2) / 1.3)
    assert np.abs(rendering.image - (1.0 - across * down)).max() <= 1e-8
