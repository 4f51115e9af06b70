"""Gradients and sinusoids against closed forms and brute-force sums of their formulas."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from examples import worst
from truth import samples as truth
from truth.closed_forms import grating_contrast

import camsim
from camsim.errors import InvalidValueError

PITCH_UM, NM = 4.0, 500.0
OPTICS = [camsim.Airy(f_number=8.0), camsim.FourSpotOlpf(split_um=3.0), camsim.SquarePhotosite(side_um=PITCH_UM)]
GRID = camsim.Grid(rows=8, cols=9, pitch_um=PITCH_UM)
SPOTS = np.array([(x, y) for x in (-0.375, 0.375) for y in (-0.375, 0.375)])


def rendered(*shapes, tolerance, background=0.0):
    scene = camsim.Scene(background=background, shapes=shapes)
    found = camsim.render(scene, OPTICS, GRID, wavelength_nm=NM, tolerance=tolerance)
    assert found.error_estimate <= tolerance
    return found.image


@pytest.mark.parametrize(("period", "rotate_deg"), [(2.3, 27.0), (4.0, 0.0), (9.0, 63.0)])
def test_contrast_is_the_transfer(period, rotate_deg):
    """Waves less the same half a wave on: of a wide grating, amplitude times the transfer at its frequency."""
    wide = {"width_um": 60.0 * PITCH_UM, "height_um": 50.0 * PITCH_UM, "period_um": period * PITCH_UM}
    bright, dark = (
        rendered(camsim.SineGrating(**wide, rotate_deg=rotate_deg, phase_deg=phase, low=0.1, high=0.9), tolerance=1e-4)
        for phase in (40.0, 220.0)
    )
    fx, fy = np.cos(np.radians(rotate_deg)) / period, np.sin(np.radians(rotate_deg)) / period
    x0, y0 = GRID.first_centre
    x, y = x0 + np.arange(GRID.cols), y0 + np.arange(GRID.rows)[:, None]
    wave = np.cos(2.0 * np.pi * (fx * x + fy * y) + np.radians(40.0))
    right = 0.4 * grating_contrast((fx, fy), 8.0 * NM * 1e-3 / PITCH_UM, 1.0, 0.75) * wave
    assert worst(0.5 * (bright - dark), right) <= 1e-4


def star(x, y):
    return 0.5 + 0.5 * np.cos(8 * np.arctan2(y, x))


FIELDS = {
    "linear": (
        camsim.LinearGradient(width_um=36.0, height_um=22.0, rotate_deg=20.0, low=0.2, high=0.9),
        truth.light_of_rectangle(
            lambda u, v: 0.2 + 0.7 * (0.5 + u / 9.0), width=9.0, height=5.5, rotate_deg=20.0, nodes=60
        ),
    ),
    "radial": (
        camsim.RadialGradient(radius_um=18.0, low=0.2),
        truth.light_of_ring(lambda x, y: 1.0 - 0.8 * (x * x + y * y) / 4.5**2, radius=4.5, inner=0.0, nodes=50),
    ),
    "grating": (
        camsim.SineGrating(width_um=30.0, height_um=22.0, period_um=8.8, rotate_deg=-35.0),
        truth.light_of_rectangle(
            lambda u, v: 0.5 + 0.5 * np.cos(2.0 * np.pi * u / 2.2), width=7.5, height=5.5, rotate_deg=-35.0, nodes=60
        ),
    ),
    "star": (
        camsim.SineStar(radius_um=18.0, inner_radius_um=6.0, cycles=8),
        truth.light_of_ring(star, radius=4.5, inner=1.5, nodes=50),
    ),
    "zone plate": (
        camsim.SineZonePlate(radius_um=18.0, finest_period_um=8.0),
        truth.light_of_ring(
            lambda x, y: 0.5 + 0.5 * np.cos(np.pi * (x * x + y * y) / 9.0), radius=4.5, inner=0.0, nodes=60
        ),
    ),
}


@pytest.mark.parametrize("name", FIELDS)
def test_brute_force(name):
    shape, light = FIELDS[name]
    x0, y0 = GRID.first_centre
    places = [(1, 2), (3, 4)]
    centres = [(x0 + col, y0 + row) for row, col in places]
    right = truth.photosites(light, centres=centres, blur=8.0 * NM * 1e-3 / PITCH_UM, side=1.0, spots=SPOTS, nodes=8)
    for tolerance in (1e-2, 1e-6):
        image = rendered(shape, tolerance=tolerance)
        assert worst([image[place] for place in places], right) <= tolerance


@pytest.mark.parametrize(
    ("lens", "frames"),
    [(camsim.Gaussian(sigma_um=2.0), 10.0), (camsim.Airy(f_number=8.0), 3.0)],
    ids=["gaussian", "airy"],
)
def test_far_larger_than_the_frame(lens, frames):
    """Between borders that far away a ramp is itself, and a paraboloid is lower by the blur's second moment.

    An Airy pattern's own has no end, and its light from beyond a border at r is 2λN/π²r.
    """
    optics, extent = [lens, camsim.SquarePhotosite(side_um=PITCH_UM)], frames * GRID.cols * PITCH_UM
    x, y = (np.arange(n) - 0.5 * (n - 1) for n in (GRID.cols, GRID.rows))
    far = 0.0 if isinstance(lens, camsim.Gaussian) else 4.0 * 8.0 * NM * 1e-3 / (np.pi**2 * 0.5 * extent)
    second = 2.0 * (2.0**2 + PITCH_UM**2 / 12.0)
    ramp = camsim.LinearGradient(width_um=extent, height_um=0.9 * extent, low=0.2, high=0.8)
    bowl = camsim.RadialGradient(radius_um=0.5 * extent, low=0.2, high=0.8)
    square = (x**2 + y[:, None] ** 2) * PITCH_UM**2 + second
    rights = [
        0.5 + 0.6 * x * PITCH_UM / extent + 0.0 * y[:, None],
        0.8 - 0.6 * square / (0.5 * extent) ** 2,
    ]
    tracemalloc.start()
    for shape, right in zip((ramp, bowl), rights, strict=True):
        found = camsim.render(
            camsim.Scene(background=0.3, shapes=[shape]), optics, GRID, wavelength_nm=NM, tolerance=1e-4
        )
        assert found.error_estimate <= 1e-4
        assert worst(found.image, right) <= 1e-4 + far
    assert tracemalloc.get_traced_memory()[1] < 2e8
    tracemalloc.stop()


def test_two_curves_that_are_one_are_that_colour():
    """A star from a curve to itself is a ring of it, behind a disc and on a picture."""
    curve = camsim.Curve([400.0, 700.0], [0.2, 0.9])
    placed = {"radius_um": 15.0, "inner_radius_um": 7.0, "centre_um": (1.0, 2.0)}
    picture = camsim.Picture(planes=np.random.default_rng(1).random((3, 3)), width_um=30.0)
    cover = camsim.Disc(radius_um=6.0, centre_um=(8.0, 0.0), reflectance=0.1)
    displayed = rendered(picture, camsim.SineStar(cycles=5, low=curve, high=curve, **placed), cover, tolerance=1e-4)
    right = rendered(picture, camsim.Ring(reflectance=curve, **placed), cover, tolerance=1e-5)
    assert worst(displayed, right) <= 1e-4


def test_too_many_samples_are_one_sentence():
    fine = camsim.SineGrating(width_um=1e5, height_um=1e5, period_um=1.0)
    with pytest.raises(InvalidValueError, match=r"SineGrating would take .* samples, and the most is 6"):
        rendered(fine, tolerance=1e-4)
