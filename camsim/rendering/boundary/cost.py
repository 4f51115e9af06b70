"""What a rendering is expected to take, a pure function of the inputs: no clock, no core count, no history.

Seconds are those of one core, all threads' work added up: two idle cores take about half as long. The model counts what
the boundary engine does (photosites, look-ups of lines, quadrature nodes near ends, sources collected on tiles, numbers
in tables) and prices each; prices were fitted to the shipped scenes and random ones (``bench/cost.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.rendering.boundary.focus import ZONE, touching
from camsim.rendering.boundary.image import directions, largest_tile
from camsim.rendering.boundary.settings import PANEL_BLURS, Settings
from camsim.rendering.edges import Edges, shares_within
from camsim.rendering.engine import SET_UP_SECONDS, Cost
from camsim.rendering.footprint import Footprint
from camsim.rendering.grid import Grid

MATRIX, SINE, RING_TABLE = 0.1, 20.0, 2e7  # terms: of a matrix product, one sine, one wavelength's rings
MOST_ROWS = 128  # looked at for the photosites in a circle
MOST_ENDS = 512  # looked at for what lies near; more are thinned out


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """What the boundary engine is going to do for one image.

    photosites : of the grid;  near_nodes: quadrature nodes near ends;  looked_up: photosites × lines close by
    ringed     : ends × photosites where rings are computed, × wavelengths × tones
    close      : photosites × edges just beyond the near zone;  collected: sources × tiles that sum them up
    tables     : fields and edge responses;  table_values: numbers in them;  table_terms: terms added up for them
    """

    photosites: float
    near_nodes: float
    looked_up: float
    ringed: float
    close: float
    collected: float
    tables: int
    table_values: float
    table_terms: float


def within(points: F64, radius: float, grid: Grid) -> F64:
    """Return how many photosites of the grid lie within ``radius`` of each point (n, 2), pitches.

    Chords of the circle, row by row; of many rows every so many-th.

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


def _inside_length(edges: Edges, grid: Grid, margin: float) -> F64:
    """Return the length of each edge within the grid, widened by ``margin``, pitches."""
    low = np.array(grid.first_centre) - margin
    high = low + np.array([grid.cols - 1 + 2 * margin, grid.rows - 1 + 2 * margin])
    enters, leaves = shares_within(edges.start, edges.end, low, high)
    length: F64 = np.maximum(leaves - enters, 0.0) * edges.length
    return length


def boundary_counts(
    edges: Edges, grid: Grid, settings: Settings, footprint: Footprint, *, sets: int, wavelengths: int, tones: int
) -> Counts:
    """Count what the boundary engine is going to do; ``sets``: pairs of spectra times channels; ``tones``: of the pattern."""
    start, end, length = edges.start, edges.end, edges.length
    long = length >= settings.near
    thin = max(1, math.ceil(len(start) / MOST_ENDS))
    ends = np.concatenate([start[::thin], end[::thin]])
    is_long = np.tile(long[::thin], 2)
    share = np.where(is_long, 1.0, 0.5) * thin  # a short edge is one source, a long one two
    near = within(ends, settings.near, grid)
    # Mean of √(near² − h²) over the disc, less what lies before the foot: half of it; a short edge is all there is.
    chord = np.where(is_long, 0.85 * settings.near, np.minimum(np.tile(length[::thin], 2), 1.7 * settings.near))
    nodes = np.ceil(chord / settings.panel) * settings.panel_nodes
    close = within(ends, settings.near + settings.leaf, grid) - near
    root = largest_tile(settings, (grid.rows, grid.cols))
    # A tile that sees nothing but lines is not quartered: all of it looks them up.
    band = 2.0 * settings.reach + root
    looked_up = float(np.sum(np.minimum(_inside_length(edges.some(long), grid, settings.reach), 1e9))) * band
    photosites = float(grid.rows * grid.cols)
    roots = -(-grid.rows // root) * -(-grid.cols // root)
    levels = 1.0 + math.log2(root / settings.leaf)
    ringed = 0.0
    if settings.quiet_end > settings.near:
        ringed = float((within(ends, settings.quiet_end, grid) - near).sum()) * thin * wavelengths * tones
    foci = settings.foci
    if len(foci.radius):
        of_each = np.diff(touching(foci, edges)[0])
        ringed += 2.0 * float((ZONE * foci.radius) ** 2 @ of_each) * math.pi * wavelengths * tones
    collected = len(start) * (roots + 12.0 * levels) * settings.tile_nodes**2
    rows = settings.near / settings.field_step
    taps = (2.0 * footprint.extent) / settings.field_step
    along = (end - start) / length[:, None]
    normals = len(directions(along[:, 0], along[:, 1], long, footprint)[1])
    cells = settings.reach / settings.response_step
    # Nodes of the edge responses' integrals: some between every two cut-offs, and what the phase asks for.
    shortest = settings.panel / PANEL_BLURS
    waves = 14.0 * wavelengths + 1.1 * math.pi * (settings.reach + footprint.extent) / shortest
    return Counts(
        photosites=photosites,
        near_nodes=float(near @ (nodes * share)),
        looked_up=min(looked_up, photosites * float(np.count_nonzero(long))),
        ringed=ringed,
        close=float(close @ share),
        collected=collected,
        tables=sets * (1 + normals),
        table_values=sets * (2.0 * rows * rows + normals * 6.0 * cells),
        table_terms=sets * (rows * (rows + taps) * (taps + 8.0) + MATRIX * normals * cells * waves)
        + SINE * cells * waves
        + RING_TABLE * wavelengths * tones * (settings.quiet_end > settings.near),
    )


# Nanoseconds of one core each.
PRICES = {
    "photosites": 8.0,
    "near_nodes": 24.0,
    "looked_up": 11.0,
    "ringed": 14_900.0,
    "close": 45.0,
    "collected": 4.6,
    "table_values": 3.0,
    "table_terms": 0.5,
}


def boundary_cost(counts: Counts) -> Cost:
    """Price the counts."""
    seconds = SET_UP_SECONDS + sum(price * 1e-9 * getattr(counts, name) for name, price in PRICES.items())
    return Cost(
        seconds=seconds,
        memory_bytes=8.0 * (counts.photosites + counts.table_values) + 4e6,
    )
