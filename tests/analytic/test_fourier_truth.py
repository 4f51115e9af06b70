"""Two exact roads meet: whole images against Fourier transforms, and those against the reference values."""

import json
from pathlib import Path

import numpy as np
import pytest

import camsim
from tests.truth.lattice import white_with_a_black_polygon

CASES = json.loads((Path(__file__).parents[1] / "data" / "oracle-values.json").read_text())["cases"]


@pytest.mark.parametrize("number", [100, 140, 170, 230])
def test_the_judge_itself_equals_the_reference_values(number):
    case = CASES[number]
    polygon = np.array(case["polygon"]) - [case["x"], case["y"]]
    image = white_with_a_black_polygon(polygon, 1, 1, case["L"], side=case["box"], split=case["olpf"])
    assert 1.0 - image[0, 0] == pytest.approx(case["value"], abs=1e-9)


@pytest.mark.parametrize(("side", "split"), [(0.0, 0.0), (1.0, 0.0), (0.8, 0.75)])
@pytest.mark.parametrize("lambda_n", [0.6, 1.4])
def test_whole_images_equal_fourier_transforms(lambda_n, side, split):
    outline = np.array([(-9.3, -12.1), (14.2, -7.7), (3.3, 15.9), (-2.0, 2.5)])
    exact = white_with_a_black_polygon(outline, 40, 48, lambda_n, side=side, split=split)
    optics = [camsim.Airy(f_number=2.0 * lambda_n), camsim.SquarePhotosite(side_um=side)]
    if split:
        optics.append(camsim.FourSpotOlpf(split_um=split))
    scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=outline, reflectance=0.0)])
    grid = camsim.Grid(rows=40, cols=48, pitch_um=1.0)
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        image = camsim.render(scene, optics, grid, wavelength_nm=500.0, tolerance=tolerance).image
        assert np.abs(image - exact).max() <= tolerance
