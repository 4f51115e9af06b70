"""The interior of outlines by their fill rule, as valid Shapely geometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.errors import InvalidValueError
from camsim.scene.curves import Curves, cross
from camsim.scene.primitives import Fill, FillRule
from camsim.scene.side_limits import SideLimits
from camsim.scene.sides import polygons

GRID_BITS = (48, 46, 44)  # of the largest coordinate: at 50 GEOS sometimes fails to close rings, at 49 never observed
MOST_CROSSINGS = 200_000
LONG = 48  # corners from which a shape is clipped to the neighbourhood of another
BESIDE = 0.01  # margin of such clips, relative to the box
TOGETHER = 100_000  # sides queried at a time
FINE = 0.01  # side length relative to the total size: deviates by 1e-4 at a radius of a tenth
CLEAR = 2e-3  # relative to that size: least distance between and within outlines


def region_of(rings: Sequence[F64], rule: FillRule, *, simple: bool) -> Any:
    """Return the region enclosed by rings (n, 2).

    simple : whether the first ring is the outline and the others are holes, which cross at most by coarse sides
    """
    import shapely

    rings = [ring for ring in rings if len(ring) > 2]
    if not rings:
        return shapely.Polygon()
    if simple and (area := shapely.Polygon(rings[0], rings[1:])).is_valid:
        return area
    nested = nesting(rings, rule)
    if nested is not None:
        return shapely.MultiPolygon([(rings[outline], [rings[hole] for hole in holes]) for outline, holes in nested])
    _validate_crossings(rings)
    return _by_faces(rings, _lines(rings), rule)


def nesting(rings: Sequence[F64], rule: FillRule) -> list[tuple[int, list[int]]] | None:
    """Return the rings that are outlines, each with its holes; None if rings meet."""
    import shapely

    lines = _lines(rings)
    alone = shapely.polygons(lines)
    if not shapely.is_valid(alone).all() or _touching(lines):
        return None
    return _nested(rings, alone, rule)


def separated(curves: Curves, rule: FillRule) -> tuple[Fill, ...]:
    """Return closed outlines as simple fills; if some meet, as one fill that is not simple.

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


def _lines(rings: Sequence[F64]) -> Any:
    import shapely

    return shapely.linearrings(np.concatenate(rings), indices=np.repeat(np.arange(len(rings)), list(map(len, rings))))


def without(area: Any, others: Iterable[Any]) -> Any:
    """Return an area minus others, made valid by ``_sure``."""
    for other in others:
        area = area if area.is_empty else _less(area, other)
    return area


def _less(area: Any, other: Any) -> Any:
    import shapely

    from camsim.scene.overlap import common_area  # imported here: Numba is not needed to make a scene

    remaining = area.area - common_area(area, other)
    near = _about(area, other)  # may lose most of an outline, which the area check detects
    return _sure(
        lambda grid: shapely.difference(area, near if grid is None else other, grid_size=grid), remaining, [area, other]
    )


def _about(area: Any, other: Any) -> Any:
    """Return another area, clipped to the box of the first if it has many corners."""
    import shapely

    if shapely.get_num_coordinates(other) <= LONG:
        return other
    low_x, low_y, high_x, high_y = area.bounds
    more = BESIDE * max(high_x - low_x, high_y - low_y)
    try:
        near = shapely.clip_by_rect(other, low_x - more, low_y - more, high_x + more, high_y + more)
    except shapely.errors.GEOSException:  # a sliver degenerated to a line
        return other
    return near if near.is_valid else other


def common(area: Any, other: Any) -> Any:
    """Return the intersection of two areas, made valid by ``_sure``."""
    import shapely

    from camsim.scene.overlap import common_area

    both = common_area(area, other)
    return _sure(lambda grid: shapely.intersection(area, other, grid_size=grid), both, [area, other])


def joined_areas(areas: Sequence[Any]) -> Any:
    """Return the union of areas that do not overlap, made valid by ``_sure``."""
    import shapely

    if len(areas) == 1:
        return areas[0]
    together = float(np.sum(shapely.area(areas)))
    return _sure(lambda grid: shapely.union_all(areas, grid_size=grid), together, areas)


def _sure(overlay: Callable[[float | None], Any], area: float, polygons: Sequence[Any]) -> Any:
    """Return the overlay of polygons, in floating point if that can be trusted, else on a grid.

    In floating point GEOS loses whole faces, without a word, where edges all but coincide: a corner of one on a side of
    another (3 of 1000 random fans of triangles), or one of two squares side by side, of which nothing is left and all
    of it common. So what the area must be is found in another way (overlap.py). On a grid every crossing is rounded and
    nothing is lost; corners move by half its size, and it takes many times as long. So it is asked for where areas do
    not add up.

    area : that the result must have
    """
    import shapely

    size = math.frexp(float(np.abs(shapely.total_bounds(polygons)).max()))[1]
    moved = 4.0 * math.ldexp(1.0, size - GRID_BITS[0]) * float(np.sum(shapely.length(polygons)))
    best, off = None, math.inf
    for bits in (None, *GRID_BITS):
        try:
            found = filled(overlay(None if bits is None else math.ldexp(1.0, size - bits)))
        except shapely.errors.GEOSException as error:  # contradictory labels, or rings too fine to be closed
            failed = error
            continue
        if abs(found.area - area) < off:
            best, off = found, abs(found.area - area)
        if off <= moved * (1.0 if bits is None else 2.0 ** (GRID_BITS[0] - bits)):
            break
    if best is None:
        raise failed
    return best


def filled(geometry: Any) -> Any:
    """Return the areas of an overlay, without its lines, which cannot be overlaid again on a grid.

    Areas meet along lines, and a grid makes lines of slivers.
    """
    import shapely

    if geometry.geom_type != "GeometryCollection":
        return geometry
    parts = shapely.get_parts(shapely.get_parts(geometry))  # of a collection, and of multipolygons in it
    return shapely.MultiPolygon([part for part in parts if part.geom_type == "Polygon"])


def rings_of(geometry: Any) -> list[F64]:
    """Return the outlines (interior on the positive side) and holes of a Shapely geometry, unclosed."""
    import shapely

    rings: list[F64] = []
    for part in shapely.get_parts(geometry):
        if part.geom_type != "Polygon" or part.is_empty:
            continue
        rings.append(positive(shapely.get_coordinates(part.exterior)[:-1]))
        rings.extend(positive(shapely.get_coordinates(hole)[:-1])[::-1].copy() for hole in part.interiors)
    return rings


def positive(outline: F64) -> F64:
    """Return the outline in the direction that has the interior where the cross product is positive."""
    return outline if _area(outline) > 0 else outline[::-1].copy()


def _area(outline: F64) -> float:
    x, y = (outline - outline[0]).T  # the term from the last corner to the first is 0
    return 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


def _touching(lines: Any) -> bool:
    """Return whether any two rings meet."""
    import shapely

    if len(lines) == 1:
        return False
    first, second = shapely.STRtree(lines).query(lines)
    apart = first < second
    return bool(shapely.intersects(lines[first[apart]], lines[second[apart]]).any())


def _nested(rings: Sequence[F64], alone: Any, rule: FillRule) -> list[tuple[int, list[int]]]:
    """Return the outlines among disjoint or nested rings, and the holes of each."""
    import shapely

    count = len(rings)
    inner, outer = shapely.STRtree(alone).query(shapely.points([ring[0] for ring in rings]), predicate="within")
    inner, outer = inner[inner != outer], outer[inner != outer]
    winds = np.array([1 if _area(ring) > 0 else -1 for ring in rings])
    around = np.bincount(inner, winds[outer], count).astype(np.int64)  # outside of each ring
    filled_within, filled_without = inside(around + winds, rule), inside(around, rule)
    holes_of: dict[int, list[int]] = {shell: [] for shell in np.flatnonzero(filled_within & ~filled_without).tolist()}
    # Each hole belongs to the innermost shell around it.
    order = np.argsort(np.bincount(inner, minlength=count)[outer], kind="stable")
    owner = {
        r: about for r, about in zip(inner[order].tolist(), outer[order].tolist(), strict=True) if about in holes_of
    }
    for hole in np.flatnonzero(filled_without & ~filled_within).tolist():
        holes_of[owner[hole]].append(hole)
    return list(holes_of.items())


def inside(winds: I64, rule: FillRule) -> np.ndarray:
    """Return whether a rule fills points with these winding numbers."""
    within: np.ndarray = winds != 0 if rule == "nonzero" else winds % 2 == 1
    return within


def _validate_crossings(rings: Sequence[F64]) -> None:
    """Raise for outlines with too many crossings: each adds a corner to several faces."""
    import shapely

    starts, ends = _sides(rings)
    boxes = shapely.box(*np.minimum(starts, ends).T, *np.maximum(starts, ends).T)
    tree, found = shapely.STRtree(boxes), 0
    for begin in range(0, len(boxes), TOGETHER):
        for part in np.array_split(np.arange(begin, min(begin + TOGETHER, len(boxes))), 100):
            first, second = tree.query(boxes[part])
            a, b = part[first], second
            a, b = a[a < b], b[a < b]
            d, e = ends[a] - starts[a], ends[b] - starts[b]
            one = cross(d, starts[b] - starts[a]) * cross(d, ends[b] - starts[a]) < 0.0
            two = cross(e, starts[a] - starts[b]) * cross(e, ends[a] - starts[b]) < 0.0
            found += int(np.count_nonzero(one & two))
            if found > MOST_CROSSINGS:
                raise InvalidValueError(
                    f"an outline crosses itself more than {MOST_CROSSINGS} times; draw it in parts",
                    key="shapes",
                    stage="Scene",
                )


def _sides(rings: Sequence[F64]) -> tuple[F64, F64]:
    """Return where the sides of rings start and end."""
    return np.concatenate(rings), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])


def _by_faces(rings: Sequence[F64], lines: Any, rule: FillRule) -> Any:
    """Return the region of crossing rings: split at crossings, and each face tested by the rule."""
    import shapely

    cut = shapely.union_all(lines)
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(cut)))
    places = shapely.get_coordinates(shapely.point_on_surface(faces))
    faces = faces[inside(_windings(places, rings), rule)]
    return joined_areas(faces) if len(faces) else shapely.Polygon()


def _windings(places: F64, rings: Sequence[F64]) -> I64:
    """Return winding numbers of rings about places."""
    starts, ends = _sides(rings)
    sums = np.zeros(len(places), np.int64)
    up = starts[:, 1] <= ends[:, 1]
    low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
    order = np.argsort(low, kind="stable")
    lows = low[order]
    for index, (x, y) in enumerate(places.tolist()):
        near = order[: np.searchsorted(lows, y, side="right")]
        near = near[high[near] > y]
        side = cross(ends[near] - starts[near], np.array([x, y]) - starts[near])
        right = np.where(up[near], side > 0.0, side < 0.0)
        sums[index] = int(np.sum(np.where(up[near], 1, -1)[right]))
    return sums
