"""Parts of rims as straight sides, each with the area of its arc and equal deviations at its ends and its middle.

Sides of one length lie on a circle a little larger than theirs: two radii and a side of it have the sector's area,
r²·φ/2 = R²·sin(φ)/2. At the ends of a part, a radial step connects the two circles
without changing the area of a sector. So the only error at the ends is that second moments of the deviations,
s⁵/720r each, no longer cancel. They leave s⁴/720r times the slope of the PSF, for each of the two ends.
"""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.scene.rims import Rims
from camsim.scene.side_limits import SideLimits, validate_sides


def sides_of(rims: Rims, limits: SideLimits) -> tuple[I64, F64, F64]:
    """Return the sides of open parts: owners (n,), and starts and ends (n, 2)."""
    sides = rims.radius_um * rims.turn_rad / limits.end_um(rims.radius_um)
    validate_sides(float(sides.sum()))
    count = np.maximum(np.ceil(sides - 1e-9), 1.0).astype(np.int64)
    each = rims.turn_rad / count
    out = rims.radius_um * np.sqrt(each / np.sin(each))
    # Each part from its start over corners on the larger circle to its end.
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
