"""Edges as a source: their transform by quadrature is as exact as the light that passes needs."""

import math

import numpy as np
import pytest

from camsim.rendering.edges import Edges
from camsim.rendering.waves.edges import EdgeSource
from camsim.rendering.waves.levels import Lattice

PERIOD, CUT, SIDES, RADIUS = 128, 0.8, 150, 30.0  # pitches, cycles/pitch


def outline():
    angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
    corners = RADIUS * np.stack([1.3 * np.cos(angle), np.sin(angle)], axis=1) + [0.3, -0.2]
    return corners, np.roll(corners, -1, axis=0)


def exact(start, end, fx, fy):
    """Return the transform of the region, side by side, with sinc for each."""
    middle, (ex, ey) = 0.5 * (start + end), (end - start).T[:, :, None, None]
    phase = np.exp(-2j * math.pi * (fx * middle[:, 0, None, None] + fy * middle[:, 1, None, None]))
    sides = (fx * ey - fy * ex) * np.sinc(fx * ex + fy * ey) * phase
    square = np.where(np.hypot(fx, fy) == 0.0, 1.0, fx * fx + fy * fy)
    area = 0.5 * np.sum(start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1])
    return np.where(np.hypot(fx, fy) == 0.0, area, 1j * sides.sum(axis=0) / (2.0 * math.pi * square))


@pytest.mark.parametrize("steep", [0.0, 2.0, 6.0])
@pytest.mark.parametrize("precision", [1e-3, 1e-5, 1e-8])
def test_an_image_by_quadrature_is_right_to_the_precision(precision, steep):
    """The error is that of an image behind the lens: at the cut-off, which hardly passes, transforms err by more."""
    start, end = outline()
    frequency = np.linspace(0.0, CUT, 200)
    none = np.zeros(SIDES, np.int64)
    source = EdgeSource(
        edges=Edges(start=start, end=end, left=none + 1, right=none),
        shares=np.array([[0.0], [1.0]]),
        precision=precision,
        passes=(frequency, (1.0 - frequency / CUT) ** steep),
    )
    lattice = Lattice((PERIOD, PERIOD), CUT, (-64.0, -64.0), (64.0, 64.0))
    [found] = source.transform(lattice, (0.0, 0.0))
    columns, rows = lattice.counts
    fx, fy = np.arange(columns) / PERIOD, np.arange(1 - rows, rows)[:, None] / PERIOD
    radius = np.hypot(fx, fy)
    passes = np.where(radius <= CUT, np.maximum(1.0 - radius / CUT, 0.0) ** steep, 0.0)
    points = 2 * PERIOD  # of the image: two a pitch, so that all frequencies are below Nyquist's
    error = np.zeros((points, columns), complex)
    error[np.arange(1 - rows, rows) % points] = (found - exact(start, end, fx, fy)) * passes
    image = np.fft.irfft2(error, (points, points)) * (points / PERIOD) ** 2
    assert np.abs(image).max() <= precision
