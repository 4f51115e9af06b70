"""Transfers as curves against the overlap of two pupils, counted point by point at the frequency asked."""

import math

import numpy as np
import pytest

import camsim
from camsim.optics import FieldLens, Pupil, Wavefront
from camsim.optics.sampled import sampled_otf
from tests.truth import pupils

NM, N = 550.0, 4.0
POINTS = 500  # a side: boundaries that cut cells leave some 3e-4


def inside(pupil, x, y):
    r = np.hypot(x, y)
    held = r >= pupil["obstruction"]
    if pupil["shape"] == "circular":
        return held & (r <= 1.0)
    corner = pupils.corners(pupil)
    for a, b in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        held &= (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0.0
    return held


def counted(lens, fx, fy):
    """The transfer by its definition: a point's amplitude with the conjugate of that 2λN·f further on."""
    extent = math.sqrt(2.0)
    place = extent * ((2.0 * np.arange(POINTS) + 1.0) / POINTS - 1.0)
    x, y = np.meshgrid(place, place)
    here = inside(lens["pupil"], x, y)
    there = here & inside(lens["pupil"], x + (sx := 2.0 * N * NM / 1e3 * fx), y + (sy := 2.0 * N * NM / 1e3 * fy))
    x, y = x[there], y[there]
    phase = pupils.waves(lens, x, y, NM) - pupils.waves(lens, x + sx, y + sy, NM)
    return np.exp(2j * np.pi * phase).sum() / np.count_nonzero(here)


PUPILS = [
    {"shape": "circular", "obstruction": 0.0},
    {"shape": "circular", "obstruction": 0.4},
    {"shape": "square", "obstruction": 0.0, "rotate_deg": 20.0},
    {"shape": "bladed", "obstruction": 0.0, "blades": 5, "rotate_deg": 7.0},
    {"shape": "bladed", "obstruction": 0.3, "blades": 8, "rotate_deg": 0.0},
]


WAVES = ((4, 0.1), (8, 0.1)), ((4, 1.2), (12, 0.3), (7, -0.4)), ((2, 3.0), (5, 0.6))


@pytest.mark.parametrize(("pupil", "zernike_waves"), list(zip(PUPILS, (*WAVES, *WAVES[:2]), strict=True)))
def test_any_pupil_and_wavefront(pupil, zernike_waves, rng):
    lens = Wavefront(f_number=N, zernike_waves=zernike_waves, reference_nm=NM, pupil=Pupil(**pupil))
    truth = {"f_number": N, "zernike_waves": zernike_waves, "reference_nm": NM, "defocus_um": 0.0, "pupil": pupil}
    size = lens.cutoff_per_um(NM) * np.concatenate([[0.0, 0.003, 0.02], rng.uniform(0.0, 1.02, 5)])
    turn = rng.uniform(0.0, 2.0 * np.pi, size.size)
    fx, fy = size * np.cos(turn), size * np.sin(turn)
    expected = [counted(truth, *each) for each in zip(fx.tolist(), fy.tolist(), strict=True)]
    np.testing.assert_allclose(sampled_otf(lens, fx, fy, NM), expected, rtol=0.0, atol=1e-3)


def test_steeper_wavefronts_take_more_points(rng):
    """Twelve waves from middle to rim, with and without a tilt of forty: against the integral at each frequency."""
    lens = Wavefront(f_number=N, zernike_waves={1: 10.0, 4: 3.5, 14: 0.2})
    size = np.concatenate([np.linspace(0.0, 0.05, 12), rng.uniform(0.05, 1.0, 6)]) / 2.2
    fx, fy = 0.8 * size, -0.6 * size
    np.testing.assert_allclose(sampled_otf(lens, fx, fy, NM), lens.otf(fx, fy, NM), rtol=0.0, atol=1e-3)


def test_a_field_lens_on_its_axis_and_a_place_of_it():
    lens = FieldLens(
        f_number=N, wavelength_nm=[550.0], zernike=[4, 8], waves=[[[0.1, 0.0], [0.3, 0.2]]], height_um=[0.0, 5e3]
    )
    fx, fy = np.array([0.0, 0.1, 0.3]), np.array([0.05, 0.0, 0.1])
    np.testing.assert_allclose(sampled_otf(lens, fx, fy, NM), lens.otf(fx, fy, NM), rtol=0.0, atol=1e-3)
    placed = lens.at(3e3, 4e3)
    np.testing.assert_allclose(sampled_otf(placed, fx, fy, NM), placed.otf(fx, fy, NM), rtol=0.0, atol=1e-3)


def test_others_are_asked_themselves():
    f = np.linspace(0.0, 0.4, 9)
    for lens in (camsim.Airy(f_number=N), camsim.MeasuredPsf(irradiance=((0, 1), (1, 2)), spacing_um=1.0)):
        np.testing.assert_array_equal(sampled_otf(lens, f, 0.5 * f, NM), lens.otf(f, 0.5 * f, NM))

    class Custom(Wavefront):
        def otf(self, fx_per_um, fy_per_um, wavelength_nm):
            return np.exp(-np.hypot(fx_per_um, fy_per_um))

    np.testing.assert_array_equal(sampled_otf(Custom(f_number=N), f, 0.0 * f, NM), np.exp(-f))
