"""Outlines that are drawn again and again, sorted once: each with its holes, where none comes near another."""

from __future__ import annotations

from typing import Any

from camsim.scene.curves import Curves
from camsim.scene.primitives import Fill, FillRule
from camsim.scene.regions import nesting, region_of
from camsim.scene.side_limits import SideLimits
from camsim.scene.sides import polygons

FINE = 0.01  # of the size of all: a side's length, which then lies 1e-4 of it off where a curve's radius is a tenth
CLEAR = 2e-3  # of that size: what outlines keep free of one another, and of themselves


def separated(curves: Curves, rule: FillRule) -> tuple[Fill, ...]:
    """Return the fills of closed outlines of which each is simple; all of them as one that is not, where some meet.

    Linear maps leave them simple, and so does another cut into sides: no two outlines, and no two parts of one, are so
    close that a region grown or shrunk by ``CLEAR`` would hang together in another way.

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
    """Return how many holes each part has, the fewest first."""
    import shapely

    return sorted(shapely.get_num_interior_rings(shapely.get_parts(area)).tolist())
