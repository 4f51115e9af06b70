"""Lenses with aberrations keep the tolerance, judged by sums over other pupils."""

import dataclasses
import functools

import numpy as np
import pytest

import camsim
from camsim.optics import OpticalSystem, Pupil, Wavefront
from camsim.rendering.render import plan_render
from tests.truth import picture, waves

NM, F_NUMBER = 500.0, 4.0  # λN = 2 µm
LAMBDA_N = 2.0
OUTLINE = np.array([(-7.3, -6.1), (9.2, -4.3), (21.0, 17.5), (-3.9, 12.4)])  # partly outside the frame
SYSTEMS = {
    "defocus and coma": ({4: 0.1, 8: 0.05}, 0.0, 4.0),
    "three leaves and a hole": ({1: 0.7, 6: 0.1, 8: -0.1}, 0.4, 1.0),
    "wide": ({2: 0.3, 7: 0.3, 13: 0.1}, 0.0, 0.4),
    "steep, and a hole": ({8: 0.6, 6: -0.3, 11: 0.15}, 0.4, 2.0),
}


def lens_of(zernike_waves, obstruction=0.0):
    return Wavefront(
        f_number=F_NUMBER, zernike_waves=zernike_waves, reference_nm=NM, pupil=Pupil(obstruction=obstruction)
    )


def rendered(lens, pitch_um, tolerance, method="auto", size=12, outline=OUTLINE):
    scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=outline * pitch_um, reflectance=0.2)])
    stages = [lens, camsim.SquarePhotosite(side_um=pitch_um)]
    grid = camsim.Grid(rows=size, cols=size, pitch_um=pitch_um)
    return camsim.render(scene, stages, grid, wavelength_nm=NM, tolerance=tolerance, method=method)


@pytest.mark.parametrize("name", list(SYSTEMS))
def test_every_tolerance_is_kept_everywhere(name):
    zernike_waves, obstruction, pitch_um = SYSTEMS[name]
    values = exactly(name)
    for tolerance in (1e-2, 1e-4, 1e-6):
        found = rendered(lens_of(zernike_waves, obstruction), pitch_um, tolerance)
        off = np.abs(found.image - 1.0 - values).max()
        assert off <= tolerance
        assert found.error_estimate <= tolerance


@functools.cache
def exactly(name):
    """What 12 × 12 photosites see less than the background."""
    zernike_waves, obstruction, pitch_um = SYSTEMS[name]
    each = {
        "pupil": {"shape": "circular", "obstruction": obstruction},
        "zernike_waves": list(zernike_waves.items()),
        "reference_nm": NM,
        "f_number": F_NUMBER,
        "defocus_um": 0.0,
        "blur": LAMBDA_N / NM / pitch_um,
    }
    pieces = [picture.Piece(tuple(a), tuple(b), 0, -1) for a, b in zip(OUTLINE, np.roll(OUTLINE, -1, 0), strict=True)]
    photosite = {"kind": "square", "side": 1.0}
    truth = waves.WaveTruth(pieces, [waves.Opening(each, NM)], -0.8 * np.ones((4, 1)), photosite, None)
    at = np.arange(12) - 5.5
    values, error = truth.values(at, at)
    assert error < 1e-10
    return values


def test_a_plane_wavefront_is_the_round_lens_moved():
    tilted = rendered(lens_of({1: 0.2, 2: -0.3}), 4.0, 1e-8)
    moved = OUTLINE + 4.0 * LAMBDA_N / 4.0 * np.array([-0.3, 0.2])
    airy = rendered(camsim.Airy(f_number=F_NUMBER), 4.0, 1e-8, outline=moved)
    assert np.abs(tilted.image - airy.image).max() <= 2e-8


def test_a_tilt_is_worth_no_lattice():
    """All that it moves is seen by other photosites: nothing is made from where the pattern went to the axis."""
    square = dataclasses.replace(lens_of({12: 0.1}), pupil=Pupil(shape="square"))
    tilted = dataclasses.replace(square, zernike_waves={2: 40.0, 12: 0.1})
    away = OUTLINE - 4.0 * LAMBDA_N / 4.0 * np.array([40.0, 0.0])
    one = rendered(tilted, 4.0, 1e-4, outline=away)
    other = rendered(square, 4.0, 1e-4)
    assert np.abs(one.image - other.image).max() <= 1e-6
    assert one.work.frequencies == other.work.frequencies


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
                tolerance=1e-5,
            )
            assert choice.method == "fourier"
            assert choice.plan.cost.memory_bytes < 2e9
