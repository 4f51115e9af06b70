"""Frequency sums keep each tolerance at every photosite of random scenes, judged by a Fourier sum of another kind."""

import numpy as np
import pytest

from camsim import Airy, FourSpotOlpf, Grid, Polygon, Scene, SquarePhotosite, render
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels
from tests.truth.lattice import Lens, window_truths

PITCH_UM, WAVELENGTH_NM = 4.88, 550.0


def random_polygon(rng, size):
    """Corners (n, 2) in pitches about a centre within the frame, in order of their angle."""
    corners = int(rng.integers(3, 9))
    angle = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2.0 * np.pi / corners
    radius = rng.uniform(0.2, 0.7) * size
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + rng.uniform(-0.4, 0.4, 2) * size


@pytest.mark.parametrize("seed", range(4))
def test_every_tolerance_is_kept_everywhere(seed):
    rng = np.random.default_rng(seed)
    f_number = float(np.exp(rng.uniform(np.log(2.8), np.log(45.0))))
    side, split, size = float(rng.choice([0.0, 0.5, 1.0])), float(rng.choice([0.0, 0.75])), int(rng.integers(16, 64))
    polygon = random_polygon(rng, size)
    grid = Grid(rows=size, cols=size, pitch_um=PITCH_UM)
    blur = WAVELENGTH_NM * 1e-3 * f_number / PITCH_UM
    truth = window_truths(
        polygon,
        Lens(blur=np.array([blur]), weights=np.ones(1)),
        [(side, split)],
        origin=grid.first_centre,
        shape=(size, size),
        shifts=np.zeros((1, 2)),
    )[0, 0]
    stages = [Airy(f_number=f_number), SquarePhotosite(side_um=side * PITCH_UM)]
    if split:
        stages.append(FourSpotOlpf(split_um=split * PITCH_UM))
    scene = Scene(background=0.0, shapes=[Polygon(points_um=polygon * PITCH_UM, reflectance=1.0)])
    for tolerance in (1e-2, 1e-5, 1e-8):
        image = render(scene, stages, grid, wavelength_nm=WAVELENGTH_NM, method="fourier", tolerance=tolerance).image
        assert np.abs(image - truth).max() <= 0.5 * tolerance


def test_few_wavelengths_do_not_come_back_into_step():
    """Rings that a spectrum quiets soon, and a few wavelengths would let sound again far from every edge."""
    wavelength_nm = np.linspace(480.0, 620.0, 71)
    weights = np.exp(-(((wavelength_nm - 550.0) / 30.0) ** 2))
    weights /= weights.sum()
    size = 64
    polygon = np.array([(-31.0, -28.0), (-14.0, -27.0), (-12.0, 25.0), (-32.0, 28.0)])
    grid = Grid(rows=size, cols=size, pitch_um=PITCH_UM)
    truth = window_truths(
        polygon,
        Lens(blur=wavelength_nm * 1e-3 * 8.0 / PITCH_UM, weights=weights),
        [(0.0, 0.0)],
        origin=grid.first_centre,
        shape=(size, size),
        shifts=np.zeros((1, 2)),
    )[0, 0]
    scene = Scene(background=0.0, shapes=[Polygon(points_um=polygon * PITCH_UM, reflectance=1.0)])
    for tolerance in (1e-4, 1e-8):
        rendering = render_channels(
            scene,
            OpticalSystem.of([Airy(f_number=8.0), SquarePhotosite(side_um=0.0)]),
            grid,
            response=weights[None],
            wavelength_nm=wavelength_nm,
            channel=np.zeros((size, size), np.uint8),
            method="fourier",
            tolerance=tolerance,
        )
        assert np.abs(rendering.image - truth).max() <= 0.5 * tolerance
