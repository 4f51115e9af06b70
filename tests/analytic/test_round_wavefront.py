"""Wavefronts of revolution: a round pattern by a transform along one line, against Bessel's integral and images."""

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.optics import OpticalSystem, Pupil, Wavefront
from camsim.optics.difference import Difference, RoundDifference
from camsim.optics.zernike import zernike_sum
from camsim.rendering import psf
from camsim.rendering.check.pupils import Otherwise
from camsim.rendering.fourier import engine, ways
from camsim.rendering.render import plan_render, render_channels

NM = 550.0
TERMS = [{4: 0.4}, {4: -2.0, 12: 0.6}, {0: 0.3, 24: 0.2, 40: -0.15}]


def bessel(lens, zernike, r_um):
    """Irradiance by Hankel's integral of the pupil, with Gauss's nodes along a radius."""
    x, weights = np.polynomial.legendre.leggauss(900)
    inner = lens.pupil.obstruction
    rho, weights = inner + 0.5 * (1.0 - inner) * (1.0 + x), 0.5 * (1.0 - inner) * weights
    waves = zernike_sum(tuple(zernike), list(zernike.values()), rho, np.zeros_like(rho))
    of_ring = 2.0 * np.pi * rho * weights * np.exp(2j * np.pi * waves)
    amplitude = special.j0(np.pi / lens.blur_um(NM) * np.multiply.outer(r_um, rho)) @ of_ring
    return np.abs(amplitude) ** 2 / (4.0 * lens.blur_um(NM) ** 2 * np.pi * (1.0 - inner**2))


@pytest.mark.parametrize("obstruction", [0.0, 0.5])
@pytest.mark.parametrize("zernike", TERMS, ids=str)
def test_a_round_pattern_is_hankels_integral_by_both_rules(zernike, obstruction):
    lens = Wavefront(f_number=4.0, zernike_waves=zernike, reference_nm=NM, pupil=Pupil(obstruction=obstruction))
    rest = lens.split().rest
    r_um = lens.blur_um(NM) * np.concatenate([np.linspace(0.0, 20.0, 301), [77.7, 200.0]])
    right = bessel(lens, zernike, r_um)
    for whole in (lens, Otherwise.of(lens)):
        found = whole.point_spread_round(r_um, NM)
        np.testing.assert_allclose(found, right, rtol=0, atol=2e-13 / lens.blur_um(NM) ** 2)
    assert isinstance(rest, RoundDifference)
    less = right - lens.round_core().point_spread(r_um, NM)
    np.testing.assert_allclose(rest.point_spread(r_um, NM), less, rtol=0, atol=2e-13 / lens.blur_um(NM) ** 2)
    along = lens.point_spread_on(r_um[:301], np.zeros(1), NM, 1e-13)[0]
    np.testing.assert_allclose(right[:301], along, rtol=0, atol=1e-12 / lens.blur_um(NM) ** 2)


@pytest.mark.parametrize("zernike", [{8: 0.1}, {4: 0.3, 2: 0.1}, {12: 0.2, 14: 1e-3}, {5: 0.2}], ids=str)
def test_what_does_not_revolve_is_no_round_difference(zernike):
    assert type(Wavefront(f_number=4.0, zernike_waves=zernike).split().rest) is Difference


def test_a_term_of_no_waves_and_a_focus_shift_leave_a_lens_round():
    for lens in (Wavefront(f_number=4.0, zernike_waves={4: 0.1, 8: 0.0}), Wavefront(f_number=4.0, defocus_um=9.0)):
        split = lens.split()
        assert isinstance(split.rest, RoundDifference)
        assert split.moved_um == split.rest.moved_um == (0.0, 0.0)


SCENE = camsim.Scene(
    background=0.1,
    shapes=[
        camsim.Polygon(points_um=[(-31.0, -22.0), (36.0, -17.0), (12.0, 29.0)], reflectance=0.8),
        camsim.Disc(centre_um=(14.0, -16.0), radius_um=9.0, reflectance=0.4),
    ],
)


FOCUS = Wavefront(f_number=4.0, zernike_waves={4: 0.4})
SPREAD = Wavefront(f_number=2.8, zernike_waves={4: 1.2, 12: -0.3})
HOLLOW = Wavefront(f_number=11.0, zernike_waves={4: 0.6}, pupil=Pupil(obstruction=0.4))
FOUR = camsim.FourSpotOlpf(split_um=2.0)


@pytest.mark.parametrize(
    ("lens", "more", "tolerance"),
    [
        (FOCUS, [], 1e-3),
        (FOCUS, [], 1e-9),
        (SPREAD, [FOUR], 1e-6),
        (SPREAD, [FOUR], 1e-9),
        (HOLLOW, [], 1e-3),
        (HOLLOW, [], 1e-6),
    ],
)
def test_curves_lattices_and_edges_make_one_image(monkeypatch, lens, more, tolerance):
    grid = camsim.Grid(rows=11, cols=14, pitch_um=4.0)
    nm = np.array([500.0, 530.0, 610.0])
    kept = {
        "response": np.array([[0.2, 0.5, 0.3]]), "wavelength_nm": nm, "tolerance": tolerance,
        "channel": np.zeros((11, 14), np.uint8),
    }  # fmt: skip
    system = OpticalSystem.of([lens, *more, camsim.SquarePhotosite(side_um=4.0)])
    by_curves = render_channels(SCENE, system, grid, **kept, method="fourier")
    by_edges = render_channels(SCENE, system, grid, **kept, method="boundary")
    others = []
    for number in (2, 3):  # on a lattice, summed over the pupil; and over a rectangle, from what it is along its radius
        with monkeypatch.context() as patch:
            patch.setattr(ways, "PART", np.inf)
            patch.setattr(engine, "ways_of", lambda job, number=number: ways.ways_of(job)[:number][-1:])
            others.append(render_channels(SCENE, system, grid, **kept, method="fourier"))
    for other in (by_edges, *others):
        assert np.abs(by_curves.image - other.image).max() <= 1.2 * tolerance
    for each in (by_curves, by_edges, *others):
        assert each.error_estimate <= tolerance


@pytest.mark.parametrize(("f_number", "tolerance", "curve"), [(4.0, 1e-6, True), (22.0, 1e-2, False)])
def test_a_pattern_is_a_curve_or_on_a_lattice_whatever_takes_less(f_number, tolerance, curve):
    """A few samples in all are made sooner than twenty wavelengths' curves."""
    lens, nm = Wavefront(f_number=f_number, zernike_waves={4: 0.4}), np.linspace(450.0, 650.0, 150)
    choice = plan_render(
        SCENE, OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=4.0)]), camsim.Grid(rows=2, cols=2, pitch_um=4.0),
        response=np.ones((1, 150)) / 150, wavelength_nm=nm, tolerance=tolerance, method="fourier",
    )  # fmt: skip
    kinds = {type(part.job.system.lens) for part in choice.plan.parts or [choice.plan]}
    assert (RoundDifference in kinds) == curve
    if curve:
        job = choice.plan.parts[-1].job
        for way in ways.ways_of(job):  # who plans like another takes the same way
            like = ways.as_in(job, way)
            assert (type(like.job.system.lens), like.over_rectangle) == (type(way.job.system.lens), way.over_rectangle)


def test_a_pattern_over_a_rectangle_is_the_lens_s_own():
    lens = camsim.AnnularAiry(f_number=4.0, obstruction=0.3)
    x, y = np.linspace(-3.0, 41.0, 60), np.linspace(2.0, 80.0, 45)
    system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=4.0)])
    ((rows, found),) = psf.point_spread_rows(system, x, y, NM, precision=1e-9)
    right = lens.point_spread(np.hypot(x, y[:, None]), NM)
    assert rows == slice(0, 45)
    np.testing.assert_allclose(found, right, rtol=0, atol=2e-13 * lens.point_spread(np.zeros(1), NM)[0])


ASIDE = camsim.Scene(
    background=0.1,
    shapes=[
        camsim.Disc(centre_um=(700.0, -500.0), radius_um=90.0, reflectance=0.9),
        camsim.Polygon(points_um=[(610.0, -390.0), (905.0, -420.0), (712.0, -230.0)], reflectance=0.5),
    ],
)


@pytest.mark.parametrize(
    "lens",
    [
        camsim.Airy(f_number=4.0),
        camsim.AnnularAiry(f_number=2.8, obstruction=0.4),
        Wavefront(f_number=4.0, zernike_waves={4: 0.5}),
    ],
    ids=lambda lens: type(lens).__name__,
)
def test_scenery_to_one_side_is_seen_over_a_rectangle(monkeypatch, lens):
    """A circle as far as the scenery has ten times the frequencies; edges in closed form say the same."""
    system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=3.0)])
    optics = {"response": np.array([[0.6, 0.4]]), "wavelength_nm": np.array([500.0, 610.0]), "tolerance": 1e-9}
    kept = optics | {"channel": np.zeros((6, 3), np.uint8)}
    grid = camsim.Grid(rows=6, cols=3, pitch_um=4.0)
    choice = plan_render(ASIDE, system, grid, **optics, method="fourier")
    assert any("rectangle" in decision.decision for decision in choice.plan.decisions())
    aside = render_channels(ASIDE, system, grid, **kept, method="fourier")
    with monkeypatch.context() as patch:
        patch.setattr(engine, "ways_of", lambda job: ways.ways_of(job)[:1])
        by_curves = render_channels(ASIDE, system, grid, **kept, method="fourier")
        circle = plan_render(ASIDE, system, grid, **optics, method="fourier").plan.work(1).frequencies
    if not isinstance(lens, Wavefront):  # all of it is over a rectangle in either case
        assert choice.plan.work(1).frequencies < 0.2 * circle
    by_edges = render_channels(ASIDE, system, grid, **kept, method="boundary")
    assert (aside.image - 0.1).min() > 1e3 * 1e-9
    for other in (by_curves, by_edges):
        assert np.abs(aside.image - other.image).max() <= 1e-9
