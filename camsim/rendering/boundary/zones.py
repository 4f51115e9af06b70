"""Zones about the foci of round outlines, in which ringing is added up to the distance of the outline."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.kernels import kernel, shared
from camsim.rendering.boundary.edge_rings import rings_at
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables


class Zones(NamedTuple):
    """Circles in which the ringing of some edges is added."""

    circle: F64  # (n, 3) x, y and radius
    first: I64  # (n + 1,) where each circle's edges begin in ``picked``
    picked: I64  # indices of the edges


def add_rings_in_zones(
    x0: float,
    y0: float,
    zones: Zones,
    channel: U8,
    image: F64,
    edges: TabledEdges,
    tables: Tables,
    long: Numbers,
    short: Numbers,
) -> None:
    """Add the ringing of far edges to the photosites of zones, once for each edge.

    x0, y0 : of the image's first photosite
    long, short : radii up to which ringing is in the image already (``near``, ``reach``) and up to which it is needed
                  (``negligible_end``, ``negligible_line``), for edges with a response and without
    """

    def work(begin: int, end: int) -> None:
        added_at = np.empty(edges.x.size, np.int64)
        _add_to_rows((begin, end), (x0, y0), zones, channel, image, edges, tables, (long, short), added_at)

    shared(len(image), work)


@kernel(allocates=True)
def _add_to_rows(
    rows: tuple[int, int],
    origin: tuple[float, float],
    zones: Zones,
    channel: U8,
    image: F64,
    edges: TabledEdges,
    tables: Tables,
    reaches: tuple[Numbers, Numbers],
    added_at: I64,
) -> None:
    """Add ringing to some rows; ``added_at``: (edges,) memory."""
    circle, first, picked = zones
    (x0, y0), (long, short), cols = origin, reaches, image.shape[1]
    zone_of, begins, ends = np.empty((3, len(circle)), np.int64)
    for r in range(rows[0], rows[1]):
        y, count = y0 + r, 0
        for zone in range(len(circle)):
            half2 = circle[zone, 2] ** 2 - (y - circle[zone, 1]) ** 2
            if half2 >= 0.0:
                middle, half = circle[zone, 0] - x0, math.sqrt(half2) + 1.0  # with a margin; tested exactly below
                zone_of[count] = zone
                begins[count], ends[count] = max(0, math.ceil(middle - half)), math.floor(middle + half)
                count += 1
        added_at[:] = -1
        from_left = np.argsort(begins[:count])
        # Candidate zones of a photosite: those that have begun, without those found to have ended.
        begun, held, near = 0, 0, np.empty(count, np.int64)
        for c in range(begins[from_left[0]] if count else cols, cols):
            while begun < count and begins[from_left[begun]] <= c:
                near[held] = from_left[begun]
                begun, held = begun + 1, held + 1
            x, k = x0 + c, 0
            while k < held:
                if ends[near[k]] < c:
                    held -= 1
                    near[k] = near[held]
                    continue
                zone = zone_of[near[k]]
                k += 1
                if (x - circle[zone, 0]) ** 2 + (y - circle[zone, 1]) ** 2 > circle[zone, 2] ** 2:
                    continue
                for e in picked[first[zone] : first[zone + 1]]:
                    if added_at[e] == c:
                        continue
                    added_at[e] = c
                    image[r, c] += rings_at(
                        x, y, e, channel[r, c], edges, tables, long if edges.response[e] >= 0 else short
                    )
