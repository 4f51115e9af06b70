"""A stated tolerance is kept: whole images against Fourier sums, sharp ones against line integrals (tests/truth)."""

import numpy as np
import pytest

from tests.attack import systems
from tests.truth.lattice import Lens, window_truths

TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-6]
POINT, SQUARE = {"kind": "point"}, {"kind": "square", "side": 1.0}
OLPF = {"split": 0.75, "split_y": 0.75, "rotate_deg": 0.0}
SCENES = {
    "square": [
        {"kind": "rectangle", "width": 20.0, "height": 20.0, "centre": [0, 0], "rotate_deg": 4.0, "reflectance": 0.0}
    ],
    "crowd": [
        {"kind": "disc", "radius": 8.0, "centre": [8.0, 2.0], "reflectance": 0.1},
        {"kind": "polygon", "points": [[-20, -18], [3, -12], [-8, 14]], "reflectance": 0.7},
        {"kind": "rectangle", "width": 50.0, "height": 0.6, "centre": [0, 0], "rotate_deg": 31.0, "reflectance": 0.0},
    ],
}


def system_of(shapes, blur, *, photosite=SQUARE, olpf=None, rows=28, cols=34):
    """A system of ``tests.attack`` behind an Airy lens; ``blur``: λN in pitches."""
    return {
        "pitch_um": 4.88,
        "grid": {"rows": rows, "cols": cols, "origin": [0, 0], "frame": None},
        "lens": {"kind": "airy", "blur": blur},
        "olpf": olpf,
        "photosite": photosite,
        "wavelength_nm": [550.0],
        "response": [[1.0]],
        "layout": [0, 0, 0, 0],
        "method": "auto",
        "background": 1.0,
        "shapes": shapes,
    }


@pytest.mark.parametrize(
    ("scene", "blur", "photosite", "olpf"),
    [
        ("square", 0.9, POINT, None),
        ("crowd", 0.9, SQUARE, OLPF),
        ("square", 3.6, SQUARE, None),
        ("crowd", 3.6, SQUARE, OLPF),
    ],
)
def test_error_stays_below_every_tolerance(scene, blur, photosite, olpf):
    system = system_of(SCENES[scene], blur, photosite=photosite, olpf=olpf)
    exact, unsure = systems.Truth(system).everywhere()
    assert unsure < 1e-11
    for tolerance in TOLERANCES:
        rendering = systems.rendered(system, tolerance=tolerance)
        assert np.abs(rendering.image - exact).max() <= tolerance
        assert rendering.error_estimate <= tolerance


@pytest.mark.parametrize(
    ("scene", "photosite", "olpf"), [("square", SQUARE, None), ("crowd", POINT, None), ("crowd", SQUARE, OLPF)]
)
def test_sharp_images_too(scene, photosite, olpf, rng):
    """f/1.4, λN = 0.16 pitches: the photosites that two tolerances make most different of, and others."""
    system = system_of(SCENES[scene], 0.16, photosite=photosite, olpf=olpf)
    images = {tolerance: systems.rendered(system, tolerance=tolerance) for tolerance in TOLERANCES}
    unlike = np.abs(images[1e-3].image - images[1e-6].image)
    places = [*np.argsort(-unlike, axis=None)[:6], *rng.integers(unlike.size, size=10)]
    rows, cols = np.unravel_index(places, unlike.shape)
    exact, unsure = systems.Truth(system).these(rows, cols, target=1e-9)
    assert unsure.max() < 1e-9
    for tolerance, rendering in images.items():
        assert np.abs(rendering.image[rows, cols] - exact).max() <= tolerance
        assert rendering.error_estimate <= tolerance


def test_a_crowd_of_corners_keeps_the_tolerance():
    """What a hundred corners in sight each leave out adds up; the settings allow for it."""
    rng = np.random.default_rng(3)
    shapes = [
        {
            "kind": "rectangle",
            "width": 3.9,
            "height": 3.9,
            "centre": [16.0 * (i % 6) - 40.0, 16.0 * (i // 6) - 40.0],
            "rotate_deg": float(rng.uniform(0, 90)),
            "reflectance": 0.0,
        }
        for i in range(36)
    ]
    system = system_of(shapes, 0.9, rows=96, cols=96)
    exact, unsure = systems.Truth(system).everywhere()
    assert unsure < 1e-11
    for tolerance in TOLERANCES:
        assert np.abs(systems.rendered(system, tolerance=tolerance).image - exact).max() <= tolerance


@pytest.mark.parametrize("seed", range(4))
def test_frequency_sums_keep_half_of_it_behind_random_polygons(seed):
    rng = np.random.default_rng(seed)
    blur, size = float(np.exp(rng.uniform(np.log(0.3), np.log(5.0)))), int(rng.integers(16, 48))
    corners = int(rng.integers(3, 9))
    angle = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2.0 * np.pi / corners
    outline = rng.uniform(0.2, 0.7) * size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    shape = {"kind": "polygon", "points": (outline + rng.uniform(-0.4, 0.4, 2) * size).tolist(), "reflectance": 0.0}
    photosite, olpf = ((POINT, None), (SQUARE, OLPF), (SQUARE, None), (POINT, OLPF))[seed]
    system = system_of([shape], blur, photosite=photosite, olpf=olpf, rows=size, cols=size)
    exact, unsure = systems.Truth(system).everywhere()
    assert unsure < 1e-10
    for tolerance in (1e-2, 1e-5, 1e-8):
        image = systems.rendered(system, tolerance=tolerance, method="fourier").image
        assert np.abs(image - exact).max() <= 0.5 * tolerance


def test_few_wavelengths_do_not_come_back_into_step():
    """Rings that a spectrum quiets soon, and a few wavelengths would let sound again far from every edge."""
    nm = np.linspace(480.0, 620.0, 71)
    weights = np.exp(-(((nm - 550.0) / 30.0) ** 2))
    weights /= weights.sum()
    polygon = np.array([(-31.0, -28.0), (-14.0, -27.0), (-12.0, 25.0), (-32.0, 28.0)])
    shape = {"kind": "polygon", "points": polygon.tolist(), "reflectance": 1.0}
    system = system_of([shape], 8.0 * 0.55 / 4.88, photosite=POINT, rows=64, cols=64) | {"background": 0.0}
    system |= {"wavelength_nm": nm.tolist(), "response": [weights.tolist()]}
    lens = Lens(blur=nm * 1e-3 * 8.0 / 4.88, weights=weights)
    how = {"origin": systems.grid(system).first_centre, "shape": (64, 64), "shifts": np.zeros((1, 2))}
    truth = window_truths(polygon, lens, [(0.0, 0.0)], **how)[0, 0]
    for tolerance in (1e-4, 1e-8):
        image = systems.rendered(system, tolerance=tolerance, method="fourier").image
        assert np.abs(image - truth).max() <= 0.5 * tolerance
