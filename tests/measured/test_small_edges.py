"""Sharp edges in small regions of one Bayer channel: right within their errors, or refused.

``python bench/mtf_study.py small`` draws thousands of these.
"""

import math

import numpy as np
import pytest
from drawn_edges import drawn_edge_of_a_chart
from edges import drawn_edge, gaussian_edge, gaussian_sigma

from camsim.errors import UnsupportedError
from camsim.measure import Plane, Roi, measure_edge

FIGURES = ("angle_deg", "mtf50_cycles_per_pixel", "rise_10_90_pixel")


def test_what_is_not_refused_is_right():
    rng, measured = np.random.default_rng(7), 0
    for _ in range(32):
        samples, first, (rows, cols), true = drawn_edge(rng)
        try:
            edge = measure_edge(Plane(name="R", samples=samples, step=(2, 2), first=first), Roi(0, 0, rows, cols))
        except UnsupportedError:
            continue
        measured += 1
        for name in FIGURES:
            found, error = getattr(edge.figures, name), getattr(edge.standard_error, name)
            assert math.isnan(found) or abs(found - true[name]) <= 4.0 * error, (true, name, found, error)
    assert measured > 16


def test_edges_as_charts_have_them_are_within_their_errors():
    """Blocks of 25 px and more, near neighbours, tilted light, noise and none; bench/mtf_study.py draws hundreds."""
    measured = 0
    for seed in range(30):
        drawn = drawn_edge_of_a_chart(np.random.default_rng(seed))
        try:
            edge = measure_edge(drawn.plane, drawn.roi)
        except UnsupportedError:
            continue
        found, error = edge.figures.mtf50_cycles_per_pixel, edge.standard_error.mtf50_cycles_per_pixel
        measured += math.isfinite(found)
        assert math.isnan(found) or abs(found - drawn.mtf50_cycles_per_pixel) <= 4.0 * error, drawn.how
    assert measured > 15


@pytest.mark.parametrize("seed", [1324, 162])
def test_a_direction_that_fits_better_is_not_taken(seed):
    """Turned by two standard errors the first fitted better (its rise was 4.4 of its own off), straight the second."""
    samples, first, (rows, cols), _ = drawn_edge(np.random.default_rng(seed))
    with pytest.raises(UnsupportedError, match="hides the edge's direction"):
        measure_edge(Plane(name="R", samples=samples, step=(2, 2), first=first), Roi(0, 0, rows, cols))


@pytest.mark.parametrize("seed", [2200, 3047])
def test_a_direction_is_as_unsure_as_a_bend_or_a_far_turn_makes_it(seed):
    """Bent lines fitted as well as the straight edges that were drawn, turned by four and six of their errors."""
    samples, first, (rows, cols), true = drawn_edge(np.random.default_rng(seed))
    edge = measure_edge(Plane(name="R", samples=samples, step=(2, 2), first=first), Roi(0, 0, rows, cols))
    assert abs(edge.figures.angle_deg - true["angle_deg"]) <= 2.5 * edge.standard_error.angle_deg


def test_errors_are_as_large_as_what_they_tell_and_not_much_larger():
    """40 noises upon one edge of 12 × 12 samples: the figures scatter as their errors say."""
    rng, off = np.random.default_rng(3), []
    sigma = gaussian_sigma(0.4)
    for _ in range(40):
        shift = float(rng.uniform(-1.0, 1.0))
        samples = gaussian_edge(36, 32, -5.8, sigma, step=2, shift_px=shift) + rng.normal(0.0, 0.8 / 150, (18, 16))
        edge = measure_edge(Plane(name="R", samples=samples, step=(2, 2)), Roi(0, 0, 36, 32))
        off.append(
            [
                (edge.figures.angle_deg + 5.8) / edge.standard_error.angle_deg,
                (edge.figures.mtf50_cycles_per_pixel - 0.4) / edge.standard_error.mtf50_cycles_per_pixel,
            ]
        )
    scatter = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.all((scatter > 0.4) & (scatter < 1.3)), scatter


def test_a_sharp_edge_whose_phases_all_but_come_once_is_not_taken_for_well_known():
    """The slope's own noise looks like information about the direction: errors were too small by 1.8 here."""
    rng, off = np.random.default_rng(5), []
    image = gaussian_edge(36, 48, 4.75, gaussian_sigma(0.58), step=2, first=(1, 0))
    for _ in range(24):
        samples = image + rng.normal(0.0, 0.8 / 280, image.shape)
        edge = measure_edge(Plane(name="R", samples=samples, step=(2, 2), first=(1, 0)), Roi(0, 0, 36, 48))
        off.append((edge.figures.angle_deg - 4.75) / edge.standard_error.angle_deg)
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 1.3


def test_noise_that_hides_the_direction_is_refused_or_said():
    rng = np.random.default_rng(1)
    samples = gaussian_edge(24, 24, -8.0, gaussian_sigma(0.5), step=2) + rng.normal(0.0, 0.8 / 4, (12, 12))
    with pytest.raises(UnsupportedError):
        measure_edge(Plane(name="R", samples=samples, step=(2, 2)), Roi(0, 0, 24, 24))
