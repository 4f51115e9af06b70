"""Parts of rims as straight sides: each with its arc's area, and no farther from it at its ends than in its middle.

Sides of one length lie on a circle a little larger than theirs: two radii and a side of it have the sector's area,
r²·φ/2 = R²·sin(φ)/2. Where a part begins and ends a step leads from the one circle to the other: it lies on a radius
and takes no area from a sector. So nothing is left over at the ends but what ends there: wobbles whose second moments,
s⁵/720r each, no longer cancel. They leave s⁴/720r times the slope of the pattern, and this twice, for either end.
"""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.scene.rims import Rims
from camsim.scene.side_limits import SideLimits, validate_sides


def sides_of(rims: Rims, limits: SideLimits) -> tuple[I64, F64, F64]:
    """Return the sides of open parts: whose (n,), and their starts and ends (n, 2)."""
    sides = rims.radius_um * rims.turn_rad / limits.end_um(rims.radius_um)
    validate_sides(float(sides.sum()))
    count = np.maximum(np.ceil(sides - 1e-9), 1.0).astype(np.int64)
    each = rims.turn_rad / count
    out = rims.radius_um * np.sqrt(each / np.sin(each))
    # Each part from its own start over corners on the larger circle to its own end.
    corners = count + 3
    part = np.repeat(np.arange(len(count)), corners)
    last = np.cumsum(corners) - 1
    first = last - corners + 1
    angle = rims.from_rad[part] + (np.arange(len(part)) - first[part] - 1) * each[part]
    places = rims.centre_um[part] + out[part][:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    places[first], places[last] = rims.start_um, rims.end_um
    begins = np.ones(len(part), bool)
    begins[last] = False
    begin = np.flatnonzero(begins)
    return part[begin], places[begin], places[begin + 1]
