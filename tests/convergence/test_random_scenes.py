"""Random photosites of random systems, sharp to all diffraction: every tolerance is kept and the estimate is honest.

Judged by line integrals (tests/truth/boundary.py), with alignments that random numbers never meet: photosites on
edges, on corners, straight off an edge's end. ``make test-bounds`` runs this file with array bounds checked.
"""

import numpy as np
import pytest

from tests.attack import systems
from tests.convergence.test_tolerance import system_of

OUTLINES = {
    "square": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
    "triangle": [(-1, -0.7), (1.2, -0.5), (0.1, 0.9)],
    "arrow": [(-1, -0.8), (1, 0), (-1, 0.8), (-0.3, 0)],
    "sliver": [(-1, -0.01), (1, 0), (-1, 0.013)],
}
TOLERANCES = (1e-3, 1e-4, 1e-6)


def random_case(rng):
    """One photosite beside a polygon: a third of them where closed forms change branch."""
    blur = 10 ** rng.uniform(-1.2, 1.4)
    outline = np.array(OUTLINES[rng.choice(list(OUTLINES))]) * 10 ** rng.uniform(-0.3, 1.6)
    angle = rng.choice([0.0, 0.25 * np.pi, rng.uniform(0, 2 * np.pi)])
    outline = outline @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    first = rng.integers(len(outline))
    a, b = outline[first], outline[(first + rng.choice([1, 2])) % len(outline)]
    point = a + (b - a) * rng.choice([0.0, 1.0, rng.uniform(-0.3, 1.3)])
    if rng.random() < 0.67:
        point = point + rng.normal(size=2) * 10 ** rng.uniform(-2, 1)
    side, split = float(rng.choice([0.0, 0.3, 0.7, 1.0])), float(rng.choice([0.0, 0.0, 0.4, 0.75, 1.0, 1.5]))
    photosite = {"kind": "square", "side": side} if side else {"kind": "point"}
    turned = {"split": split, "split_y": float(rng.choice([split, 0.0])), "rotate_deg": float(rng.choice([0, 45, 20]))}
    shape = {"kind": "polygon", "points": (outline - point).tolist(), "reflectance": 1.0}
    system = system_of([shape], blur, photosite=photosite, olpf=turned if split else None, rows=1, cols=1)
    return system | {"background": 0.0, "pitch_um": 1.0}


@pytest.mark.parametrize("seed", range(2))
def test_random_cases(seed):
    rng = np.random.default_rng(seed)
    for _ in range(20):
        system = random_case(rng)
        expected, unsure = systems.Truth(system).at(0, 0, target=1e-8)
        assert unsure < 2e-8
        for tolerance in TOLERANCES:
            rendering = systems.rendered(system, tolerance=tolerance)
            error = abs(rendering.image[0, 0] - expected)
            assert error <= tolerance, systems.code(system | {"tolerance": tolerance})
            assert error <= rendering.error_estimate + tolerance / 10
