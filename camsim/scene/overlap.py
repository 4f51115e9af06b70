"""Area of the intersection of two areas, robust to any contact: without clipping or faces."""

from __future__ import annotations

from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel


def common_area(area: Any, other: Any) -> float:
    """Return the area that two Shapely areas have in common.

    A point is inside an area if, among the edges above it, those in one direction exceed those in the other by one. So
    the common area is ΣΣ ±∫min(yᵢ(x), yⱼ(x)) dx over pairs of edges, which is insensitive to nearly coincident sides.

    >>> import shapely
    >>> common_area(shapely.box(0, 0, 2, 2), shapely.box(1, 1, 4, 3))
    1.0
    """
    one, two = edges_of(area)[0], edges_of(other)[0]
    if not len(one) or not len(two):
        return 0.0
    # Relative to a point nearby, for accuracy.
    low = np.minimum(one[:, :2].min(axis=0), two[:, :2].min(axis=0))
    edges = np.concatenate([one, two]) - np.tile(low, 2)
    order = np.argsort(np.minimum(edges[:, 0], edges[:, 2]), kind="stable")
    order = order[edges[order, 0] != edges[order, 2]]  # vertical edges contribute no area
    return float(_common(edges[order], (order >= len(one)).astype(np.int64)))


def edges_of(areas: Any) -> tuple[F64, I64]:
    """Return the edges (n, 4) of areas, x, y of both ends, with the inside on the same side, and the area of each."""
    import shapely

    parts, of_part = shapely.get_parts(shapely.orient_polygons(areas), return_index=True)
    rings, of_ring = shapely.get_rings(parts, return_index=True)
    points, of_point = shapely.get_coordinates(rings, return_index=True)
    on = of_point[1:] == of_point[:-1]
    return np.hstack([points[:-1][on], points[1:][on]]), of_part[of_ring[of_point[:-1][on]]].astype(np.int64)


@kernel(allocates=True)
def _common(edges: F64, owner: I64) -> float:
    """Return the common area; edges (n, 4) sorted by left end, owner: 0 or 1 of each.

    Sweep from left to right: a starting edge is paired with the active edges of the other area.
    """
    begun, count = np.empty((2, len(edges)), np.int64), np.zeros(2, np.int64)
    total, lost = 0.0, 0.0
    for k in range(len(edges)):
        each, other = owner[k], 1 - owner[k]
        x0, y0, x1, y1 = edges[k]
        left, right = min(x0, x1), max(x0, x1)
        met = 0
        while met < count[other]:
            u0, v0, u1, v1 = edges[begun[other, met]]
            if max(u0, u1) <= left:  # it has ended: replaced by the last one
                count[other] -= 1
                begun[other, met] = begun[other, count[other]]
                continue
            met += 1
            low, high = left, min(right, max(u0, u1))
            a, b = y0 + (y1 - y0) * ((low - x0) / (x1 - x0)), y0 + (y1 - y0) * ((high - x0) / (x1 - x0))
            c, d = v0 + (v1 - v0) * ((low - u0) / (u1 - u0)), v0 + (v1 - v0) * ((high - u0) / (u1 - u0))
            if (a < c) != (b < d) and a != c and b != d:
                t = (a - c) / ((a - c) + (d - b))
                middle = a + t * (b - a)
                under = t * (min(a, c) + middle) + (1.0 - t) * (middle + min(b, d))
            else:
                under = min(a, c) + min(b, d)
            part = 0.5 * (high - low) * under
            if (x1 > x0) != (u1 > u0):
                part = -part
            # Kahan summation: large terms cancel.
            part -= lost
            raised = total + part
            lost = (raised - total) - part
            total = raised
        begun[each, count[each]] = k
        count[each] += 1
    return total
