"""The optical formulas against definitions: diffraction integrals, ray truth, and transforms by quadrature."""

import math

import numpy as np
import pytest
from scipy import integrate, special

from camsim.errors import UnsupportedError
from camsim.optics import (
    Airy,
    AnnularAiry,
    EllipticalGaussian,
    FourSpotOlpf,
    OpticalSystem,
    SquarePhotosite,
    TwoSpotOlpf,
)
from camsim.optics.airy import airy_otf
from tests.tables import rows
from tests.truth import rays


@pytest.mark.parametrize("frequency", [0.05, 0.3, 0.77, 0.999])
def test_otf_is_the_overlap_of_two_pupils(frequency):
    # Two unit-diameter discs whose centres are `frequency` apart: area of the lens they share, by integration.
    half = 0.5 * frequency
    strip = integrate.quad(lambda x: 2 * math.sqrt(max(0.25 - x * x, 0.0)), half, 0.5, epsabs=1e-13)[0]
    expected = 2 * strip / (math.pi / 4)
    assert airy_otf(np.array(frequency), f_number=2.0, wavelength_nm=500.0) == pytest.approx(expected, abs=1e-10)


def test_otf_vanishes_past_the_cut_off():
    assert np.all(airy_otf(np.array([1.0, 1.0 + 1e-12, 7.0]), f_number=2.0, wavelength_nm=500.0) == 0.0)


def test_system_otf_is_the_transform_of_its_parts():
    system = OpticalSystem.of([SquarePhotosite(side_um=3.0), Airy(f_number=4.0), FourSpotOlpf(split_um=2.5)])
    fx, fy = 0.11, 0.07
    x = np.linspace(-1.5, 1.5, 4001)
    box = np.trapezoid(np.cos(2 * np.pi * fx * x), x) * np.trapezoid(np.cos(2 * np.pi * fy * x), x) / 9.0
    spots = np.mean([np.cos(2 * np.pi * (fx * sx + fy * sy)) for sx in (-1.25, 1.25) for sy in (-1.25, 1.25)])
    r = np.linspace(0, 4000, 4_000_001)  # Hankel transform of the PSF; its tail beyond 4000 µm is below 1e-3
    lens = np.trapezoid(rays.airy_psf(r, 2.2) * special.j0(2 * np.pi * math.hypot(fx, fy) * r) * 2 * np.pi * r, r)
    assert system.otf(np.array(fx), np.array(fy), 550.0) == pytest.approx(lens * box * spots, abs=1e-3)


class Placed:
    def __init__(self, place):
        self.place = place

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return np.ones(np.broadcast(fx_per_um, fy_per_um).shape)


@pytest.mark.parametrize(("stages", "message"), rows("wrong-stages.txt", "stages that make no system"))
def test_stages_that_make_no_system_are_refused(stages, message):
    with pytest.raises(UnsupportedError, match=message):
        OpticalSystem.of(eval(stages))


class Strip:
    """A lens of one's own that says nothing of its band: 4 × 1 cycles/µm, its long side turned by 135°."""

    place = "lens"

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        along, across = (fy_per_um - fx_per_um) / math.sqrt(2.0), (fx_per_um + fy_per_um) / math.sqrt(2.0)
        return np.maximum(1.0 - np.abs(along) / 2.0, 0.0) * np.maximum(1.0 - np.abs(across) / 0.5, 0.0)


def test_the_end_of_an_unknown_band_is_looked_for_in_every_direction():
    found = OpticalSystem.of([Strip(), SquarePhotosite(side_um=1.0)]).cutoff_per_um(550.0)
    assert 2.0 <= found <= 1.001 * math.hypot(2.0, 0.5)


def test_a_stage_without_a_place_is_the_lens_where_there_is_no_other():
    one, besides = Placed(None), Placed(None)
    system = OpticalSystem.of([one, besides, SquarePhotosite(side_um=3.0)])
    assert system.lens is one
    assert system.more == (besides,)
    assert system.stages == (one, besides, SquarePhotosite(side_um=3.0))


def test_a_gaussian_of_two_axes_has_their_variances():
    covariance = np.array(
        EllipticalGaussian.from_axes(sigma_um=2.0, sigma_across_um=0.7, rotate_deg=30.0).covariance_um2
    )
    along, across = np.array([np.cos(np.pi / 6.0), 0.5]), np.array([-0.5, np.cos(np.pi / 6.0)])
    assert along @ covariance @ along == pytest.approx(4.0)
    assert across @ covariance @ across == pytest.approx(0.49)


@pytest.mark.parametrize("obstruction", [0.2, 0.5, 0.8])
def test_energy_never_falls_and_no_table_of_it_ends_in_a_step(obstruction):
    """Light adds up: out to beyond where panels end and a series begins."""
    radius_um = np.linspace(20.0, 420.0, 40_001)
    lens = AnnularAiry(f_number=1.0, obstruction=obstruction)
    energy = lens.encircled_energy(radius_um, 1000.0)
    assert np.diff(energy).min() > -1e-12
    assert np.diff(energy).max() < 1e-4


@pytest.mark.parametrize("rotate_deg", [-90.0, 90.0, 180.0, 270.0, 450.0, 30.0])
@pytest.mark.parametrize("kind", [FourSpotOlpf, TwoSpotOlpf])
def test_plates_turned_by_whole_quarters_are_products(kind, rotate_deg):
    """Spots on the very axes (a cosine of 90° leaves 1e-16), and a transfer that is one of x times one of y."""
    sides = {"split_um": 3.0} | ({"split_y_um": 2.0} if kind is FourSpotOlpf else {})
    filter_ = kind(**sides, rotate_deg=rotate_deg)
    x, y = np.linspace(-1.0, 1.0, 31), np.linspace(-0.7, 0.9, 17)[:, None]
    otf, zero = filter_.otf(x, y, 550.0), np.zeros((1, 1))
    spots = filter_.spots_um()
    as_spots = np.mean(np.exp(-2j * np.pi * (spots[:, 0, None, None] * x + spots[:, 1, None, None] * y)), axis=0)
    assert np.abs(otf - as_spots).max() < 1e-14
    along_x, along_y = filter_.otf(x, zero, 550.0), filter_.otf(zero, y, 550.0)
    if rotate_deg % 90.0:
        assert not filter_.separable
        assert np.abs(otf - along_x * along_y).max() > 0.1
        return
    assert filter_.separable
    assert np.array_equal(otf, along_x * along_y)
    across = 3.0 if rotate_deg % 180.0 == 0.0 else sides.get("split_y_um", 0.0)
    assert np.ptp(spots[:, 0]) == across
