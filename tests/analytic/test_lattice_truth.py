"""The bench's truth of whole windows against reference values, which were computed elsewhere, and line integrals."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.truth.lattice import Lens, photosite_value, window_truths

CASES = json.loads((Path(__file__).parents[1] / "data" / "oracle-values.json").read_text())["cases"]


def test_the_fourier_sum_meets_the_reference_values():
    for case in [c for c in CASES if c["L"] >= 0.15][::36]:
        polygon = np.array(case["polygon"]) - [case["x"], case["y"]]
        share = window_truths(
            polygon,
            Lens(blur=np.array([case["L"]]), weights=np.ones(1)),
            [(case["box"], case["olpf"])],
            origin=(0.0, 0.0),
            shape=(1, 1),
            shifts=np.zeros((1, 2)),
        )
        assert share[0, 0, 0, 0] == pytest.approx(case["value"], abs=1e-11), case


@pytest.mark.parametrize("gaussian", [False, True], ids=["airy", "gaussian"])
def test_shifts_footprints_and_wavelengths_agree_between_the_two(gaussian):
    polygon = np.array([(-9.3, -12.1), (14.2, -7.7), (3.3, 15.9), (-2.0, 2.5)])
    blurs = np.array([0.8]) if gaussian else np.array([0.8, 0.95, 1.1])
    pattern = Lens(
        blur=blurs, weights=np.array([0.2, 0.5, 0.3])[: blurs.size] / (0.2 if gaussian else 1.0), gaussian=gaussian
    )
    footprints = [(0.0, 0.0), (1.0, 0.0), (0.8, 0.75)]
    shifts = np.array([[0.0, 0.0], [0.31, -0.22]])
    shares = window_truths(polygon, pattern, footprints, origin=(-3.0, 2.0), shape=(3, 4), shifts=shifts)
    for f, (side, split) in enumerate(footprints):
        for k, shift in enumerate(shifts):
            value = photosite_value(polygon + shift, -3.0 + 2, 2.0 + 1, pattern, side=side, split=split)
            assert shares[f, k, 1, 2] == pytest.approx(value, abs=1e-11)
