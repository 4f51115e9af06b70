"""Lenses given by numbers: a transfer as a curve, a pattern or a transfer as a table."""

import numpy as np
import pytest
from scipy import integrate, special

import camsim

SQUARE = camsim.SquarePhotosite(side_um=1.0)
SCENE = camsim.Scene(
    background=1.0, shapes=[camsim.Polygon(points_um=((-5.0, -7.0), (9.0, -4.0), (1.0, 8.0)), reflectance=0.0)]
)
GRID = camsim.Grid(rows=16, cols=18, pitch_um=1.0)


def image(lens, tolerance=1e-8):
    return camsim.render(
        SCENE, [lens, SQUARE], GRID, wavelength_nm=500.0, tolerance=tolerance, method="fourier", strict=True
    ).image


def airy_curve(points):
    frequency = np.linspace(0.0, 0.5, points)
    values = camsim.Airy(f_number=4.0).otf(frequency, np.zeros(points), 500.0)
    return camsim.RadialOtf(freq_per_um=tuple(frequency), values=tuple(values))


def test_a_curve_through_an_airy_transfer_makes_nearly_its_image():
    exact = image(camsim.Airy(f_number=4.0), 1e-6)
    apart = [np.abs(image(airy_curve(points), 1e-6) - exact).max() for points in (17, 65)]
    assert apart[1] < 0.15 * apart[0] < 0.15 * 2e-3


def test_a_curves_pattern_and_energy_are_its_hankel_transforms():
    lens = camsim.RadialOtf(freq_per_um=(0.0, 0.1, 0.25, 0.4), values=(1.0, 0.5, -0.1, 0.0))
    for r_um in (0.0, 0.7, 5.0, 60.0):
        pattern, energy = 0.0, 0.0
        for low, high in ((0.0, 0.1), (0.1, 0.25), (0.25, 0.4)):
            for bessel, kind in ((special.j0, 0), (special.j1, 1)):
                part, _ = integrate.quad(
                    lambda f, bessel=bessel, kind=kind, r_um=r_um: (
                        float(lens.otf(np.array(f), np.array(0.0), 500.0))
                        * (2 * np.pi * f if kind == 0 else 2 * np.pi * r_um)
                        * bessel(2 * np.pi * f * r_um)
                    ),
                    low,
                    high,
                    limit=500,
                    epsabs=1e-12,
                )
                pattern, energy = (pattern + part, energy) if kind == 0 else (pattern, energy + part)
        assert float(lens.point_spread(np.array(r_um), 500.0)) == pytest.approx(pattern, abs=1e-11)
        assert float(lens.encircled_energy(np.array(r_um), 500.0)) == pytest.approx(energy, abs=1e-10)


@pytest.mark.parametrize("turn", [0.0, 20.0, 74.5])
def test_a_disc_behind_a_long_and_narrow_pattern_has_sides_for_its_narrow_direction(turn):
    """They were made for four directions of the lens: too long by twice the tolerance, which the check shares."""
    lens = camsim.EllipticalGaussian.from_axes(sigma_um=0.31, sigma_across_um=0.034, rotate_deg=turn)
    angle = 2.0 * np.pi * np.arange(20_000) / 20_000

    def disc(shape):
        scene = camsim.Scene(background=0.6, shapes=[shape])
        point = camsim.SquarePhotosite(side_um=0.0)
        return camsim.render(scene, [lens, point], GRID, wavelength_nm=500.0, tolerance=3e-6, method="fourier").image

    round_um = 6.4 + 3.65 * np.cos(angle), 7.2 + 3.65 * np.sin(angle)
    many = camsim.Polygon(points_um=tuple(zip(*map(np.ndarray.tolist, round_um), strict=True)), reflectance=0.0)
    one = camsim.Disc(radius_um=3.65, centre_um=(6.4, 7.2), reflectance=0.0)
    np.testing.assert_allclose(disc(one), disc(many), rtol=0.0, atol=1e-6)


def test_a_measured_pattern_goes_through_its_samples():
    """Its transfer, summed back over all frequencies that pass, at the places of the samples."""
    rows, spacing_um = ((0.0, 1.0, 2.0), (3.0, 9.0, 1.0), (0.0, 4.0, 0.0)), 0.5
    lens = camsim.MeasuredPsf(irradiance=rows, spacing_um=spacing_um)
    step = 0.02
    f = np.arange(-0.7, 0.7 + step / 2, step)
    fx, fy = np.meshgrid(f / spacing_um, f / spacing_um)
    otf = lens.otf(fx, fy, 550.0)
    for r, row in enumerate(rows):
        for c, sample in enumerate(row):
            wave = np.exp(2j * np.pi * spacing_um * (fx * (c - 1) + fy * (r - 1)))
            assert (otf * wave).sum().real * step**2 == pytest.approx(sample / 20.0, abs=1e-6)


def test_lenses_given_by_numbers_are_f_8_unless_told():
    curve = camsim.RadialOtf(freq_per_um=(0.0, 0.1, 0.2), values=(1.0, 0.4, 0.0))
    assert curve.f_number == camsim.MeasuredPsf(irradiance=((1.0,),), spacing_um=1.0).f_number == 8.0


@pytest.mark.parametrize("shape", [(5, 5), (4, 3), (3, 6), (1, 4)])
def test_a_measured_pattern_is_the_sum_of_its_samples(rng, shape):
    """Each sample a point of light, places counted from the middle of the array; y down, as the rows go."""
    samples = rng.uniform(0.0, 1.0, shape)
    lens = camsim.MeasuredPsf(irradiance=samples.tolist(), spacing_um=0.7)
    y, x = (0.7 * (np.arange(n) - 0.5 * (n - 1)) for n in shape)
    fx, fy = rng.uniform(-0.4 / 0.7, 0.4 / 0.7, (2, 50))
    waves = [np.exp(-2j * np.pi * (u * x + v * y[:, None])) for u, v in zip(fx, fy, strict=True)]
    expected = [(samples * wave).sum() / samples.sum() for wave in waves]
    np.testing.assert_allclose(lens.otf(fx, fy, 550.0), expected, rtol=0, atol=1e-11)
    assert not lens.otf(np.array([0.6 / 0.7, 0.0]), np.array([0.0, 0.6 / 0.7]), 550.0).any()


def test_a_measured_transfer_passes_what_was_measured(rng):
    """At the table's own frequencies the transfer is the table's, in between a sum of waves goes through it."""
    half, step = 20, 0.02
    f = step * np.arange(-half, half + 1)
    fx, fy = np.meshgrid(f, f)
    # A Gaussian that is lopsided by a shift: conjugate at opposite frequencies, nothing in the outer fifth.
    table = np.exp(-2 * np.pi**2 * (9.0 * fx**2 + 6.25 * fy**2) - 2j * np.pi * (0.8 * fx - 1.1 * fy))
    lens = camsim.MeasuredOtf(values=table, spacing_per_um=step)
    within = np.maximum(np.abs(fx), np.abs(fy)) <= 0.8 * half * step
    np.testing.assert_allclose(lens.otf(fx, fy, 500.0)[within], table[within], rtol=0, atol=1e-9)
    between = rng.uniform(-0.25, 0.25, (2, 50))
    expected = np.exp(-2 * np.pi**2 * (9.0 * between[0] ** 2 + 6.25 * between[1] ** 2))
    np.testing.assert_allclose(np.abs(lens.otf(*between, 500.0)), expected, rtol=0, atol=1e-6)
    gaussian = camsim.EllipticalGaussian(covariance_um2=((9.0, 0.0), (0.0, 6.25)))
    moved = camsim.Scene(
        background=1.0,
        shapes=[camsim.Polygon(points_um=((-4.2, -8.1), (9.8, -5.1), (1.8, 6.9)), reflectance=0.0)],
    )
    exact = camsim.render(moved, [gaussian, SQUARE], GRID, wavelength_nm=500.0, tolerance=1e-9).image
    assert np.abs(image(lens) - exact).max() < 1e-6
