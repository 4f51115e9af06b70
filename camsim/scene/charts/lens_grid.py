"""Trapezoids over the whole frame, with edges along the radius from the optical axis and across it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from camsim.core.typed import Point, Positive
from camsim.scene.charts.chart import Card, Many, chart, counted, grid, refused
from camsim.scene.primitives import Shape
from camsim.scene.shapes import Polygon, Rectangle
from camsim.spectra.curve import Reflectance


@chart
def lens_grid(
    *,
    width_um: Positive,
    height_um: Positive,
    cols: Many = 17,
    rows: Many = 11,
    side_um: Positive | None = None,
    rotate_deg: float = 4.0,
    dark: Reflectance = 0.05,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw blocks with two radial and two tangential edges: sagittal and meridional MTF over the frame.

    The block in the middle is a square. As MTF Mapper's lensgrid; angles and sizes are camsim's own.

    width_um, height_um : size of the grid before it is turned
    cols, rows : number of blocks across and down
    side_um    : side of a block; 4 % of the width when left out
    rotate_deg : rotation of the whole grid, clockwise as displayed, which slants the edges of blocks on the axes

    >>> len(lens_grid(width_um=6000.0, height_um=4000.0).shapes)
    187
    """
    import shapely

    counted(lens_grid, "rows", rows * cols)
    side = 0.04 * width_um if side_um is None else side_um
    for key, whole, count in (("width_um", width_um, cols), ("height_um", height_um, rows)):
        if count * side > whole:
            raise refused(lens_grid, key, f"{count} blocks of {side:g} do not fit into {whole:g}")
    card = Card(centre_um, rotate_deg)
    c, s = abs(math.cos(math.radians(rotate_deg))), abs(math.sin(math.radians(rotate_deg)))
    yield from Card(centre_um).behind(c * width_um + s * height_um, c * height_um + s * width_um, light)
    blocks: list[Polygon | Rectangle] = []
    for _, _, (x, y) in grid(rows, cols, (width_um - side) / max(cols - 1, 1), (height_um - side) / max(rows - 1, 1)):
        radius = math.hypot(x, y)
        if radius < side:
            blocks.append(card.rectangle(side, side, (x, y), dark))
            continue
        # Inner and outer side are perpendicular to the ray through the block's centre, the others lie along rays.
        along, across = np.array([x, y]) / radius, np.array([-y, x]) / radius
        inner, outer = radius - 0.5 * side, radius + 0.5 * side
        spread = 0.5 * side / radius
        corners = [r * (along + s * spread * across) for r, s in ((inner, -1), (outer, -1), (outer, 1), (inner, 1))]
        blocks.append(card.polygon(corners, dark))
    outlines = shapely.polygons(
        np.array([block.points_um if isinstance(block, Polygon) else block.corners_um for block in blocks])
    )
    if len(shapely.STRtree(outlines).query(outlines, predicate="overlaps")[0]):
        message = f"blocks of {side:g} lie over one another, turned as they are; give smaller ones, or fewer"
        raise refused(lens_grid, "side_um" if side_um is not None else "cols", message)
    yield from blocks
