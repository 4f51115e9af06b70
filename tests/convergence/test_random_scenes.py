"""Random photosites of random systems, sharp to all diffraction: every tolerance is kept and the estimate is honest.

The judge is the spot check's own path at a tolerance that shares nothing with the rendering's; that path is itself
tested against the reference values and against rays. ``make test-bounds`` runs this file with array bounds checked.
"""

import numpy as np
import pytest

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering.footprint import Footprint
from camsim.rendering.patterns import pattern_of
from camsim.rendering.spotcheck import Check, reference_values
from camsim.scene import arrange

OUTLINES = {
    "square": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
    "triangle": [(-1, -0.7), (1.2, -0.5), (0.1, 0.9)],
    "arrow": [(-1, -0.8), (1, 0), (-1, 0.8), (-0.3, 0)],
    "sliver": [(-1, -0.01), (1, 0), (-1, 0.013)],
}


def random_case(rng):
    lambda_n = 10 ** rng.uniform(-1.2, 1.4)
    outline = np.array(OUTLINES[rng.choice(list(OUTLINES))]) * 10 ** rng.uniform(-0.3, 1.6)
    angle = rng.uniform(0, 2 * np.pi)
    outline = outline @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    a, b = outline[rng.integers(len(outline))], outline[rng.integers(len(outline))]
    point = a + (b - a) * rng.uniform(-0.3, 1.3) + rng.normal(size=2) * 10 ** rng.uniform(-2, 1)
    optics = [camsim.Airy(f_number=2 * lambda_n), camsim.SquarePhotosite(side_um=rng.choice([0.0, 0.3, 0.7, 1.0]))]
    split = rng.choice([0.0, 0.0, 0.4, 0.75, 1.0, 1.5])
    if split:
        optics.append(camsim.FourSpotOlpf(split_um=split))
    shape = camsim.Polygon(points_um=outline - point, reflectance=1.0)
    return camsim.Scene(background=0.0, shapes=[shape]), optics, lambda_n


def judged(scene, optics, lambda_n):
    edges = arrange(scene, max_segment_um=1.0)
    scales, weights = np.array([lambda_n]), np.ones((1, 1, 1))
    pattern = pattern_of(optics[0])
    check = Check.planned(pattern, scales, weights[0], Footprint.of(OpticalSystem.of(optics), 1.0), 2e-7)
    pair = np.zeros(len(edges.left), np.int64)
    return reference_values(
        np.zeros((1, 2)),
        np.zeros(1, np.int64),
        start=edges.start_um,
        end=edges.end_um,
        pair=pair,
        weights=weights,
        base=np.zeros(1),
        pattern=pattern,
        blur=scales,
        check=check,
    )[0]


@pytest.mark.parametrize("seed", range(5))
def test_random_cases(seed):
    rng = np.random.default_rng(seed)
    grid = camsim.Grid(rows=1, cols=1, pitch_um=1.0)
    for _ in range(60):
        scene, optics, lambda_n = random_case(rng)
        expected = judged(scene, optics, lambda_n)
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6):
            rendering = camsim.render(scene, optics, grid, wavelength_nm=500.0, tolerance=tolerance)
            error = abs(rendering.image[0, 0] - expected)
            assert error <= tolerance, (scene, optics)
            assert error <= rendering.error_estimate + tolerance / 10
