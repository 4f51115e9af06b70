"""Aberrated lenses as a round one, moved, and a short difference: the tolerance is kept, by sums over other pupils."""

import dataclasses
import functools
from itertools import pairwise

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.optics import OpticalSystem, Pupil, Wavefront, of_pupil
from camsim.rendering.aberrated import plane, transfers
from camsim.rendering.fourier import window
from camsim.rendering.render import plan_render, render_channels
from tests.truth import picture, waves

NM, F_NUMBER = 500.0, 4.0  # λN = 2 µm
LAMBDA_N = 2.0
OUTLINE = np.array([(-7.3, -6.1), (9.2, -4.3), (21.0, 17.5), (-3.9, 12.4)])  # partly outside the frame
SYSTEMS = {
    "defocus and coma": ({4: 0.1, 8: 0.05}, 0.0, 4.0),
    "a wave of many kinds": ({3: -0.4, 5: 0.5, 6: 0.3, 9: -0.2, 12: 0.6, 17: 0.2}, 0.0, 2.0),
    "three leaves and a hole": ({1: 0.7, 6: 0.1, 8: -0.1}, 0.4, 1.0),
    "wide": ({2: 0.3, 7: 0.3, 13: 0.1}, 0.0, 0.4),
    "steep": ({7: -0.8, 8: 1.1, 16: 0.3}, 0.0, 4.0),
    "steep, and a hole": ({8: 1.2, 6: -0.6, 11: 0.3}, 0.4, 2.0),
}
STEEP = ["a wave of many kinds", "steep", "steep, and a hole"]


def lens_of(zernike_waves, obstruction=0.0):
    return Wavefront(
        f_number=F_NUMBER, zernike_waves=zernike_waves, reference_nm=NM, pupil=Pupil(obstruction=obstruction)
    )


def rendered(lens, pitch_um, tolerance, method="boundary", size=12, outline=OUTLINE):
    scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=outline * pitch_um, reflectance=0.2)])
    stages = [lens, camsim.SquarePhotosite(side_um=pitch_um)]
    grid = camsim.Grid(rows=size, cols=size, pitch_um=pitch_um)
    return camsim.render(scene, stages, grid, wavelength_nm=NM, tolerance=tolerance, method=method)


def on_a_lattice(monkeypatch):
    """Have patterns made on a lattice, whatever they take over radius and angle."""
    monkeypatch.setattr(transfers, "STEEP_RAD", 0.0)
    monkeypatch.setattr(transfers, "PER_TERM", 1.0)


@pytest.mark.parametrize("lattice", [False, True])
@pytest.mark.parametrize("name", list(SYSTEMS))
def test_every_tolerance_is_kept_everywhere(name, lattice, monkeypatch):
    if lattice:
        on_a_lattice(monkeypatch)
    zernike_waves, obstruction, pitch_um = SYSTEMS[name]
    values = exactly(name)
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        found = rendered(lens_of(zernike_waves, obstruction), pitch_um, tolerance)
        off = np.abs(found.image - 1.0 - values).max()
        assert off <= tolerance
        assert found.error_estimate <= tolerance


@functools.cache
def exactly(name):
    """What 12 × 12 photosites see less than the background."""
    zernike_waves, obstruction, pitch_um = SYSTEMS[name]
    own = {
        "pupil": {"shape": "circular", "obstruction": obstruction},
        "zernike_waves": list(zernike_waves.items()),
        "reference_nm": NM,
        "f_number": F_NUMBER,
        "defocus_um": 0.0,
        "blur": LAMBDA_N / NM / pitch_um,
    }
    pieces = [picture.Piece(tuple(a), tuple(b), 0, -1) for a, b in zip(OUTLINE, np.roll(OUTLINE, -1, 0), strict=True)]
    photosite = {"kind": "square", "side": 1.0}
    truth = waves.WaveTruth(pieces, [waves.Opening(own, NM)], -0.8 * np.ones((4, 1)), photosite, None)
    at = np.arange(12) - 5.5
    values, error = truth.values(at, at)
    assert error < 1e-10
    return values


@pytest.mark.parametrize("name", list(SYSTEMS))
def test_patterns_on_a_lattice_are_those_over_radius_and_angle(name, monkeypatch):
    """At every frequency of a window, and in directions of lines; the steep ones take less there, and so they are."""
    zernike_waves, obstruction, pitch_um = SYSTEMS[name]
    short = planned(lens_of(zernike_waves, obstruction), pitch_um, 1e-5).short
    assert isinstance(short.pattern.transfers, plane.PlaneTransfers) == (name in STEEP)
    on_a_lattice(monkeypatch)
    lattice = dataclasses.replace(short.pattern).transfers
    assert isinstance(lattice, plane.PlaneTransfers)
    polar, side = lattice.of, lattice.patterns.shape[1]
    assert lattice.made_over == f"on a lattice of {side} × {side} samples"
    assert lattice.patterns.size < lattice.held < 8 * lattice.patterns.size
    assert np.abs(lattice.on_window() - polar.on_window()).max() <= short.pattern.precision
    angle, frequency = 2.4 * np.arange(40), short.settings.cut * np.linspace(0.0, 0.999, 40)
    at = frequency * np.cos(angle), frequency * np.sin(angle)
    assert np.abs(lattice.at(*at) - polar.at(*at)).max() <= short.pattern.precision


def planned(lens, pitch_um, tolerance, size=12):
    scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=OUTLINE * pitch_um, reflectance=0.2)])
    system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=pitch_um)])
    grid = camsim.Grid(rows=size, cols=size, pitch_um=pitch_um)
    light = {"response": np.ones((1, 1)), "wavelength_nm": np.array([NM])}
    return plan_render(scene, system, grid, tolerance=tolerance, method="boundary", **light).plan


def test_a_plane_wavefront_is_the_round_lens_moved():
    tilted = rendered(lens_of({1: 0.2, 2: -0.3}), 4.0, 1e-8)
    moved = OUTLINE + 4.0 * LAMBDA_N / 4.0 * np.array([-0.3, 0.2])
    airy = rendered(camsim.Airy(f_number=F_NUMBER), 4.0, 1e-8, outline=moved)
    assert np.abs(tilted.image - airy.image).max() <= 2e-8
    assert tilted.work.frequencies == 0


def test_a_tilt_is_worth_no_lattice():
    """All that it moves is seen by other photosites: nothing is made from where the pattern went to the axis."""
    square = dataclasses.replace(lens_of({12: 0.1}), pupil=Pupil(shape="square"))
    tilted = dataclasses.replace(square, zernike_waves={2: 40.0, 12: 0.1})
    away = OUTLINE - 4.0 * LAMBDA_N / 4.0 * np.array([40.0, 0.0])
    one = rendered(tilted, 4.0, 1e-8, method="fourier", outline=away)
    other = rendered(square, 4.0, 1e-8, method="fourier")
    assert np.abs(one.image - other.image).max() <= 2e-8
    assert one.work.frequencies == other.work.frequencies


@pytest.mark.parametrize("name", ["defocus and coma", "three leaves and a hole"])
def test_what_lies_beyond_is_less_than_the_bound(name):
    """The response of a straight edge by overlaps of the pupil, less that of the round part."""
    zernike_waves, obstruction, _ = SYSTEMS[name]
    lens = lens_of(zernike_waves, obstruction)
    split = lens.split()
    t, w = special.roots_legendre(80 if obstruction else 130)
    t, w = 0.5 * (1.0 + t), 0.5 * w
    pieces = [
        0.0,
        *((0.3, 0.4, 0.7) if obstruction else ()),
        1.0,
    ]  # where circles of 1 and 0.4 begin to overlap, or end
    for angle in (1.3,) if obstruction else (0.0, 1.3):
        x = np.concatenate([sign * (place + np.arange(0.0, 1.0, 0.25)) for place in (30.0, 40.0) for sign in (-1, 1)])
        response = np.zeros(x.size)
        for low, high in pairwise(pieces):
            u = low + (high - low) * t * t * (3.0 - 2.0 * t)
            f = u / LAMBDA_N * np.array([[np.cos(angle)], [np.sin(angle)]])
            moved = np.exp(-2j * np.pi * (f[0] * split.moved_um[0] + f[1] * split.moved_um[1]))
            transfer = lens.otf(f[0], f[1], NM) - split.core.otf(f[0], f[1], NM) * moved
            wave = np.exp(2j * np.pi * np.outer(x, u)) * transfer
            response += (wave.imag / (np.pi * u)) @ (6.0 * t * (1.0 - t) * (high - low) * w)
        bound = split.rest.light_beyond(np.abs(x) * LAMBDA_N, NM)
        assert (np.abs(response) <= bound).all()
        assert (np.abs(response) / bound).max() > 0.1  # and it is no idle one
    reach_um = split.rest.reach_um(1e-5, NM)
    assert (
        split.rest.light_beyond(np.array(reach_um), NM) <= 1e-5 < split.rest.light_beyond(np.array(0.9 * reach_um), NM)
    )


def in_colour(shapes, method, tolerance=1e-4, channels=3):
    """A mosaic under a spectrum, 30 × 30 photosites of 3 µm behind a low-pass filter."""
    nm = np.linspace(420.0, 680.0, 40)
    response = np.stack([np.exp(-(((nm - peak) / 40.0) ** 2)) for peak in np.linspace(460.0, 620.0, channels)])
    stages = [
        Wavefront(f_number=4.0, zernike_waves={4: 0.15, 7: 0.1}),
        camsim.FourSpotOlpf(split_um=2.0),
        camsim.SquarePhotosite(side_um=2.7),
    ]
    return render_channels(
        camsim.Scene(background=0.9, shapes=shapes),
        OpticalSystem.of(stages),
        camsim.Grid(rows=30, cols=30, pitch_um=3.0),
        response=response / response.sum(axis=1, keepdims=True),
        wavelength_nm=nm,
        channel=(np.indices((30, 30)).sum(axis=0) % channels).astype(np.uint8),
        tolerance=tolerance,
        method=method,
    )


RED = camsim.Curve((420.0, 680.0), (0.05, 0.8), outside="hold")
COLOURED = {
    "bars": [camsim.Rectangle(width_um=4.0, height_um=300.0, centre_um=(x, 1.0), reflectance=RED) for x in (-9, 0, 9)],
    "a disc": [camsim.Disc(radius_um=30.0, centre_um=(5.0, 3.0), reflectance=RED)],
    "a patchwork": [
        camsim.Rectangle(width_um=15.0, height_um=15.0, centre_um=(x, y), reflectance=0.1 + 0.02 * (x + 2 * y) % 0.8)
        for x in (-30, -15, 0, 15, 30)
        for y in (-30, -15, 0, 15, 30)
    ],
}


@pytest.mark.parametrize("name", list(COLOURED))
def test_mosaics_meet_the_other_engine(name):
    ours, theirs = (in_colour(COLOURED[name], method) for method in ("boundary", "fourier"))
    assert np.abs(ours.image - theirs.image).max() <= 1.5e-4
    assert max(ours.error_estimate, theirs.error_estimate) <= 1e-4


def test_an_edge_that_leaves_the_frame_by_far():
    """What lies a metre away does not matter, and costs nothing: the other engine is shown a nearer end."""
    lens, ends = lens_of({4: 0.1, 8: 0.05}), (1e5, 300.0)
    far, near = (np.array([(0.3, -end), (end, -end), (end, end), (0.8, end)]) for end in ends)
    found = rendered(lens, 4.0, 1e-4, method="auto", outline=far)
    assert found.method == "boundary"
    assert found.error_estimate <= 1e-4
    # The edge runs on through the same places: only what is beyond 300 photosites differs, by a round lens's tail.
    near[:, 0] = np.interp(near[:, 1], far[[0, 3], 1], far[[0, 3], 0]) + np.array([0.0, 300.0, 300.0, 0.0])
    assert np.abs(found.image - rendered(lens, 4.0, 1e-4, method="fourier", outline=near).image).max() < 1.5e-3


@pytest.mark.parametrize("shape", ["circular", "square"])
def test_patterns_made_strip_by_strip_are_the_same(monkeypatch, shape):
    lens = Wavefront(f_number=F_NUMBER, zernike_waves={4: 0.2, 7: 0.1}, pupil=Pupil(shape=shape))
    whole = rendered(lens, 4.0, 1e-6, method="fourier").image
    monkeypatch.setattr(window, "pattern_rows", lambda *_: 37)
    monkeypatch.setattr(of_pupil, "NODES_AT_ONCE", 3_000)
    assert np.abs(whole - rendered(lens, 4.0, 1e-6, method="fourier").image).max() <= 1e-7


class HandedOn:
    """A lens of one's own that knows its pattern and hands it on from its last rows to its first."""

    place, transmission, _whole = "lens", 1.0, lens_of({4: 0.2, 7: 0.1})

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return self._whole.otf(fx_per_um, fy_per_um, wavelength_nm)

    def cutoff_per_um(self, wavelength_nm):
        return self._whole.cutoff_per_um(wavelength_nm)

    def point_spread_rows(self, x_um, y_um, wavelength_nm, precision):
        pattern = self._whole.point_spread_on(x_um, y_um, wavelength_nm, precision)
        middle = y_um.size // 3
        for rows in (slice(middle, None), slice(1, middle, 2), slice(None, middle, 2)):
            yield rows, pattern[rows].copy()


def test_a_lens_of_ones_own_may_hand_its_pattern_on():
    own = rendered(HandedOn(), 4.0, 1e-5, method="fourier").image
    assert np.abs(own - rendered(HandedOn._whole, 4.0, 1e-5, method="fourier").image).max() <= 2e-5


def test_other_pupils_are_within_memory():
    scene = camsim.Scene(background=1.0, shapes=[camsim.Rectangle(width_um=1200.0, height_um=1200.0, reflectance=0.0)])
    for f_number in (2.8, 16.0):
        for pupil in (Pupil(shape="square"), Pupil(shape="bladed", blades=7)):
            lens = Wavefront(f_number=f_number, zernike_waves={4: 0.1}, pupil=pupil)
            choice = plan_render(
                scene,
                OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=4.88)]),
                camsim.Grid(rows=446, cols=446, pitch_um=4.88),
                response=np.ones((1, 1)),
                wavelength_nm=np.array([550.0]),
                tolerance=1e-6,
            )
            assert choice.method == "fourier"
            assert choice.plan.cost.memory_bytes < 2e9


def test_a_tolerance_that_no_one_keeps_is_refused_by_its_own_number():
    with pytest.raises(camsim.errors.InvalidValueError, match="tolerance: 1e-11 is outside 2e-11 … 0"):
        rendered(lens_of({4: 0.1}), 4.0, 1e-11)


@pytest.mark.parametrize("colours", [1, 9])
def test_the_check_beside_lines_is_what_it_transforms(colours):
    """Sums along a line's normal against windows: two colours on either side of lines of two directions, an OLPF."""
    wedge = np.array([(-9e3, -300.0), (50.0, -300.0), (350.0, 330.0), (-9e3, 300.0)])
    red = camsim.Curve((450.0, 700.0), (0.05, 0.9), outside="hold")
    nm = np.linspace(450.0, 650.0, colours)
    choice = plan_render(
        camsim.Scene(background=red, shapes=[camsim.Polygon(points_um=wedge, reflectance=0.3)]),
        OpticalSystem.of(
            [lens_of({2: 0.2, 4: 0.1, 8: 0.05}), camsim.FourSpotOlpf(split_um=3.0), camsim.SquarePhotosite(side_um=4.0)]
        ),
        camsim.Grid(rows=120, cols=120, pitch_um=5.0),
        response=np.stack([np.ones(colours), np.linspace(0.1, 1.0, colours)]) / colours,
        wavelength_nm=nm,
        tolerance=1e-4,
        method="boundary",
    )
    framed = choice.judge._framed
    rows, cols = np.array([30, 31, 60, 61, 90, 95]), np.array([88, 86, 100, 5, 10, 40])
    sets = np.array([[0, 1, 0, 1, 0, 1], [1, 0, 1, 0, 1, 0]], np.uint8)
    points = np.stack(choice.plan.job.grid.first_centre)[None] + np.stack([cols, rows], axis=1)
    assert framed.beside.alone(points)
    seen = framed.beside.values(points, sets)
    assert np.abs(seen).max() > 1e-3
    np.testing.assert_allclose(
        seen, dataclasses.replace(framed, beside=None).values(rows, cols, sets), atol=0.1 * 1e-4, rtol=0.0
    )
