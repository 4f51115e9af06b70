"""What a difference is expected to take, a pure function of the inputs; compared by ``bench.aberrations auto``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.quadrature import gauss_pieces
from camsim.rendering.aberrated.image import ShortImage
from camsim.rendering.engine import Cost
from camsim.rendering.fourier.nearby import MANY
from camsim.rendering.fourier.task import MOST_NODES, OF_NODES, spreading_precision

SEEN = 2.0  # spectra in one window besides the background's


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """What is going to be done for one image of a difference.

    transfers_seconds : what these take
    responses   : of lines
    crossings   : edges × rows;  looked_up: photosites × lines
    windows     : of ``frequencies`` each;  clamped: edges × windows
    window_edges, window_spread : edge × frequency of all windows, or nodes and frequencies of non-uniform transforms
    summed      : frequencies × signals of all windows, and what is transformed back
    held        : numbers of 8 bytes that stay in memory
    """

    transfers_seconds: float
    responses: int
    crossings: float
    looked_up: float
    windows: int
    frequencies: float
    clamped: float
    window_edges: float
    window_spread: float
    summed: float
    held: float


def short_counts(image: ShortImage) -> Counts:
    """Count what a difference is going to take."""
    job, settings, pattern = image.job, image.settings, image.pattern
    grid, edges, transfers = job.grid, job.edges, pattern.transfers
    frequencies = settings.tile(0, 0, settings.side, settings.side).points
    normals, windows = len(image.lines[1]), len(image.windows)
    in_one = min(float(len(edges)), 4.0 + len(edges) * _share(image))
    signals = min(len(job.signals.density) - 1.0, SEEN) * job.signals.scale.size
    by_edge = in_one <= MANY
    phase = np.array([math.pi * settings.cut * min(float(np.median(edges.length)), settings.side)])
    pieces, orders = gauss_pieces(phase, OF_NODES * spreading_precision(job.tolerance), MOST_NODES)
    spread = frequencies * 3.0 + in_one * float(pieces[0] * orders[0]) * 2.0
    inside = float(np.minimum(edges.length, grid.rows + grid.cols).sum())
    return Counts(
        transfers_seconds=transfers.seconds(normals),
        responses=normals,
        crossings=2.0 * len(edges) * grid.rows,
        looked_up=2.0 * settings.near * inside if normals else 0.0,
        windows=windows,
        frequencies=frequencies,
        clamped=float(windows) * len(edges),
        window_edges=windows * frequencies * in_one if by_edge else 0.0,
        window_spread=0.0 if by_edge else windows * spread,
        summed=windows * (frequencies * signals + 2.0 * job.signals.scale.size * settings.period**2),
        held=transfers.held + 4.0 * len(transfers.weights) * frequencies + 2.0 * grid.rows * grid.cols,
    )


def _share(image: ShortImage) -> float:
    """Return what part of all edges one window sees, on average."""
    area, windows = float(image.settings.side + 2.0 * image.settings.near) ** 2, max(len(image.windows), 1)
    low, high = image.job.edges.box
    everything = float(np.prod(np.maximum(high - low, 1.0)))
    return max(area / max(everything, area), min(1.0, area / image.settings.side**2 / windows))


# Nanoseconds of one core each.
PRICES = {
    "crossings": 1.0,
    "looked_up": 10.0,
    "windows": 1.5e6,
    "window_edges": 1.1,
    "window_spread": 50.0,
    "clamped": 300.0,
    "summed": 3.0,
}
SET_UP_SECONDS = 3e-3


def short_cost(counts: Counts) -> Cost:
    """Price the counts."""
    priced = sum(price * 1e-9 * getattr(counts, name) for name, price in PRICES.items())
    seconds = SET_UP_SECONDS + counts.transfers_seconds + priced
    return Cost(seconds=seconds, memory_bytes=8.0 * counts.held)
