"""Painter's order resolved: what is visible, as edges with a spectrum on either side."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene.scene import Scene
from camsim.scene.shapes import Longer
from camsim.spectra.curve import Spectrum

GRID_BITS = (48, 46, 44)  # of the largest coordinate: at 50 GEOS fails to close rings now and then, at 49 it never did


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


def arrange(
    scene: Scene,
    *,
    max_segment_um: float,
    max_wobble_um: float = math.inf,
    max_cut_um2: float = math.inf,
    longer: Longer | None = None,
) -> Arrangement:
    """Cut away what later shapes cover, join regions of equal spectrum, and list the edges that remain.

    max_segment_um, max_wobble_um, longer : how finely curved outlines are cut into sides (``Disc.outline_um``);
                     max_cut_um2: those that another shape may cut

    Every visible region contributes its outline against the background; where two regions share an edge
    exactly, the two become one edge with both spectra. Equal spectra on both sides leave no edge.

    >>> from camsim.scene.shapes import Rectangle
    >>> grey = Rectangle(width_um=2.0, height_um=2.0, reflectance=0.5)
    >>> len(arrange(Scene(background=1.0, shapes=[grey]), max_segment_um=1.0).left)
    4
    >>> len(arrange(Scene(background=0.5, shapes=[grey]), max_segment_um=1.0).left)
    0
    """
    spectra: list[Spectrum] = [scene.background]
    index_of: dict[Spectrum, int] = {scene.background: 0}
    outlines: list[F64] = []
    regions: list[int] = []
    for shape in scene.shapes:
        outlines.append(_positive(shape.outline_um(max_segment_um, max_wobble_um, math.inf, longer)))
        region = index_of.setdefault(shape.reflectance, len(spectra))
        if region == len(spectra):
            spectra.append(shape.reflectance)
        regions.append(region)

    touching = _touching(outlines)
    for i in np.flatnonzero(touching[0]).tolist():
        outlines[i] = _positive(scene.shapes[i].outline_um(max_segment_um, max_wobble_um, max_cut_um2, longer))
    outline_edges = sum(map(len, outlines))
    starts: list[F64] = []
    ends: list[F64] = []
    lefts: list[I64] = []
    for region, rings in _visible_rings(outlines, regions, touching):
        if region == 0:
            continue
        for ring in rings:
            starts.append(ring)
            ends.append(np.roll(ring, -1, axis=0))
            lefts.append(np.full(len(ring), region))
    if not starts:
        nothing = np.empty((0, 2))
        none = np.empty(0, np.int64)
        return Arrangement(
            start_um=nothing,
            end_um=nothing,
            left=none,
            right=none,
            spectra=tuple(spectra),
            outline_edges=outline_edges,
        )
    start, end, left = np.concatenate(starts), np.concatenate(ends), np.concatenate(lefts)
    # An edge whose squared length is no longer a number above 0 contributes nothing.
    keep = np.sum((end - start) ** 2, axis=1) > 0.0
    start, end, left = start[keep], end[keep], left[keep]
    start, end, left, right = _merge_shared(start, end, left)
    return Arrangement(
        start_um=start, end_um=end, left=left, right=right, spectra=tuple(spectra), outline_edges=outline_edges
    )


def _positive(outline: F64) -> F64:
    """Return the outline in the direction that has its inside where the cross product is positive."""
    x, y = (outline - outline[0]).T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    return outline if area > 0 else outline[::-1].copy()


Touching = tuple[np.ndarray, I64, I64]


def _touching(outlines: Sequence[F64]) -> Touching:
    """Return which outlines may touch another, and the pairs whose boxes do."""
    if not outlines:
        nobody = np.empty(0, np.int64)
        return np.empty(0, bool), nobody, nobody
    import shapely

    boxes = shapely.box(*np.array([[*o.min(axis=0), *o.max(axis=0)] for o in outlines]).T)
    first, second = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    touching = np.zeros(len(outlines), bool)
    touching[first[first != second]] = True
    return touching, first, second


def _visible_rings(outlines: Sequence[F64], regions: Sequence[int], found: Touching) -> list[tuple[int, list[F64]]]:
    """Return (region, rings) of what can be seen; a shape that touches no other keeps its very numbers."""
    if not outlines:
        return []
    import shapely

    touching, first, second = found

    visible = [(regions[i], [outlines[i]]) for i in np.flatnonzero(~touching).tolist()]
    pieces: dict[int, list[Any]] = {}
    overlapped_by: dict[int, list[int]] = {}
    for a, b in zip(first, second, strict=True):
        if b > a:
            overlapped_by.setdefault(int(a), []).append(int(b))
    polygons = {i: shapely.Polygon(outlines[i]) for i in np.flatnonzero(touching).tolist()}
    for i, polygon in polygons.items():
        later = [polygons[j] for j in overlapped_by.get(i, [])]
        piece = polygon if not later else _overlaid(_without, [polygon, *later])
        pieces.setdefault(regions[i], []).append(piece)
    for region, parts in pieces.items():
        joined = _overlaid(shapely.union_all, parts) if len(parts) > 1 else parts[0]
        visible.append((region, _rings(joined)))
    return visible


def _without(polygons: Sequence[Any], grid_size: float | None = None) -> Any:
    """Return the first polygon without all others."""
    import shapely

    first, *others = polygons
    return shapely.difference(first, shapely.union_all(others, grid_size=grid_size), grid_size=grid_size)


def _overlaid(overlay: Callable[..., Any], polygons: Sequence[Any]) -> Any:
    """Return what an overlay makes of polygons, their very numbers kept where that can be trusted.

    In floating point GEOS loses whole faces, without a word, where edges all but coincide: a corner of one on a side of
    another (3 of 1000 random fans of triangles). On a grid every crossing is rounded and nothing is lost; corners move
    by half its size. So both are made: where their areas differ by more than that explains, the grid's is right.
    """
    import shapely

    exact = overlay(polygons)
    size = math.frexp(float(np.abs(shapely.total_bounds(polygons)).max()))[1]
    for bits in GRID_BITS:
        grid = math.ldexp(1.0, size - bits)
        try:
            rounded = overlay(polygons, grid_size=grid)
        except shapely.errors.GEOSException:  # rings that cannot be closed: too fine for its own rounding
            continue
        moved = 4.0 * grid * float(np.sum(shapely.length(polygons)))
        return exact if abs(exact.area - rounded.area) <= moved else rounded
    return exact


def _rings(geometry: Any) -> list[F64]:
    """Return the outlines (inside on the positive side) and holes of a Shapely geometry, unclosed."""
    import shapely

    rings: list[F64] = []
    for part in shapely.get_parts(geometry):
        if part.geom_type != "Polygon" or part.is_empty:
            continue
        rings.append(_positive(shapely.get_coordinates(part.exterior)[:-1]))
        rings.extend(_positive(shapely.get_coordinates(hole)[:-1])[::-1].copy() for hole in part.interiors)
    return rings


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
