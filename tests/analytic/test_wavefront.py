"""Lenses with aberrations against closed forms, integrals derived otherwise, and brute force over the pupil."""

import dataclasses
import math

import numpy as np
import pytest
import scipy.special
from scipy import integrate

import camsim
from camsim.numerics.zernike import orders, zernike, zernike_sum
from camsim.optics import OpticalSystem, Pupil, Wavefront
from camsim.optics.airy import airy_otf
from camsim.optics.transfer_table import in_directions, transfer_table
from camsim.rendering.render import render_channels
from tests.truth import pupils, rays

NM, N = 500.0, 4.0  # λN = 2 µm
LAMBDA_N = 2.0


@pytest.fixture
def frequencies(rng):
    """Frequencies all over the pass band and a little beyond, cycles/µm."""
    return rng.uniform(-0.55, 0.55, (2, 60))


def test_without_aberrations_a_circle_makes_an_airy_pattern(frequencies):
    lens = Wavefront(f_number=N)
    fx, fy = frequencies
    expected = airy_otf(np.hypot(fx, fy), f_number=N, wavelength_nm=NM)
    np.testing.assert_allclose(lens.otf(fx, fy, NM), expected, rtol=0, atol=1e-12)
    x = 0.37 * np.arange(-40, 41)
    expected = camsim.Airy(f_number=N).point_spread(np.hypot(x, x[:, None]), NM)
    np.testing.assert_allclose(lens.point_spread_on(x, x, NM, 1e-14), expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("turn_deg", [0.0, 30.0])
def test_a_square_pupil_makes_triangles(frequencies, turn_deg):
    angle = math.radians(turn_deg)
    fx, fy = frequencies
    along = fx * math.cos(angle) + fy * math.sin(angle)
    across = fy * math.cos(angle) - fx * math.sin(angle)
    expected = np.maximum(1 - np.abs(along) * LAMBDA_N, 0) * np.maximum(1 - np.abs(across) * LAMBDA_N, 0)
    lens = Wavefront(f_number=N, pupil=Pupil(shape="square", rotate_deg=turn_deg))
    np.testing.assert_allclose(lens.otf(fx, fy, NM), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("obstruction", [0.1, 0.4, 0.9])
def test_an_obstruction_by_two_roads(frequencies, obstruction):
    """The overlap integrated within its boundaries, and the areas of overlapping circles added up."""
    fx, fy = frequencies
    integrated = Wavefront(f_number=N, pupil=Pupil(obstruction=obstruction))
    closed = camsim.AnnularAiry(f_number=N, obstruction=obstruction)
    np.testing.assert_allclose(integrated.otf(fx, fy, NM), closed.otf(fx, fy, NM), rtol=0, atol=1e-11)
    x = 0.37 * np.arange(-20, 21)
    np.testing.assert_allclose(
        integrated.point_spread_on(x, x, NM, 1e-14),
        closed.point_spread(np.hypot(x, x[:, None]), NM),
        rtol=0,
        atol=1e-13,
    )


@pytest.mark.parametrize("obstruction", [0.2, 0.6])
@pytest.mark.parametrize("r_um", [0.4, 40.0, 900.0])
def test_energy_behind_an_obstruction_is_the_pattern_added_up(obstruction, r_um):
    lens = camsim.AnnularAiry(f_number=N, obstruction=obstruction)
    inside, _ = integrate.quad(
        lambda r: float(lens.point_spread(np.array(r), NM)) * 2 * np.pi * r, 0.0, r_um, limit=4000, epsabs=1e-12
    )
    assert float(lens.encircled_energy(np.array(r_um), NM)) == pytest.approx(inside, abs=1e-10)


def test_zernike_polynomials_are_those_of_the_standard(rng):
    """The first fifteen, as the standard prints them."""
    r, t = np.sqrt(rng.uniform(size=20)), rng.uniform(0, 2 * np.pi, 20)
    table = [
        np.ones(20),
        2 * r * np.sin(t),
        2 * r * np.cos(t),
        np.sqrt(6) * r**2 * np.sin(2 * t),
        np.sqrt(3) * (2 * r**2 - 1),
        np.sqrt(6) * r**2 * np.cos(2 * t),
        np.sqrt(8) * r**3 * np.sin(3 * t),
        np.sqrt(8) * (3 * r**3 - 2 * r) * np.sin(t),
        np.sqrt(8) * (3 * r**3 - 2 * r) * np.cos(t),
        np.sqrt(8) * r**3 * np.cos(3 * t),
        np.sqrt(10) * r**4 * np.sin(4 * t),
        np.sqrt(10) * (4 * r**4 - 3 * r**2) * np.sin(2 * t),
        np.sqrt(5) * (6 * r**4 - 6 * r**2 + 1),
        np.sqrt(10) * (4 * r**4 - 3 * r**2) * np.cos(2 * t),
        np.sqrt(10) * r**4 * np.cos(4 * t),
    ]
    for index, expected in enumerate(table):
        np.testing.assert_allclose(zernike(index, r * np.cos(t), r * np.sin(t)), expected, rtol=0, atol=1e-13)


def test_zernike_polynomials_of_all_orders_are_jacobis(rng):
    """To rounding, where powers of r² lose seven digits; at a square pupil's corners too, where they grow as 2.4ⁿ."""
    x, y = rng.uniform(-1.0, 1.0, (2, 400))
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    all_of_them, coefficients = np.zeros_like(x), rng.normal(size=231)
    for index, coefficient in enumerate(coefficients.tolist()):
        n, m = orders(index)
        radial = r ** abs(m) * scipy.special.eval_jacobi((n - abs(m)) // 2, 0, abs(m), 2.0 * r**2 - 1.0)
        expected = (
            np.sqrt((n + 1.0) * (2.0 if m else 1.0)) * radial * (np.sin(-m * angle) if m < 0 else np.cos(m * angle))
        )
        scale = np.maximum(1.0, np.abs(r) ** n * 2.5**n * (r > 1.0))
        assert (np.abs(zernike(index, x, y) - expected) <= 1e-13 * scale).all(), index
        all_of_them += coefficient * expected
    assert orders(230) == (20, 20)
    inside = r <= 1.0
    found = zernike_sum(tuple(range(231)), coefficients.tolist(), x, y)
    np.testing.assert_allclose(found[inside], all_of_them[inside], rtol=0, atol=3e-12)


@pytest.mark.parametrize("waves", [0.3, 1.0, 2.5])
def test_defocus_by_a_single_integral(waves):
    """Hopkins's defocused lens: the phases of two shifted pupils differ by a straight ramp, so one integral is left.

    With W = w·r² the difference over a shift s is 2·w·s·x, and the overlap's height at x is that of one circle.
    """
    lens = Wavefront(f_number=N, zernike_waves=((4, waves / (2 * math.sqrt(3))),), reference_nm=NM)
    for s in (0.1, 0.5, 1.2, 1.8):
        expected, _ = integrate.quad(
            lambda x, s=s: math.sqrt(1 - (x + s / 2) ** 2) * math.cos(4 * math.pi * waves * s * x),
            0.0,
            1 - s / 2,
            limit=400,
            epsabs=1e-12,
        )
        value = lens.otf(np.array(0.6 * s / (2 * LAMBDA_N)), np.array(0.8 * s / (2 * LAMBDA_N)), NM)
        assert value == pytest.approx(4 / math.pi * expected, abs=1e-10)


def test_a_focus_shift_is_a_path_difference(frequencies):
    """δ/(8N²) at the rim: 16 µm behind f/4 are 0.125 µm, a quarter wave of 500 nm."""
    shifted = Wavefront(f_number=N, defocus_um=16.0)
    named = Wavefront(f_number=N, zernike_waves=((4, 0.25 / (2 * math.sqrt(3))),), reference_nm=NM)
    np.testing.assert_allclose(shifted.otf(*frequencies, NM), named.otf(*frequencies, NM), rtol=0, atol=1e-11)
    # Path differences are lengths: at twice the wavelength they are half as many waves.
    np.testing.assert_allclose(
        shifted.otf(*frequencies, 2 * NM),
        Wavefront(f_number=N, zernike_waves=((4, 0.125 / (2 * math.sqrt(3))),), reference_nm=2 * NM).otf(
            *frequencies, 2 * NM
        ),
        rtol=0,
        atol=1e-11,
    )


@pytest.mark.parametrize("index", [3, 4, 8, 24])
def test_small_aberrations_lower_the_peak_as_marechal_says(index):
    for waves in (0.01, 0.03):
        lens = Wavefront(f_number=N, zernike_waves=((index, waves),), reference_nm=NM)
        assert lens.strehl(NM) == pytest.approx(math.exp(-((2 * math.pi * waves) ** 2)), abs=(2 * math.pi * waves) ** 3)
        x = np.array([-1e-3, 0.0, 1e-3])
        peak = lens.point_spread_on(x, x, NM, 1e-13)[1, 1]
        assert peak / (math.pi / 4 / LAMBDA_N**2) == pytest.approx(lens.strehl(NM), abs=1e-10)


class Straight(Wavefront):
    """A lens that inherits a tilt and has none."""

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return Wavefront(f_number=self.f_number).otf(fx_per_um, fy_per_um, wavelength_nm)


@pytest.mark.parametrize("pupil", [Pupil(), Pupil(shape="square", rotate_deg=20.0)], ids=["circle", "square"])
@pytest.mark.parametrize("others", [(), ((0, 0.7), (8, 0.1))], ids=["alone", "and coma"])
def test_tilt_moves_the_image_without_changing_it(frequencies, pupil, others):
    fx, fy = frequencies
    lens = Wavefront(f_number=N, zernike_waves=((2, 0.3), *others, (1, -0.2)), reference_nm=NM, pupil=pupil)
    level, moved_um = lens.without_tilt()
    right_um, down_um = 4 * 0.3 * LAMBDA_N, -4 * 0.2 * LAMBDA_N
    assert level == dataclasses.replace(lens, zernike_waves=others)
    assert moved_um == pytest.approx((right_um, down_um), rel=1e-12)
    for nm in (NM, 0.7 * NM):
        expected = level.otf(fx, fy, nm) * np.exp(-2j * np.pi * (fx * right_um + fy * down_um))
        np.testing.assert_allclose(lens.otf(fx, fy, nm), expected, rtol=0, atol=2e-11)  # two, each to 1e-11


def test_a_lens_of_ones_own_tilts_as_its_transfer_says():
    system = OpticalSystem(lens=Straight(f_number=N, zernike_waves=((2, 0.3),)))
    assert system.without_tilt() == (system, (0.0, 0.0))


@pytest.mark.parametrize("turned", [False, True])
def test_a_pattern_far_along_one_axis_is_as_exact_as_near(turned):
    """A narrow strip of the lattice, 200 λN long: the Airy pattern's rings in closed form."""
    long_um, short_um = np.linspace(-400.0, 400.0, 401), np.array([-1.0, 0.0, 1.0])
    x_um, y_um = (short_um, long_um) if turned else (long_um, short_um)
    pattern = camsim.Wavefront(f_number=4.0).point_spread_on(x_um, y_um, 500.0, 1e-12)
    expected = rays.airy_psf(np.hypot(x_um, y_um[:, None]), 2.0)
    np.testing.assert_allclose(pattern, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "lens",
    [
        Wavefront(f_number=4.0, defocus_um=30.0, pupil=Pupil(shape="bladed", blades=3, rotate_deg=10.0)),
        Wavefront(f_number=4.0, zernike_waves=((7, 0.1), (5, 0.2)), pupil=Pupil(shape="square", obstruction=0.3)),
        Wavefront(
            f_number=4.0, zernike_waves=((4, 0.15), (6, 0.1)), pupil=Pupil(shape="bladed", blades=8, obstruction=0.4)
        ),
        Wavefront(f_number=4.0, zernike_waves=((8, 0.2),), pupil=Pupil(obstruction=0.4)),
    ],
    ids=["triangle out of focus", "square", "iris", "ring"],
)
def test_the_transfer_is_the_transform_of_the_pattern(lens):
    """Summed over a lattice of half the pattern's finest wave, 160 λN wide: what is beyond is a hundredth at most."""
    x = 0.5 * np.arange(-320, 321)  # λN = 2 µm, the pattern's waves 1.4 µm and longer
    pattern = lens.point_spread_on(x, x, 500.0, 1e-12)
    for fx, fy in ((0.05, 0.0), (0.0, 0.07), (0.1, -0.06), (-0.15, -0.1)):
        expected = np.exp(-2j * np.pi * fy * x) @ pattern @ np.exp(-2j * np.pi * fx * x) * 0.25
        assert complex(lens.otf(np.array(fx), np.array(fy), 500.0)) == pytest.approx(expected, abs=5e-3)


@pytest.mark.parametrize(
    "pupil",
    [
        Pupil(),
        Pupil(obstruction=0.4),
        Pupil(shape="square", rotate_deg=20.0),
        Pupil(shape="bladed", blades=5, obstruction=0.3),
    ],
    ids=["circle", "ring", "square", "iris"],
)
@pytest.mark.parametrize("waves", [0.1, 1.5])
def test_the_size_of_a_transfer_is_known_well_enough_for_a_bound(pupil, waves):
    """What a lattice over the pupil makes of it, against the overlap within its boundaries."""
    lens = Wavefront(f_number=N, zernike_waves=((8, waves), (12, -0.4 * waves)), reference_nm=NM, pupil=pupil)
    f = np.linspace(0.0, 1.05, 12) * lens.cutoff_per_um(NM)
    for angle in (0.0, 0.25 * math.pi, 1.0):
        direction = (math.cos(angle), math.sin(angle))
        exact = np.abs(lens.otf(f * direction[0], f * direction[1], NM))
        np.testing.assert_allclose(lens.otf_size(f, direction, NM), exact, rtol=0, atol=0.01)


def test_waves_in_the_corners_of_a_square_are_followed():
    """40 waves there, of order 7."""
    lens = Wavefront(f_number=N, zernike_waves=((28, 0.15), (30, 0.1)), pupil=Pupil(shape="square"))
    t, w = np.polynomial.legendre.leggauss(250)
    total = w @ np.exp(2j * np.pi * lens.waves(*np.meshgrid(t, t), 425.0)) @ w
    assert lens.strehl(425.0) == pytest.approx(abs(total / 4.0) ** 2, rel=1e-8)


def test_coma_points_to_the_right():
    """A positive coefficient 8: the bright head at the left of the light's centre, the tail to its right."""
    lens = Wavefront(f_number=N, zernike_waves=((8, 0.3),), reference_nm=NM)
    x = 0.25 * np.arange(-60, 61)
    pattern = lens.point_spread_on(x, x, NM, 1e-12)
    centre = np.sum(pattern * x) / pattern.sum()
    brightest = x[np.unravel_index(np.argmax(pattern), pattern.shape)[1]]
    assert brightest < centre
    np.testing.assert_allclose(pattern, pattern[::-1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("obstruction", [0.0, 0.4])
@pytest.mark.parametrize("index", [40, 112, 144, 152, 230])
def test_single_terms_of_all_orders_are_summed_over_the_pupil(index, obstruction):
    """R₁₄ and R₂₀ were refused; of cos 16θ one harmonic of 34 was seen, of sin 12θ nothing along 24 even rays."""
    lens = Wavefront(f_number=N, zernike_waves={index: 0.3}, reference_nm=NM, pupil=Pupil(obstruction=obstruction))
    x = np.linspace(-25.0, 25.0, 7)
    found = lens.point_spread_on(x, x[:3], NM, 1e-14)
    r, w = np.polynomial.legendre.leggauss(160)
    r, w = obstruction + 0.5 * (1.0 - obstruction) * (1.0 + r), 0.5 * (1.0 - obstruction) * w
    angle = 2.0 * np.pi * np.arange(601) / 601
    px, py = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))
    pupil = (r * w)[:, None] * np.exp(2j * np.pi * lens.waves(px, py, NM)) * (2.0 * np.pi / 601)
    for (row, col), seen in np.ndenumerate(found):
        amplitude = np.sum(pupil * np.exp(-1j * np.pi / LAMBDA_N * (x[col] * px + x[row] * py)))
        assert seen == pytest.approx(abs(amplitude) ** 2 / (4.0 * LAMBDA_N**2 * lens.pupil.area), abs=1e-12)


@pytest.mark.parametrize(
    "pupil",
    [
        {"shape": "square"},
        {"shape": "square", "rotate_deg": 31.0},
        *({"shape": "bladed", "blades": blades, "rotate_deg": 7.0} for blades in (3, 5, 12)),
    ],
    ids=str,
)
@pytest.mark.parametrize("middle", [(0.0, 0.0), (0.0, 500.0), (300.0, -250.0)])
def test_waves_that_run_along_the_sides_of_a_pupil_are_followed(pupil, middle):
    """A polygon's transform is a sum over its sides. Of such waves nodes lost 1e-2: light of its own, far out."""
    lens = camsim.Wavefront(f_number=4.0, pupil=camsim.Pupil(**pupil))
    corners = pupils.corners({"rotate_deg": 0.0} | pupil)
    along = np.roll(corners, -1, axis=0) - corners
    k_x, k_y = (at + np.linspace(-60.0, 60.1, 4) for at in middle)  # radians on half of the diameter
    found = lens.point_spread_on(k_x * LAMBDA_N / np.pi, k_y * LAMBDA_N / np.pi, NM, 1e-14)
    for (row, col), seen in np.ndenumerate(found):
        k = np.array([k_x[col], k_y[row]])
        sides = np.exp(-1j * (corners + 0.5 * along) @ k) * np.sinc(along @ k / (2.0 * np.pi))
        exact = 1j * np.sum(sides * (k[0] * along[:, 1] - k[1] * along[:, 0])) / (k @ k)
        assert seen == pytest.approx(abs(exact) ** 2 / (4.0 * LAMBDA_N**2 * lens.pupil.area), abs=1e-12)


def test_a_lattice_may_be_coarser_than_the_pattern():
    """Points farther apart than λN turn by more than once from node to node."""
    x = 1.7 * LAMBDA_N * np.arange(-50.0, 51.0)
    found = Wavefront(f_number=N).point_spread_on(x, x, NM, 1e-12)
    np.testing.assert_allclose(found, rays.airy_psf(np.hypot(x, x[:, None]), LAMBDA_N), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("contrast", [1e-15, 1e-7])
def test_a_contrast_that_nobody_could_see(contrast):
    """All weights are nothing: there are no transfers to add, which was a crash."""
    faint = camsim.Rectangle(width_um=9.0, height_um=9.0, reflectance=0.5 + contrast)
    lens = Wavefront(f_number=N, zernike_waves={8: 0.1}, pupil=Pupil(shape="square"))
    grid, light = camsim.Grid(rows=5, cols=6, pitch_um=4.0), {"response": np.ones((1, 5)), "tolerance": 1e-2}
    system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=4.0)])
    scene = camsim.Scene(background=0.5, shapes=[faint])
    channel, nm = np.zeros((5, 6), np.uint8), np.linspace(500.0, 600.0, 5)
    found = render_channels(scene, system, grid, channel=channel, wavelength_nm=nm, method="fourier", **light)
    np.testing.assert_allclose(found.image, 0.5 * 5, rtol=1e-6)


@pytest.mark.parametrize("zernike_waves", [(10, 0.94), (28, 0.3)])
def test_a_table_is_right_in_every_direction(zernike_waves):
    """Leaves vanish along some directions, where the transfer is that of a clear pupil."""
    lens, allowed = camsim.Wavefront(f_number=6.9, zernike_waves=(zernike_waves,)), 1e-6
    table = transfer_table(lens, (587.0,), allowed)
    share = np.linspace(0.02, 0.98, 61)
    per_um = share / (1e-3 * 587.0 * 6.9)
    for angle in (0.0, 0.13, 0.39):
        found = in_directions(table.at(per_um), 256, angle)[0, :, ::64]
        for k, turned in enumerate(angle + np.pi * np.arange(4) / 4):
            right = lens.otf(per_um * np.cos(turned), per_um * np.sin(turned), 587.0)
            assert np.abs(found[:, k] - right).max() <= 2.0 * allowed
