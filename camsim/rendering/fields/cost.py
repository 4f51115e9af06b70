"""What pictures take: a window's seconds and bytes, layer by layer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fourier.blocks import Tile

STRIP_POINTS = 2_500_000  # frequencies that are spread to at a time

# Seconds of one core, measured.
PER_POINT_WEIGHT, PER_POINT, PER_SAMPLE, PER_SAMPLE_STRIP = 8e-9, 1.6e-7, 2e-7, 1.2e-7
PER_LATTICE_SAMPLE, PER_WAVE, PER_POINT_CURVE = 4e-8, 3e-8, 2e-9


class Taken(NamedTuple):
    """Seconds of one core, and bytes held."""

    seconds: float
    held_bytes: float


def taken(layer: Layer, step: float, box: tuple[F64, F64], tile: Tile, *, weights: int, aligned: bool) -> Taken:
    """Return what a layer takes on a window.

    step    : of its samples once they are refined;  box: that they lie in
    weights : channels, times wavelengths where each has a transfer of its own;  aligned: whether they are a lattice
    """
    planes = layer.planes
    area = float(np.prod(np.maximum(box[1] - box[0], 0.0)))
    samples = min(area, layer.shape[0] * layer.shape[1] * layer.step**2) / step**2
    period = float(tile.periods[0] * tile.periods[1])
    if aligned:
        frequencies = period / step**2
        seconds = planes * (samples + frequencies) * PER_LATTICE_SAMPLE
        seconds += weights * tile.points * (PER_WAVE + planes * PER_POINT_CURVE)
        held = planes * (24.0 * samples + 12.0 * frequencies) + 24.0 * tile.cut * tile.periods[0] * tile.rows
        return Taken(seconds, held)
    seconds = tile.points * planes * (weights * PER_POINT_WEIGHT + PER_POINT)
    seconds += samples * (PER_SAMPLE + planes * PER_SAMPLE_STRIP * max(1.0, tile.points / STRIP_POINTS))
    held = 8.0 * weights * period + samples * (40.0 + 40.0 * planes)
    return Taken(seconds, held + 16.0 * min(STRIP_POINTS, 2.0 * tile.points) * (planes + 12))


def windows(shape: tuple[int, int], side: int) -> list[tuple[int, int, int, int]]:
    """Return windows (row, col, rows, cols) of a frame, about alike.

    >>> windows((5, 3), 4)
    [(0, 0, 3, 3), (3, 0, 2, 3)]
    """
    rows, cols = (-(-size // -(-size // side)) for size in shape)
    return [
        (row, col, min(rows, shape[0] - row), min(cols, shape[1] - col))
        for row in range(0, shape[0], rows)
        for col in range(0, shape[1], cols)
    ]
