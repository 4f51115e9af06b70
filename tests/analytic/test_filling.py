"""What lies between every n-th photosite, filled in: of waves, whose values are known everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from camsim.rendering.across.chords import chords_of, heights
from camsim.rendering.across.filling import ALL, POINTS, STEPS, coarsest
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.inverse import filled

ROWS, COLS = 61, 74


def image_of(waves: np.ndarray, y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the sum of waves (size, phase, fx, fy) at rows and columns."""
    return sum(a * np.cos(2.0 * np.pi * (fx * x[None, :] + fy * y[:, None]) + phase) for a, phase, fx, fy in waves)


@pytest.mark.parametrize("allowed", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("cut", [0.05, 0.11, 0.19])
@pytest.mark.parametrize("every", [(slice(None), slice(None)), (slice(1, None, 2), slice(0, None, 2))])
def test_waves_are_filled_in_to_what_is_allowed(cut: float, allowed: float, every: tuple[slice, slice]) -> None:
    """Waves in any direction, as loud as a band's slope lets each through."""
    frequency = np.linspace(0.0, cut, 40)
    density = (1.0 - frequency / cut) ** 4 / cut
    between = coarsest(frequency, density, allowed)
    step, points = between.shape
    assert step in (*STEPS, 1)
    rng = np.random.default_rng(7)
    f, turn = rng.uniform(0.0, cut, 300), rng.uniform(0.0, 2.0 * np.pi, 300)
    size = (1.0 - f / cut) ** 4 / 300.0
    waves = np.stack([size, rng.uniform(0.0, 6.0, 300), f * np.cos(turn), f * np.sin(turn)], axis=1)
    before = max(0, points // 2 - 1)
    y, x = (step * (np.arange((count - 1) // step + points) - before) for count in (ROWS, COLS))
    found = filled(image_of(waves, y, x), between, ROWS, COLS, every)
    right = image_of(waves, np.arange(ROWS)[every[0]], np.arange(COLS)[every[1]])
    assert np.abs(found - right).max() <= allowed


def test_steps_are_as_large_as_the_band_is_smooth() -> None:
    """And none is taken where a band is too fine for any."""
    of = {cut: len(coarsest(np.linspace(0.0, cut, 40), np.ones(40), 1e-6)) for cut in (0.03, 0.06, 0.15, 0.26, 0.6)}
    assert list(of.values()) == sorted(of.values(), reverse=True)
    assert of[0.03] == STEPS[0]
    assert of[0.6] == 1
    assert coarsest(np.linspace(0.0, 0.24, 40), np.ones(40), 1e-12) is ALL
    assert max(POINTS) == POINTS[0]


def test_chords_are_nowhere_farther_than_allowed() -> None:
    """An arc of many sides beside a straight one with a corner: shapes stay closed, corners where they are."""
    angle = np.linspace(0.0, np.pi, 200)
    points = np.concatenate([30.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1), [[-30.0, -5.0], [30.0, -5.0]]])
    edges = Edges(
        start=points, end=np.roll(points, -1, axis=0), left=np.ones(len(points), int), right=np.zeros(len(points), int)
    )
    for highest in (1e-2, 1e-1):
        found = chords_of(edges, highest)
        assert len(found.edges) < 0.5 * len(edges)
        np.testing.assert_array_equal(found.edges.start[1:], found.edges.end[:-1])
        np.testing.assert_array_equal(found.edges.start[0], found.edges.end[-1])
        assert max(np.abs(heights(own)[1]).max() for own in found.points) <= highest
        assert {(-30.0, -5.0), (30.0, -5.0)} <= {tuple(point) for point in found.edges.start}
    assert chords_of(edges, 0.0).edges is edges
