"""Both truths of the bench against the reference values, which were computed elsewhere."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.truth.lattice import Lens, window_truths
from tests.truth.quadrature import photosite_value
from tests.truth.rays import rayleigh_energy

CASES = json.loads((Path(__file__).parents[1] / "data" / "oracle-values.json").read_text())["cases"]
# Sharp patterns over a wide footprint take seconds each by plain quadrature: a few of them do.
QUICK = [c for k, c in enumerate(CASES) if c["box"] == 0.0 or (c["L"] > 1.5 and k % 6 == 0) or k in (61, 115)][::2]


def lens(case):
    return Lens(blur=np.array([case["L"]]), weights=np.ones(1))


def test_quadrature_meets_the_reference_values():
    assert len(QUICK) > 40
    assert {case["shape"] for case in QUICK} == {case["shape"] for case in CASES}
    for case in QUICK:
        polygon = np.array(case["polygon"])
        value = photosite_value(polygon, case["x"], case["y"], lens(case), side=case["box"], split=case["olpf"])
        assert value == pytest.approx(case["value"], abs=1e-13), case


def test_the_fourier_sum_meets_them_too():
    for case in [c for c in CASES if c["L"] >= 0.15][::36]:
        polygon = np.array(case["polygon"]) - [case["x"], case["y"]]
        share = window_truths(
            polygon,
            lens(case),
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


def test_a_disc_of_many_corners_sees_the_encircled_energy():
    """A polygon inscribed in a circle about the photosite: E(r) by Rayleigh's formula, less what the chords cut off."""
    turns = np.arange(4000) * 2.0 * np.pi / 4000
    radius = 2.7 * np.sqrt((2 * np.pi / 4000) / np.sin(2 * np.pi / 4000))  # of equal area
    polygon = radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    value = photosite_value(polygon, 0.0, 0.0, Lens(blur=np.array([1.3]), weights=np.ones(1)))
    assert value == pytest.approx(float(rayleigh_energy(2.7, 1.3)), abs=1e-9)
