"""Expected cost of a rendering, by the inputs alone: no clock, no number of cores and no history enter.

Seconds are those of one core, summed over all threads: two idle cores take about half as long. The model counts the
boundary engine's operations (photosites, look-ups of lines, quadrature nodes near ends, sources collected on tiles,
numbers in tables) and prices each; prices were fitted to the shipped scenes and random ones (``bench/cost.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.rendering.boundary.image import inside_length, largest_tile
from camsim.rendering.boundary.potential import ORDER
from camsim.rendering.boundary.settings import Settings
from camsim.rendering.edges import Edges
from camsim.rendering.engine import SET_UP_SECONDS, Cost
from camsim.rendering.footprint import Footprint
from camsim.rendering.grid import Grid

MATRIX, SINE = 0.1, 20.0  # costs in terms: of a term of a matrix product, of a sine
MOST_ROWS = 128  # rows that are counted for the photosites in a circle
MOST_ENDS = 512  # ends whose surroundings are counted; larger numbers are thinned out


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """Counts of the boundary engine's operations for one image.

    photosites : those of the grid;  near_nodes: quadrature nodes near ends;  looked_up: photosites × nearby lines
    close      : photosites × edges just beyond the near zone
    collected  : sources × tiles that sum them
    tables     : fields and edge responses
    table_values : numbers in all of them;  table_terms: terms summed for them
    """

    photosites: float
    near_nodes: float
    looked_up: float
    close: float
    collected: float
    tables: int
    table_values: float
    table_terms: float


def within(points: F64, radius: float, grid: Grid) -> F64:
    """Return how many photosites of the grid lie within ``radius`` of each point (n, 2), pitches.

    They are counted on the circle's chord in each row, or in a subset of many rows.

    >>> within(np.array([[0.0, 0.0]]), 1.0, Grid(rows=2, cols=4, pitch_um=1.0))
    array([4.])
    """
    x0, y0 = grid.first_centre
    first = max(0, math.ceil(float(points[:, 1].min()) - radius - y0))
    last = min(grid.rows - 1, math.floor(float(points[:, 1].max()) + radius - y0))
    step = max(1, (last - first + 1) // MOST_ROWS)
    row = np.arange(first, last + 1, step)[:, None]
    half = np.sqrt(np.maximum(radius**2 - (y0 + row - points[:, 1]) ** 2, 0.0))
    left = np.maximum(np.ceil(points[:, 0] - half - x0), 0.0)
    right = np.minimum(np.floor(points[:, 0] + half - x0), grid.cols - 1.0)
    counts: F64 = np.where(half > 0.0, np.maximum(right - left + 1.0, 0.0), 0.0).sum(axis=0)
    return step * counts


def boundary_counts(
    edges: Edges,
    grid: Grid,
    settings: Settings,
    footprint: Footprint,
    *,
    normals: int,
    sets: int,
    wavelengths: int,
) -> Counts:
    """Count the boundary engine's operations.

    normals : number of edge responses
    sets : pairs of spectra times channels
    """
    start, end, length = edges.start, edges.end, edges.length
    long = length >= settings.near
    thin = max(1, math.ceil(len(start) / MOST_ENDS))
    ends = np.concatenate([start[::thin], end[::thin]])
    is_long = np.tile(long[::thin], 2)
    share = np.where(is_long, 1.0, 0.5) * thin  # a short edge is one source, a long one two
    near = within(ends, settings.near, grid)
    # Mean of √(near² − h²) over the disc, minus half of the part before the foot; a short edge counts entirely.
    chord = np.where(is_long, 0.85 * settings.near, np.minimum(np.tile(length[::thin], 2), 1.7 * settings.near))
    nodes = np.ceil(chord / settings.panel) * settings.panel_nodes
    close = within(ends, settings.near + settings.leaf, grid) - near
    root = largest_tile(settings, (grid.rows, grid.cols))
    # A tile with nothing but lines left is not quartered: all of its photosites look them up.
    band = 2.0 * settings.reach + root
    looked_up = float(np.sum(np.minimum(inside_length(edges.some(long), grid, settings.reach), 1e9))) * band
    photosites = float(grid.rows * grid.cols)
    roots = -(-grid.rows // root) * -(-grid.cols // root)
    levels = 1.0 + math.log2(root / settings.leaf)
    shortest = settings.shortest
    order = min(settings.tile_nodes, root) if root == settings.leaf else settings.tile_nodes
    collected = len(start) * (roots + 12.0 * levels) * order**2
    rows = settings.near / settings.field_step
    taps = 2.0 * footprint.extent / settings.field_step
    # A slope has the taps of a Lagrange rule at either side of every spot.
    terms = ORDER + taps + ORDER + 2.0 * ORDER * len(footprint.grid[0])
    cells = settings.reach / settings.response_step
    # Nodes of the edge responses' integrals: some between every two cut-offs, and more in proportion to the phase.
    waves = 14.0 * wavelengths + 1.1 * math.pi * (settings.reach + footprint.extent) / shortest
    return Counts(
        photosites=photosites,
        near_nodes=float(near @ (nodes * share)),
        looked_up=min(looked_up, photosites * float(np.count_nonzero(long))),
        close=float(close @ share),
        collected=collected,
        tables=sets * (1 + normals),
        table_values=sets * (2.0 * rows * rows + normals * 6.0 * cells),
        table_terms=sets * (rows * (rows + 0.5 * taps) * terms + MATRIX * normals * cells * waves)
        + SINE * cells * waves,
    )


# Nanoseconds of one core each.
PRICES = {
    "photosites": 8.0,
    "near_nodes": 24.0,
    "looked_up": 11.0,
    "close": 45.0,
    "collected": 4.6,
    "table_values": 3.0,
    "table_terms": 0.5,
}


def boundary_cost(counts: Counts) -> Cost:
    """Return the cost of the counts."""
    return Cost(
        seconds=SET_UP_SECONDS + sum(price * 1e-9 * getattr(counts, name) for name, price in PRICES.items()),
        memory_bytes=8.0 * (counts.photosites + counts.table_values) + 4e6,
    )
