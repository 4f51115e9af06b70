"""How much two areas have in common, to rounding and however they touch: nothing is cut, no faces are looked for."""

from __future__ import annotations

from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel


def common_area(area: Any, other: Any) -> float:
    """Return the area that two Shapely areas have in common.

    A place lies in an area where edges above it that run one way are one more than those that run the other way. So
    what two areas have in common is ΣΣ ±∫min(yᵢ(x), yⱼ(x)) dx over pairs of their edges: sides that all but coincide
    make no difference to any of these.

    >>> import shapely
    >>> common_area(shapely.box(0, 0, 2, 2), shapely.box(1, 1, 4, 3))
    1.0
    """
    one, two = edges_of(area), edges_of(other)
    if not len(one) or not len(two):
        return 0.0
    # About a place nearby, so that the numbers are small.
    low = np.minimum(one[:, :2].min(axis=0), two[:, :2].min(axis=0))
    edges = np.concatenate([one, two]) - np.tile(low, 2)
    order = np.argsort(np.minimum(edges[:, 0], edges[:, 2]), kind="stable")
    order = order[edges[order, 0] != edges[order, 2]]  # nothing lies below what stands upright
    return float(_common(edges[order], (order >= len(one)).astype(np.int64)))


def edges_of(area: Any) -> F64:
    """Return the edges (n, 4) about an area, x, y of both ends, the inside of each on the same side."""
    import shapely

    rings = shapely.get_rings(shapely.get_parts(shapely.orient_polygons(area)))
    points, ring = shapely.get_coordinates(rings, return_index=True)
    on = ring[1:] == ring[:-1]
    edges: F64 = np.hstack([points[:-1][on], points[1:][on]])
    return edges


@kernel(allocates=True)
def _common(edges: F64, owner: I64) -> float:
    """Edges (n, 4) in the order of their left ends, and which of the two areas each is of, 0 or 1.

    A line goes from left to right: an edge that begins meets those of the other area that have begun and not ended.
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
            if max(u0, u1) <= left:  # it has ended: the last one takes its place
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
            # Kahan's sum: large parts take one another away.
            part -= lost
            raised = total + part
            lost = (raised - total) - part
            total = raised
        begun[each, count[each]] = k
        count[each] += 1
    return total
