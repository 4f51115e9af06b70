"""How much two areas have in common, to rounding and however they touch: nothing is cut, no faces are looked for."""

from __future__ import annotations

from typing import Any

import numpy as np

from camsim.arrays import F64
from camsim.kernels import kernel


def common_area(area: Any, other: Any) -> float:
    """Return the area that two Shapely areas have in common.

    A place lies in an area where edges above it that run one way are one more than those that run the other way. So
    what two areas have in common is ΣΣ ±∫min(yᵢ(x), yⱼ(x)) dx over pairs of their edges: sides that all but coincide
    make no difference to any of these.

    >>> import shapely
    >>> common_area(shapely.box(0, 0, 2, 2), shapely.box(1, 1, 4, 3))
    1.0
    """
    one, two = _edges(area), _edges(other)
    if not len(one) or not len(two):
        return 0.0
    # About a place nearby, so that the numbers are small.
    low = np.minimum(one[:, :2].min(axis=0), two[:, :2].min(axis=0))
    return float(_common(one - np.tile(low, 2), two - np.tile(low, 2)))


def _edges(area: Any) -> F64:
    """Return the edges (n, 4) about an area, x, y of both ends, the inside of each on the same side."""
    import shapely

    rings = shapely.get_rings(shapely.get_parts(shapely.orient_polygons(area)))
    points, ring = shapely.get_coordinates(rings, return_index=True)
    on = ring[1:] == ring[:-1]
    edges: F64 = np.hstack([points[:-1][on], points[1:][on]])
    return edges


@kernel()
def _common(one: F64, two: F64) -> float:
    total, lost = 0.0, 0.0
    for i in range(len(one)):
        x0, y0, x1, y1 = one[i]
        if x0 == x1:
            continue
        left, right = min(x0, x1), max(x0, x1)
        for j in range(len(two)):
            u0, v0, u1, v1 = two[j]
            low, high = max(left, min(u0, u1)), min(right, max(u0, u1))
            if high <= low:
                continue
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
    return total
