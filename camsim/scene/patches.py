"""Squares of a lattice clipped by an outline, as edges."""

from __future__ import annotations

from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64


def pieces_of(start: F64, end: F64, cut: I64) -> tuple[np.ndarray, F64]:
    """Return the part of each square that lies within the outline, and the area of that part."""
    import shapely

    geometry = _geometry(start, end)
    row, col = cut.T
    low, high = int(col.min()) - 1.0, int(col.max()) + 2.0
    bands: dict[int, Any] = {
        int(r): shapely.intersection(geometry, shapely.box(low, r, high, r + 1.0)) for r in np.unique(row)
    }
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
    rings: tuple[list[Any], list[Any]] = ([], [])  # outer ones and holes
    while following:
        begin = next(iter(following))
        ring, here = [begin], begin
        while True:
            here = stops[_taken(following, here)]
            if here == begin:
                break
            ring.append(here)
        if len(ring) > 2:
            x, y = np.array(ring).T
            area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
            rings[area < 0.0].append(shapely.make_valid(shapely.Polygon(ring)))
    within = [_holes_about(some, rings[1]) for some in rings]
    levels = range(1 + max((int(each.max(initial=0)) for each in within), default=0))
    outer, holes = (
        [shapely.union_all(np.array(some, object)[each == level]) for level in levels]
        for some, each in zip(rings, within, strict=True)
    )
    return (
        shapely.union_all(shapely.difference(outer, holes)) if len(levels) > 1 else shapely.difference(*outer, *holes)
    )


def _holes_about(rings: list[Any], holes: list[Any]) -> I64:
    """Return the number of other holes that contain each ring: an island is in one, and so is its hole."""
    import shapely

    ring, hole = shapely.STRtree(holes).query(np.array(rings, object), predicate="within")
    others = np.array([rings[r] is not holes[h] for r, h in zip(ring.tolist(), hole.tolist(), strict=True)], bool)
    return np.bincount(ring[others], minlength=len(rings))


def _taken(following: dict[tuple[float, float], list[int]], here: tuple[float, float]) -> int:
    edges = following[here]
    edge = edges.pop()
    if not edges:
        del following[here]
    return edge


def edges_of(pieces: np.ndarray, cut: I64) -> tuple[F64, F64, I64]:
    """Return the edges of pieces, relative to the centres of their squares, and the piece that each belongs to."""
    import shapely

    # In the normal form outer rings run one way and holes the other.
    parts, of_part = shapely.get_parts(shapely.normalize(pieces), return_index=True)
    rings, of_ring = shapely.get_rings(parts, return_index=True)
    points, of_point = shapely.get_coordinates(rings, return_index=True)
    same = of_point[1:] == of_point[:-1]
    owner = of_part[of_ring[of_point[:-1][same]]]
    middle = cut[owner][:, ::-1] + 0.5
    # Clockwise with y up, so the inside is on the other side: reversed.
    return points[1:][same] - middle, points[:-1][same] - middle, owner.astype(np.int64)
