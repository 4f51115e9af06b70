"""Expected cost of ringing, for ends and short edges, and the choice of a table for the latter."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.rendering.boundary.image import inside_length, rings_order, turns
from camsim.rendering.boundary.ring_table import BEYOND, MARGIN, harmonics_counted, ring_step
from camsim.rendering.boundary.rings import RAY_NODES, piece_nodes, ring_terms
from camsim.rendering.boundary.settings import Settings
from camsim.rendering.edges import Edges
from camsim.rendering.focus import ZONE
from camsim.rendering.footprint import Footprint
from camsim.rendering.grid import Grid

RING_BYTES = 512e6  # of the table: beyond, pieces are summed by wavelength, which takes fifty times as long
# Costs of nodes and pieces in addition to their terms and harmonics, in units of these; of a row of the table per
# oscillation, in addition to 0.6 of a power per set; and of an amplitude at one node of the footprint.
OF_RAY, OF_NODE, OF_PIECE = 84.0, 12.0, 60.0
OF_LOOK_UP, OF_TABLED = 2.0, 18.0
OF_ROW, OF_SET, OF_AMPLITUDE = 80.0, 0.6, 130.0
# Nanoseconds of one core: per term of a series at a node, per harmonic looked up; per value and term of tables.
TERM, HARMONIC, VALUE, OF_TABLE = 2.0, 6.8, 3.0, 0.5
MOST_ROWS = 128  # rows that are counted for the photosites in a circle
MOST_ENDS = 512  # ends whose surroundings are counted; larger numbers are thinned out


class RingCounts(NamedTuple):
    """Counts of operations for ringing.

    terms        : of series, at nodes on rays from ends and on short edges, for each wavelength and oscillation
    harmonics    : at nodes on short edges, for all wavelengths together, by the table
    rows         : of the table, 0 for none
    table_values : in the table;  table_terms: summed for it, and for the amplitudes that both methods need
    """

    terms: float
    harmonics: float
    rows: int
    table_values: float
    table_terms: float


NO_RINGS = RingCounts(0.0, 0.0, 0, 0.0, 0.0)


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


def beyond(radius: F64, near: float) -> F64:
    """Return how many photosites in the zone about a circle's centre have part of the circle farther than ``near``.

    >>> beyond(np.array([5.0, 10.0, 20.0]), 10.0).round(2)
    array([ 0.  ,  6.28, 50.27])
    """
    share = np.clip((radius - near) / (ZONE * radius), -1.0, 1.0)
    area: F64 = (ZONE * radius) ** 2 * (np.pi - np.arccos(share) + share * np.sqrt(1.0 - share**2))
    return area


def ring_counts(
    edges: Edges,
    grid: Grid,
    settings: Settings,
    footprint: Footprint,
    *,
    in_foci: tuple[I64, I64],
    sets: int,
    oscillations: int,
    parts: int,
) -> RingCounts:
    """Count the operations for ringing, with the table if that is cheaper for all parts together.

    in_foci : the edges of each of the settings' foci
    sets  : pairs of spectra times channels;  oscillations: of the pattern, times wavelengths
    """
    near, radius = settings.near, settings.foci.radius
    if settings.negligible_end <= near and not len(radius):
        return NO_RINGS
    shortest = settings.shortest
    short = piece_nodes(edges.length, shortest, settings.tolerance)
    of_each = np.stack([np.where(short > 0.0, 0.0, 2.0 * RAY_NODES), short, short > 0.0], axis=1)
    of_turns = turns(footprint)
    harmonics = harmonics_counted(footprint.extent, shortest, turns=of_turns, tolerance=settings.tolerance)
    of_terms = ring_terms(footprint.extent, shortest, turns=of_turns, nearest=near)
    terms = float(math.prod(of_terms))

    def photosites(until: float) -> F64:
        """Return photosites × nodes on rays, × nodes on pieces nearer than ``until``, and × such pieces."""
        found = np.zeros(3)
        reach = min(until, settings.negligible_end)
        if reach > near:
            thin = max(1, math.ceil(len(edges) / MOST_ENDS))
            seen = [0.5 * thin * (within(p[::thin], reach, grid) - within(p[::thin], near, grid)) for p in ends]
            found += sum(seen) @ of_each[::thin]
        if len(radius):
            first, picked = in_foci
            summed = np.concatenate([np.zeros((1, 3)), np.cumsum(of_each[picked], axis=0)])[first]
            about = np.minimum(beyond(radius, near), grid.rows * grid.cols)
            found += np.where(radius <= until, about, 0.0) @ np.diff(summed, axis=0)
        return found

    ends = edges.start, edges.end
    on_rays, on_pieces, pieces = photosites(math.inf).tolist()
    if settings.negligible_line > settings.reach:
        # A line has two more ends, at the foot of the perpendicular.
        long, across = edges.some(edges.length >= near), math.hypot(grid.rows, grid.cols)
        band = min(2.0 * (settings.negligible_line - settings.reach), across)
        beside = np.minimum(inside_length(long, grid, settings.negligible_line) * band, grid.rows * grid.cols)
        on_rays += 2.0 * RAY_NODES * float(beside.sum())
    points = len(footprint.spots) * rings_order(footprint, shortest) ** 2
    direct = RingCounts(
        terms=oscillations * (on_rays * (terms + OF_RAY) + on_pieces * (terms + OF_NODE)) + OF_PIECE * pieces,
        harmonics=0.0,
        rows=0,
        table_values=0.0,
        table_terms=OF_AMPLITUDE * terms * points * oscillations,
    )
    farthest = edges.some(short > 0.0).farthest(grid)
    farthest = min(farthest, max(settings.negligible_end, (1.0 + 2.0 * ZONE) * float(radius.max(initial=0.0))))
    step, columns = ring_step(shortest, settings.tolerance), 4.0 * harmonics
    rows = min(math.ceil(max(farthest - near, 0.0) / step), int(RING_BYTES / (8.0 * sets * columns))) + MARGIN + BEYOND
    _, looked_up, pieces = photosites(near + (rows - MARGIN - BEYOND) * step).tolist()
    table = RingCounts(
        terms=max(direct.terms - oscillations * looked_up * (terms + OF_NODE) - OF_PIECE * pieces, 0.0),
        harmonics=looked_up * (harmonics + OF_LOOK_UP) + OF_TABLED * pieces,
        rows=rows,
        table_values=rows * columns * sets,
        table_terms=direct.table_terms + rows * oscillations * (OF_ROW + columns * (of_terms[1] + OF_SET * sets)),
    )
    return min(direct, table, key=lambda counts: _nanoseconds(counts, parts))


def _nanoseconds(counts: RingCounts, parts: int) -> float:
    of_each = TERM * counts.terms + HARMONIC * counts.harmonics
    return parts * of_each + VALUE * counts.table_values + OF_TABLE * counts.table_terms
