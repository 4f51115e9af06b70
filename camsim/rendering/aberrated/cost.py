"""What a difference is expected to take, a pure function of the inputs; prices were fitted by ``bench/aberrations.py``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.rendering.aberrated.image import MANY, ShortImage
from camsim.rendering.engine import Cost
from camsim.rendering.fourier.plan import MOST_NODES, OF_NODES, spreading_precision
from camsim.quadrature import gauss_pieces


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """What is going to be done for one image of a difference.

    pupil_nodes : at all wavelengths;  pattern_samples: of all their patterns;  transformed: points of the transfers
    responses   : of lines, each with ``response_points`` frequencies for each of ``sets`` patterns
    crossings   : edges × rows;  looked_up: photosites × lines
    windows     : of ``frequencies`` each;  window_edges: edge × frequency of them all;  clamped: edges × windows
    summed      : frequency × patterns of all windows
    held        : numbers that stay in memory
    """

    pupil_nodes: float
    pattern_samples: float
    fused_samples: float
    transformed: float
    responses: int
    response_points: float
    crossings: float
    looked_up: float
    windows: int
    frequencies: float
    window_edges: float
    window_spread: float
    clamped: float
    summed: float
    held: float


def short_counts(image: ShortImage) -> Counts:
    """Count what a difference is going to take."""
    job, settings, pattern = image.job, image.settings, image.pattern
    grid, edges, count = job.grid, job.edges, image.nodes.wavelength_nm.size
    size, reach, _ = pattern.lattice
    samples, points = (2.0 * reach + 1.0) ** 2, float(size) ** 2
    sets = len(pattern.sets[0])
    outer_um = math.sqrt(2.0) * settings.outer * grid.pitch_um
    nodes = sum(image.rest.pupil_nodes(float(nm))(outer_um) for nm in image.nodes.wavelength_nm)
    tile = settings.tile(0, 0, settings.side, settings.side)
    normals, windows = len(image.lines[1]), len(image.windows)
    in_one = min(float(len(edges)), 4.0 + len(edges) * min(1.0, _share(image)))
    channels = len(np.unique(job.signals.scale)) and job.signals.scale.size
    spectra = min(len(job.signals.density) - 1.0, 2.0)
    by_edge = in_one <= MANY
    phase = np.array([math.pi * settings.cut * min(float(np.median(edges.length)), settings.side)])
    pieces, orders = gauss_pieces(phase, OF_NODES * spreading_precision(job.tolerance), MOST_NODES)
    inside = float(np.minimum(edges.length, grid.rows + grid.cols).sum())
    return Counts(
        pupil_nodes=nodes,
        pattern_samples=count * samples,
        fused_samples=sets * count * samples,
        transformed=sets * points,
        responses=normals,
        response_points=sets * normals * settings.cut * 3.0 * settings.outer + sets * 2.0 * samples * (normals > 0),
        crossings=2.0 * len(edges) * grid.rows,
        looked_up=2.0 * settings.near * inside * (normals > 0),
        windows=windows,
        frequencies=tile.points,
        window_edges=windows * tile.points * in_one * by_edge,
        window_spread=windows * (tile.points * 3.0 + in_one * float(pieces[0] * orders[0]) * 2.0) * (not by_edge),
        clamped=float(windows) * len(edges),
        summed=windows * tile.points * spectra * channels + windows * channels * settings.period**2 * 2.0,
        held=sets * (samples + points + 2.0 * tile.points) + 2.0 * grid.rows * grid.cols + 6.0 * samples,
    )


def _share(image: ShortImage) -> float:
    """Return what part of all edges one window holds, on average."""
    area, windows = float(image.settings.side + 2.0 * image.settings.near) ** 2, max(len(image.windows), 1)
    low, high = image.job.edges.points.min(axis=0), image.job.edges.points.max(axis=0)
    everything = float(np.prod(np.maximum(high - low, 1.0)))
    return max(area / max(everything, area), min(1.0, area / image.settings.side**2 / windows))


# Nanoseconds of one core each.
PRICES = {
    "pupil_nodes": 60.0,
    "pattern_samples": 120.0,
    "fused_samples": 1.0,
    "transformed": 15.0,
    "response_points": 60.0,
    "crossings": 1.0,
    "looked_up": 10.0,
    "windows": 1.5e6,
    "window_edges": 1.1,
    "window_spread": 80.0,
    "clamped": 300.0,
    "summed": 6.0,
}
SET_UP_SECONDS = 3e-3


def short_cost(counts: Counts) -> Cost:
    """Price the counts."""
    seconds = SET_UP_SECONDS + sum(price * 1e-9 * getattr(counts, name) for name, price in PRICES.items())
    return Cost(seconds=seconds, memory_bytes=8.0 * counts.held)
