"""The 296 reference values: polygons under Airy ⊗ OLPF ⊗ square photosite by adaptive quadrature elsewhere."""

import json
from pathlib import Path

import numpy as np
import pytest

import camsim

CASES = json.loads((Path(__file__).parents[1] / "data" / "oracle-values.json").read_text())["cases"]
PITCH_UM = 5.0
WAVELENGTH_NM = 500.0


def rendered(case, tolerance):
    points = (np.array(case["polygon"]) - [case["x"], case["y"]]) * PITCH_UM
    scene = camsim.Scene(background=0.0, shapes=[camsim.Polygon(points_um=points, reflectance=1.0)])
    optics = [
        camsim.Airy(f_number=case["L"] * PITCH_UM * 1e3 / WAVELENGTH_NM),
        camsim.SquarePhotosite(side_um=case["box"] * PITCH_UM),
    ]
    if case["olpf"]:
        optics.append(camsim.FourSpotOlpf(split_um=case["olpf"] * PITCH_UM))
    grid = camsim.Grid(rows=1, cols=1, pitch_um=PITCH_UM)
    # Tables of closed forms grow too large for finer tolerances than 1e-8.
    method = "boundary" if tolerance > 5e-9 else "fourier"
    return camsim.render(scene, optics, grid, wavelength_nm=WAVELENGTH_NM, tolerance=tolerance, method=method)


@pytest.mark.parametrize("digits", range(2, 10))
def test_reference_values_within_tolerance(digits):
    """Every sixth, others each time; fewer from 1e-7 on, each of which takes a second or more."""
    tolerance, cases = 10.0**-digits, CASES[digits % 6 :: 6 if digits < 7 else {7: 24, 8: 72, 9: 100}[digits]]
    results = [rendered(case, tolerance) for case in cases]
    errors = np.array([r.image[0, 0] for r in results]) - [case["value"] for case in cases]
    worst = int(np.argmax(np.abs(errors)))
    assert np.abs(errors).max() <= tolerance, cases[worst]
    # The estimate is the difference from a path at least ten times as accurate: never far below the true error.
    estimates = np.array([r.error_estimate for r in results])
    assert np.all(np.abs(errors) <= estimates + tolerance / 10)


def test_all_cases_are_there():
    assert len(CASES) == 296
    assert {case["L"] for case in CASES} >= {0.08, 0.9016, 20.0}
