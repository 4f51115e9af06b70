"""Outlines used repeatedly, sorted once into outlines with holes, if they are clear of one another."""

from __future__ import annotations

from typing import Any

from camsim.scene.curves import Curves
from camsim.scene.primitives import Fill, FillRule
from camsim.scene.regions import nesting, region_of
from camsim.scene.side_limits import SideLimits
from camsim.scene.sides import polygons

FINE = 0.01  # side length relative to the total size: deviates by 1e-4 at a radius of a tenth
CLEAR = 2e-3  # relative to that size: least distance between and within outlines


def separated(curves: Curves, rule: FillRule) -> tuple[Fill, ...]:
    """Return closed outlines as simple fills; if some of them meet, as a single fill that is not simple.

    They stay simple under linear maps and other subdivisions into sides: no two outlines, or parts of one, are so close
    that growing or shrinking a region by ``CLEAR`` changes its topology.

    >>> import numpy as np
    >>> from camsim.scene.curves import joined, through
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> [fill.simple for fill in separated(joined([through(square), through(4 * square - 1)]), "evenodd")]
    [True]
    >>> [fill.simple for fill in separated(joined([through(square), through(square + 0.5)]), "nonzero")]
    [False]
    """
    if not len(curves.kind):
        return ()
    boxes = curves.boxes
    size = float((boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)).max())
    rings = polygons(curves, SideLimits(FINE * size)).each
    nested = nesting(rings, rule) if min(map(len, rings)) > 2 else None
    if nested is not None:
        area = region_of(rings, rule, simple=False)
        if all(_hangs_together(area.buffer(way * CLEAR * size)) == _hangs_together(area) for way in (-1.0, 1.0)):
            return tuple(Fill(curves.loops([outline, *holes]), rule, simple=True) for outline, holes in nested)
    return (Fill(curves, rule),)


def _hangs_together(area: Any) -> list[int]:
    """Return the number of holes of each part, sorted."""
    import shapely

    return sorted(shapely.get_num_interior_rings(shapely.get_parts(area)).tolist())
