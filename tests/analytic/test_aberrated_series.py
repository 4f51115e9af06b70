"""An aberrated pattern by Zernike series, and its transfer by overlaps: two roads, each against a third."""

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.kernels import kernel
from camsim.optics import OpticalSystem, Pupil, Wavefront
from camsim.rendering.aberrated import polar_kernels
from camsim.rendering.aberrated.series import series_of
from camsim.rendering.angular import Transfer
from camsim.rendering.check import overlap
from camsim.rendering.check.overlap_sizes import sizes_of
from camsim.rendering.render import plan_render

NM = 550.0


def random_lens(seed, rms, obstruction=0.0, f_number=4.0):
    rng = np.random.default_rng(seed)
    indices = rng.choice(np.arange(1, 22), 5, replace=False)
    waves = rng.normal(size=5)
    waves *= rms / np.hypot.reduce(waves)
    pairs = dict(zip(indices.tolist(), waves.tolist(), strict=True))
    return Wavefront(f_number=f_number, zernike_waves=pairs, pupil=Pupil(obstruction=obstruction))


@kernel()
def rows_of(x, bessels, out):
    for n in range(x.size):
        polar_kernels._bessel_row(x[n], bessels, out[n])


@pytest.mark.parametrize("last", [0, 1, 2, 7, 30, 150])
def test_bessel_functions_of_all_orders(last):
    x = np.concatenate([np.geomspace(1e-6, 2000.0, 600), np.linspace(0.8 * last + 0.1, 1.2 * last + 1.0, 300)])
    found = np.empty((x.size, last + 1))
    rows_of(x, polar_kernels.BESSELS, found)
    assert np.abs(found - special.jv(np.arange(last + 1), x[:, None])).max() < 2e-13


@pytest.mark.parametrize(("seed", "rms", "obstruction"), [(1, 0.1, 0.0), (2, 1.5, 0.0), (3, 0.5, 0.3), (4, 1.0, 0.6)])
def test_a_series_makes_the_pattern_that_transforms_of_the_pupil_make(seed, rms, obstruction):
    lens = random_lens(seed, rms, obstruction)
    rest, blur_um = lens.split().rest, lens.blur_um(NM)
    x_um, y_um = np.linspace(-25.0, 25.0, 41) * blur_um, np.linspace(-9.0, 9.0, 13) * blur_um
    right = lens.point_spread_on(x_um, y_um, NM, 1e-13)
    x, y = np.meshgrid(x_um - rest.moved_um[0], y_um - rest.moved_um[1])
    z, angle = np.pi * np.hypot(x, y) / blur_um, np.arctan2(y, x)
    series = series_of(rest, np.array([NM]), 1e-11)[0]
    around = series.around(angle.ravel()).reshape(len(series.terms), series.degree + 1, *angle.shape)
    n = np.arange(series.degree + 1)[:, None, None]
    amplitude = sum(
        sign * radius**2 * np.sum(own * special.jv(n + 1, radius * z) / (radius * z), axis=0)
        for sign, radius, own in zip((1.0, -1.0), (1.0, obstruction), around, strict=False)
    )
    found = np.pi / blur_um**2 / (1.0 - obstruction**2) * np.abs(amplitude) ** 2
    assert np.abs(found - right).max() < 1e-9 * np.pi / blur_um**2


@pytest.mark.parametrize(("seed", "rms", "obstruction"), [(5, 0.1, 0.0), (6, 0.7, 0.0), (7, 0.3, 0.4)])
def test_the_engines_transfer_is_the_lens_s_but_for_what_is_cut_off(seed, rms, obstruction):
    """A taper takes what lies beyond the reach: what a line of contrast 1 shows there, and that is in a transfer."""
    tolerance, pitch_um = 1e-6, 2.0
    lens = random_lens(seed, rms, obstruction)
    plan = plan_render(
        camsim.Scene(background=1.0, shapes=[camsim.Rectangle(width_um=900.0, height_um=900.0, reflectance=0.0)]),
        OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=pitch_um)]),
        camsim.Grid(rows=300, cols=300, pitch_um=pitch_um),
        response=np.ones((1, 1)),
        wavelength_nm=np.array([NM]),
        tolerance=tolerance,
        method="boundary",
    ).plan
    pattern, rest = plan.short.pattern, lens.split().rest
    rng = np.random.default_rng(seed)
    f, angle = rng.uniform(0.05, 0.9, 40) / lens.blur_um(NM), rng.uniform(0.0, 2.0 * np.pi, 40)
    fx, fy = f * np.cos(angle), f * np.sin(angle)
    turn = np.exp(2j * np.pi * (fx * rest.moved_um[0] + fy * rest.moved_um[1]))
    # The background is 1 and the square 0: its contrast is −1.
    found = -pattern.transfers.at(fx * pitch_um, fy * pitch_um)[0]
    assert np.abs(found - rest.otf(fx, fy, NM) * turn).max() < 100.0 * tolerance


def test_a_series_follows_every_single_term():
    """sin 9θ is nothing at 18 angles, R₁₂⁰ at Gauss's six radii: 0.07 off at any tolerance, seen."""
    t, w = special.roots_legendre(60)
    rho, angle = np.sqrt(0.5 * (1.0 + t))[:, None], 2.0 * np.pi * np.arange(301) / 301.0
    for index in range(3, 91):
        rest = Wavefront(f_number=4.0, zernike_waves={index: 0.05}).split().rest
        shift = np.array(rest.moved_um) / (2.0 * rest.blur_um(NM))
        waves = rest.lens.waves(rho * np.cos(angle), rho * np.sin(angle), NM)
        phase = np.exp(2j * np.pi * (waves - rho * (shift[0] * np.cos(angle) + shift[1] * np.sin(angle))))
        own = series_of(rest, np.array([NM]), 1e-7)[0].around(angle)[0]
        # Each degree's part of the phase factor on the rim, and the factor's mean over the disc.
        mean = 0.5 * np.sum(w[:, None] * phase) / angle.size
        assert abs(own[0].mean() - mean) < 1e-6, index
        rim = sum(own[n] * 1j**n for n in range(len(own)))
        edge = np.exp(2j * np.pi * (rest.lens.waves(np.cos(angle), np.sin(angle), NM)))
        turn = np.exp(-2j * np.pi * (shift[0] * np.cos(angle) + shift[1] * np.sin(angle)))
        assert np.abs(rim - edge * turn).max() < 1e-4, index


@pytest.mark.parametrize("index", [45, 67, 84, 121])
def test_single_terms_that_nodes_were_blind_to(index):
    lens = Wavefront(f_number=4.0, zernike_waves={index: 0.05})
    scene = camsim.Scene(
        background=1.0, shapes=[camsim.Rectangle(width_um=14.0, height_um=9.0, rotate_deg=20.0, reflectance=0.0)]
    )
    grid = camsim.Grid(rows=5, cols=6, pitch_um=4.0)
    images = {
        method: camsim.render(scene, [lens, camsim.SquarePhotosite(side_um=4.0)], grid, wavelength_nm=NM,
                              tolerance=1e-6, method=method)
        for method in ("boundary", "fourier")
    }  # fmt: skip
    assert np.abs(images["boundary"].image - images["fourier"].image).max() <= 0.5e-6
    assert max(found.error_estimate for found in images.values()) <= 0.5e-6


@pytest.mark.parametrize("colours", [1, 12])
@pytest.mark.parametrize("waves", [{4: 0.1, 8: 0.05}, {1: 0.3, 3: -0.1, 6: 0.08, 12: 0.05}])
def test_overlaps_that_are_followed_are_the_lens_s(waves, colours):
    rest = Wavefront(f_number=4.0, zernike_waves=waves).split().rest
    nm = np.linspace(420.0, 680.0, colours) if colours > 1 else np.array([NM])
    weights = np.stack([np.exp(-(((nm - peak) / 50.0) ** 2)) for peak in (460.0, 600.0)]) / colours
    step = 0.6 / rest.blur_um(nm.max()) / np.array([5.0, 4.0])
    fx, fy = step[0] * np.arange(6), step[1] * np.arange(-4, 5)
    sizes = sizes_of(rest, float(nm.min()), float(nm.max()), 1e-6, 1e7)
    found = overlap.Overlapping(rest=rest, sizes=sizes).fused(nm, weights, 1e-6)
    found = found.on_half_plane((step[0], step[1]), (6, 5))
    right = np.zeros((2, 9, 6), complex)
    for wavelength, own in zip(nm.tolist(), weights.T, strict=True):
        right += np.multiply.outer(own, rest.otf(fx[None], fy[:, None], wavelength))
    inside = np.hypot(fx[None], fy[:, None]) < 0.93 / rest.blur_um(nm.max())  # a cut-off falls between two rows
    assert np.abs(found - right)[:, inside].max() < 3e-6


@pytest.mark.parametrize(("steps", "counts"), [((0.1, 0.1), (40, 40)), ((0.1, 0.1), (37, 21)), ((0.2, 0.07), (9, 50))])
def test_lattices_are_looked_up_as_places_are(steps, counts):
    """What is looked up at one place serves seven others: each harmonic of either kind, even and odd."""
    rng = np.random.default_rng(12)
    order, sine = np.array([0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6]), np.array([0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1])
    transfer = Transfer.of(rng.normal(size=(40, 13, 3)), 10.0, order, sine, 3.3)
    found = transfer.on_quarters(steps, counts)
    x, y = np.meshgrid(steps[0] * np.arange(counts[0]), steps[1] * np.arange(counts[1]))
    for side, sign in enumerate((1.0, -1.0)):
        right = transfer.at(x.ravel(), sign * y.ravel()).reshape(3, *x.shape)
        assert np.abs(found[:, side, :, 0] + 1j * found[:, side, :, 1] - right).max() < 1e-12
