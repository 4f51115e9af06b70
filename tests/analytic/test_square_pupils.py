"""Pupils with straight sides throw light far along spikes: scenery there against closed forms."""

import math

import numpy as np
import pytest
import scipy

import camsim
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics import Pupil, SquarePhotosite, Wavefront

SHAPE, BLUR, SIDE = (4, 5), 0.21, 0.8
BOXES = [(-1.3, -0.7, 1.1, 2.4), (31.0, -0.8, 35.5, 0.9), (-26.0, -21.0, -21.0, -16.5)]  # x0, y0, x1, y1
RULE = scipy.special.roots_legendre(3000)


def along(places, low, high):
    """A strip behind a slit's pattern, sinc², and a photosite: its transform is a triangle to 1/λN."""
    t, w = RULE
    f, w = 0.5 / BLUR * (1.0 + t), 0.5 / BLUR * w
    spectrum = (1.0 - f * BLUR) * (high - low) * np.sinc(f * (high - low)) * np.sinc(f * SIDE) * w
    return 2.0 * np.cos(2.0 * np.pi * np.multiply.outer(places - 0.5 * (low + high), f)) @ spectrum


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_boxes_behind_a_square_pupil_are_products_of_strips(tolerance):
    """One of them on a spike, 30 pitches away."""
    x, y = np.arange(SHAPE[1]) - 2.0, np.arange(SHAPE[0]) - 1.5
    shapes, right = [], np.zeros(SHAPE)
    for k, (x0, y0, x1, y1) in enumerate(BOXES):
        light = 1.0 - 0.2 * k
        right += light * np.multiply.outer(along(y, y0, y1), along(x, x0, x1))
        centre = (0.5 * (x0 + x1), 0.5 * (y0 + y1))
        shapes.append(camsim.Rectangle(width_um=x1 - x0, height_um=y1 - y0, centre_um=centre, reflectance=light))
    found = camsim.render(
        camsim.Scene(background=0.0, shapes=shapes),
        [Wavefront(f_number=BLUR / 0.55, pupil=Pupil(shape="square")), SquarePhotosite(side_um=SIDE)],
        camsim.Grid(rows=SHAPE[0], cols=SHAPE[1], pitch_um=1.0),
        wavelength_nm=550.0,
        tolerance=tolerance,
    )
    assert np.abs(found.image - right).max() <= tolerance
    assert found.error_estimate <= tolerance


@pytest.mark.parametrize(("towards_deg", "tolerance"), [(0.0, 1e-2), (25.0, 1e-2), (0.0, 1e-3), (45.0, 1e-3)])
def test_a_knife_edge_that_leaves_every_frame(towards_deg, tolerance):
    """A half-plane's period would be 10 km."""
    angle, f_number, pitch_um = math.radians(towards_deg), 5.6, 4.88
    lens = Wavefront(f_number=f_number, pupil=Pupil(shape="square"))
    plane = camsim.HalfPlane(through_um=(1.0, 2.0), towards_deg=towards_deg, reflectance=1.0)
    grid = camsim.Grid(rows=5, cols=9, pitch_um=pitch_um)
    optics = [lens, SquarePhotosite(side_um=pitch_um)]
    found = camsim.render(
        camsim.Scene(background=0.0, shapes=[plane]), optics, grid, wavelength_nm=550.0, tolerance=tolerance
    )
    cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
    band = 1.0 / (0.55 * f_number)  # along x and along y
    last = band / max(cos, sin)
    ends = np.linspace(0.0, last, 200)
    x, w = gauss_legendre(12)
    f = (ends[:-1, None] + 0.5 * np.diff(ends)[:, None] * (1.0 + x)).ravel()
    w = np.tile(0.5 * np.diff(ends)[:1] * w, ends.size - 1)
    transfer = (
        (1.0 - f * cos / band) * (1.0 - f * sin / band) * np.sinc(pitch_um * f * cos) * np.sinc(pitch_um * f * sin)
    )
    col, row = np.meshgrid(pitch_um * (np.arange(9) - 4.0), pitch_um * (np.arange(5) - 2.0))
    beyond = (col - 1.0) * math.cos(angle) + (row - 2.0) * math.sin(angle)
    exact = 0.5 + np.sin(np.multiply.outer(beyond, 2.0 * np.pi * f)) @ (w * transfer / (np.pi * f))
    assert np.abs(found.image - exact).max() <= tolerance
    assert found.error_estimate <= tolerance
