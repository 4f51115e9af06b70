"""Painter's order resolved: what is visible, as edges with a spectrum on either side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import Primitive, flattened
from camsim.scene.regions import overlaid, positive, rings_of
from camsim.scene.scene import Scene
from camsim.scene.sides import Apart, SideLimits
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arrangement:
    """The visible regions' edges.

    start_um, end_um : (n, 2) x, y in µm
    left, right      : (n,) index into ``spectra`` of the side where cross(end − start, x − start) is above 0
                       (in a frame with y down that is the viewer's right), and of the other side
    spectra          : distinct reflectances; index 0 is the background
    outline_edges    : of all shapes, before one covers another
    """

    start_um: F64
    end_um: F64
    left: I64
    right: I64
    spectra: tuple[Spectrum, ...]
    outline_edges: int = 0


def arrange(scene: Scene, limits: SideLimits | None = None, *, apart: Apart | None = None) -> Arrangement:
    """Cut away what later shapes cover, join regions of equal spectrum, and list the edges that remain.

    limits, apart : how finely curved outlines are cut into sides (``sides.polygons``)

    Every visible region contributes its outline against the background; where two regions share an edge
    exactly, the two become one edge with both spectra. Equal spectra on both sides leave no edge.

    >>> from camsim.scene import Rectangle
    >>> grey = Rectangle(width_um=2.0, height_um=2.0, reflectance=0.5)
    >>> len(arrange(Scene(background=1.0, shapes=[grey])).left)
    4
    >>> len(arrange(Scene(background=0.5, shapes=[grey])).left)
    0
    """
    spectra: dict[Spectrum, int] = {scene.background: 0}
    primitives = flattened(scene.shapes)
    regions = [spectra.setdefault(primitive.reflectance, len(spectra)) for primitive in primitives]
    outlines = Outlines.of(primitives)
    found = _touching(outlines.boxes)
    rings = outlines.rings(limits or SideLimits(), found[0] | ~outlines.simple, apart)
    starts: list[F64] = []
    ends: list[F64] = []
    lefts: list[I64] = []
    for region, visible in _visible_rings(primitives, rings, regions, found, outlines.simple):
        if region == 0:
            continue
        for ring in visible:
            starts.append(ring)
            ends.append(np.roll(ring, -1, axis=0))
            lefts.append(np.full(len(ring), region))
    start, end = np.concatenate([np.empty((0, 2)), *starts]), np.concatenate([np.empty((0, 2)), *ends])
    left = np.concatenate([np.empty(0, np.int64), *lefts])
    # An edge whose squared length is no longer a number above 0 contributes nothing.
    keep = np.sum((end - start) ** 2, axis=1) > 0.0
    start, end, left, right = _merge_shared(start[keep], end[keep], left[keep])
    return Arrangement(
        start_um=start,
        end_um=end,
        left=left,
        right=right,
        spectra=tuple(spectra),
        outline_edges=sum(len(ring) for own in rings for ring in own),
    )


Touching = tuple[np.ndarray, I64, I64]


def _touching(boxes: F64) -> Touching:
    """Return which outlines may touch another, and the pairs whose boxes do, the earlier first."""
    import shapely

    if not len(boxes):
        nobody = np.empty(0, np.int64)
        return np.empty(0, bool), nobody, nobody
    areas = shapely.box(*boxes.T)
    first, second = shapely.STRtree(areas).query(areas, predicate="intersects")
    earlier = first < second
    first, second = first[earlier], second[earlier]
    touching = np.zeros(len(boxes), bool)
    touching[first] = touching[second] = True
    return touching, first, second


def _visible_rings(
    primitives: Sequence[Primitive],
    rings: Sequence[list[F64]],
    regions: Sequence[int],
    found: Touching,
    simple: np.ndarray,
) -> list[tuple[int, list[F64]]]:
    """Return (region, rings) of what can be seen; a shape that touches no other keeps its very numbers."""
    import shapely

    touching, first, second = found
    visible = [
        (regions[i], [positive(rings[i][0]), *(positive(hole)[::-1].copy() for hole in rings[i][1:])])
        for i in np.flatnonzero(~touching & simple).tolist()
        if rings[i]
    ]
    pieces: dict[int, list[Any]] = {}
    covered_by: dict[int, list[int]] = {}
    for a, b in zip(first.tolist(), second.tolist(), strict=True):
        covered_by.setdefault(a, []).append(b)
    areas = {i: area_of(primitives[i], rings[i]) for i in np.flatnonzero(touching | ~simple).tolist()}
    for i, area in areas.items():
        later = [areas[j] for j in covered_by.get(i, [])]
        piece = area if not later else overlaid(_without, [area, *later])
        pieces.setdefault(regions[i], []).append(piece)
    for region, parts in pieces.items():
        together = overlaid(shapely.union_all, parts) if len(parts) > 1 else parts[0]
        visible.append((region, rings_of(together)))
    return visible


def _without(polygons: Sequence[Any], grid_size: float | None = None) -> Any:
    """Return the first polygon without all others."""
    import shapely

    first, *others = polygons
    return shapely.difference(first, shapely.union_all(others, grid_size=grid_size), grid_size=grid_size)


def _merge_shared(start: F64, end: F64, left: I64) -> tuple[F64, F64, I64, I64]:
    """Make one edge of two that run along each other in opposite directions; drop it when both sides are equal."""
    right = np.zeros_like(left)
    flip = (end[:, 0] < start[:, 0]) | ((end[:, 0] == start[:, 0]) & (end[:, 1] < start[:, 1]))
    line = np.where(flip[:, None], np.hstack([end, start]), np.hstack([start, end]))
    _, group, counts = np.unique(line, axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    forth = np.full(len(counts), -1)
    back = np.full(len(counts), -1)
    forth[group[~flip]] = np.flatnonzero(~flip)
    back[group[flip]] = np.flatnonzero(flip)
    paired = (counts == 2) & (forth >= 0) & (back >= 0)
    right[forth[paired]] = left[back[paired]]
    keep = (~paired[group] | ~flip) & (left != right)
    return start[keep], end[keep], left[keep], right[keep]
