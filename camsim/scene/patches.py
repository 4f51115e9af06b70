"""Squares of a lattice clipped by an outline, as edges."""

from __future__ import annotations

from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64, distinct
from camsim.scene import overlap
from camsim.scene.regions import filled

ROWS = 50  # of squares that are clipped together


def pieces_of(start: F64, end: F64, cut: I64) -> tuple[np.ndarray, F64]:
    """Return the part of each square that lies within the outline, and the area of that part."""
    import shapely

    geometry = _geometry(start, end)
    row, col = cut.T
    low, high = int(col.min()) - 1.0, int(col.max()) + 2.0
    bands: dict[int, Any] = {}
    for rows in np.split(found := distinct(row), range(ROWS, len(found), ROWS)):
        # Few edges lie in a few rows: they are clipped first.
        some = shapely.intersection(geometry, shapely.box(low, rows[0], high, rows[-1] + 1.0))
        bands |= {int(r): shapely.intersection(some, shapely.box(low, r, high, r + 1.0)) for r in rows}
    boxes = shapely.box(col, row, col + 1.0, row + 1.0)
    pieces = shapely.intersection(boxes, np.array([bands[int(r)] for r in row], object))
    return pieces, shapely.area(pieces)


def _geometry(start: F64, end: F64) -> Any:
    """Return the region of chained edges: outer rings minus holes, with islands in holes."""
    import shapely

    following: dict[tuple[float, float], list[int]] = {}
    for k, place in enumerate(map(tuple, start.tolist())):
        following.setdefault(place, []).append(k)
    stops = list(map(tuple, end.tolist()))
    rings: list[list[tuple[float, float]]] = []
    while following:
        begin = here = next(iter(following))
        ring = [begin]
        while (here := stops[_taken(following, here)]) != begin:
            ring.append(here)
        if len(ring) > 2:
            rings.append(ring)
    # Inside by the even-odd rule: all edges have the inside on the same side.
    return filled(shapely.make_valid(shapely.Polygon(rings[0], rings[1:]))) if rings else shapely.Polygon()


def _taken(following: dict[tuple[float, float], list[int]], here: tuple[float, float]) -> int:
    edges = following[here]
    edge = edges.pop()
    if not edges:
        del following[here]
    return edge


def edges_of(pieces: np.ndarray, cut: I64) -> tuple[F64, F64, I64]:
    """Return the edges of pieces, relative to the centres of their squares, and the piece of each."""
    edges, owner = overlap.edges_of(pieces)
    start, end = np.hsplit(edges - np.tile(cut[owner][:, ::-1] + 0.5, 2), 2)
    return start, end, owner
