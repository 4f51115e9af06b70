"""A stated tolerance is kept: whole images against Fourier sums, sharp ones against line integrals (tests/truth)."""

import numpy as np
import pytest

from tests.attack import systems

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
