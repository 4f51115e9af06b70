"""Which places shapes cover."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import Primitive
from camsim.scene.side_limits import SideLimits

FINE = SideLimits(turn_rad=1e-3)  # polygons that lie off their curves by 1e-7 of the radius


def covered(places_um: F64, before: I64, primitives: Sequence[Primitive]) -> np.ndarray:
    """Return which places (n, 2) primitives cover; before: (n,) the first of them, in painter's order, that may.

    >>> import numpy as np
    >>> from camsim.scene import Disc, flattened
    >>> rim = flattened([Disc(radius_um=10.0, reflectance=0.5)])
    >>> covered(np.array([[0.0, 9.999999], [0.0, 10.000001]]), np.zeros(2, int), rim)
    array([ True, False])
    """
    found = np.zeros(len(places_um), bool)
    if not len(places_um) or not primitives:
        return found
    import shapely

    boxes = Outlines.of(primitives).boxes
    filled = np.flatnonzero(np.isfinite(boxes).all(axis=1))
    place, box = shapely.STRtree(shapely.box(*boxes[filled].T)).query(shapely.points(places_um))
    number = filled[box]
    later = number >= before[place]
    place, number = place[later], number[later]
    order = np.argsort(number, kind="stable")
    place, number = place[order], number[order]
    for one in np.unique(number).tolist():
        about = place[np.searchsorted(number, one, "left") : np.searchsorted(number, one, "right")]
        asked = about[~found[about]]
        area = area_of(primitives[one], Outlines.of([primitives[one]]).rings(FINE)[0])
        found[asked] = shapely.contains_xy(area, places_um[asked])
    return found
