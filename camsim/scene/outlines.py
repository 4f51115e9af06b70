"""The outlines of all primitives of a scene, the areas they cover, and the surface visible at a point."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64, same_rows
from camsim.scene.curves import STRAIGHT, Curves, joined
from camsim.scene.primitives import Primitive, flattened
from camsim.scene.regions import common, joined_areas, region_of, without
from camsim.scene.scene import Scene
from camsim.scene.side_limits import SideLimits
from camsim.scene.sides import Polygons, polygons
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, eq=False)
class Outlines:
    """The loops of all primitives, with their owners.

    curves : all loops;  loop_of: (loops,) primitive of each;  layer_of: (loops,) layer, numbered over all primitives
    simple : (primitives,) see ``Fill``
    """

    curves: Curves
    loop_of: I64
    layer_of: I64
    simple: np.ndarray

    @classmethod
    def of(cls, primitives: Sequence[Primitive]) -> Outlines:
        """Return the outlines of primitives."""
        layers = [(number, layer) for number, one in enumerate(primitives) for layer in one.layers]
        parts = [(owner, k, fill.curves) for k, (owner, layer) in enumerate(layers) for fill in layer]
        loops = np.array([len(curves.first) - 1 for _, _, curves in parts], np.int64)
        owners = np.array([[owner, layer] for owner, layer, _ in parts], np.int64).reshape(-1, 2).T
        return cls(
            joined([curves for _, _, curves in parts]),
            np.repeat(owners[0], loops),
            np.repeat(owners[1], loops),
            np.array([primitive.simple for primitive in primitives], bool),
        )

    def some(self, which: I64) -> Outlines:
        """Return the outlines of selected primitives, in the order of their numbers."""
        number = np.full(len(self.simple), -1)
        number[which] = np.arange(len(which))
        loops = number[self.loop_of] >= 0
        pieces = number[self.owner] >= 0
        first = np.concatenate([[0], np.cumsum(np.diff(self.curves.first)[loops])])
        curves = self.curves.some(pieces)._replace(first=first)
        return Outlines(curves, number[self.loop_of[loops]], self.layer_of[loops], self.simple[which])

    @property
    def owner(self) -> I64:
        """The primitive of each piece."""
        return self.loop_of[self.curves.loop]

    @property
    def boxes(self) -> F64:
        """Boxes (primitives, 4) that contain each primitive: the intersection of the boxes of its layers."""
        boxes, around = self.curves.boxes, np.full((len(self.simple), 4), np.inf)
        around[:, 2:] = -np.inf
        if not len(boxes):
            return around
        _, first = np.unique(self.layer_of[self.curves.loop], return_index=True)
        low, high = np.minimum.reduceat(boxes[:, :2], first), np.maximum.reduceat(boxes[:, 2:], first)
        filled, first = np.unique(self.owner[first], return_index=True)
        low, high = np.maximum.reduceat(low, first), np.minimum.reduceat(high, first)
        some = (low <= high).all(axis=1)
        around[filled[some]] = np.concatenate([low, high], axis=1)[some]
        return around

    def polygons(self, limits: SideLimits, *, meets: np.ndarray | None = None) -> Polygons:
        """Return all loops as polygons; ``meets``: (primitives,) mask of those that another outline may cut."""
        if not len(self.owner):
            return Polygons(np.empty((0, 2)), np.zeros(1, np.int64))
        # A clip of many shapes is an outline of each: it is cut into sides once, and does not cut itself.
        distinct, kind = _different(self.curves)
        curves = self.curves if len(distinct) == len(kind) else self.curves.loops(distinct.tolist())
        cut = None
        if meets is not None and meets.any():
            cut = np.bincount(kind, (meets | ~self.simple)[self.loop_of]) > 0
        return polygons(curves, limits, cut).some_of(kind)

    def each(self, sides: Polygons, which: I64) -> list[list[F64]]:
        """Return the polygons of selected primitives, fill by fill."""
        begin, end = (np.searchsorted(self.loop_of, which, side) for side in ("left", "right"))
        return [
            [sides.corners_um[sides.first[loop] : sides.first[loop + 1]] for loop in range(*item)]
            for item in zip(begin.tolist(), end.tolist(), strict=True)
        ]

    def rings(self, limits: SideLimits) -> list[list[F64]]:
        """Return the polygons of each primitive, for outlines that do not cut one another."""
        return self.each(self.polygons(limits), np.arange(len(self.simple)))


def _different(curves: Curves) -> tuple[I64, I64]:
    """Return the distinct loops, compared bitwise, and the index of each loop among them."""
    count = len(curves.first) - 1
    beginning, _ = same_rows(curves.points[curves.first[:-1]].reshape(count, 8))
    if len(beginning) == count:
        return np.arange(count), np.arange(count)
    known: dict[tuple[bytes, ...], int] = {}
    distinct: list[int] = []
    kind = np.empty(count, np.int64)
    for loop, (first, end) in enumerate(itertools.pairwise(curves.first.tolist())):
        item = tuple(column[first:end].tobytes() for column in (curves.points, curves.turn_rad, curves.kind))
        kind[loop] = known.setdefault(item, len(known))
        if kind[loop] == len(distinct):
            distinct.append(loop)
    return np.array(distinct), kind


def has_curves(primitives: Sequence[Primitive]) -> bool:
    """Return whether any outline is curved."""
    return any(bool(np.any(fill.curves.kind != STRAIGHT)) for one in primitives for fill in one.fills)


def area_of(primitive: Primitive, rings: list[F64]) -> Any:
    """Return the Shapely geometry of what a primitive covers."""
    layers, left = [], iter(rings)
    for layer in primitive.layers:
        own = [list(itertools.islice(left, len(fill.curves.first) - 1)) for fill in layer]
        fills = [region_of(rings, fill.rule, simple=fill.simple) for fill, rings in zip(layer, own, strict=True)]
        whole = fills[0]
        for fill_area in fills[1:]:
            whole = joined_areas([whole, without(fill_area, [whole])])
        layers.append(whole)
    return functools.reduce(common, layers)


def loops_of(primitive: Primitive, side_um: float) -> list[F64]:
    """Return the loops (n, 2) around a primitive, to draw: holes run the other way, sides are ``side_um`` long."""
    import shapely

    area = area_of(primitive, Outlines.of([primitive]).rings(SideLimits(side_um))[0])
    polygons = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
    oriented = [shapely.geometry.polygon.orient(part) for part in polygons]
    return [np.asarray(ring.coords)[:-1] for part in oriented for ring in (part.exterior, *part.interiors)]


def surface_at(scene: Scene, x_um: float, y_um: float) -> Spectrum:
    """Return the visible surface at a point, for a picture its mean; curves are approximated by polygons."""
    import shapely

    primitives = flattened(scene.shapes)
    boxes = Outlines.of(primitives).boxes
    about = (boxes[:, 0] <= x_um) & (x_um <= boxes[:, 2]) & (boxes[:, 1] <= y_um) & (y_um <= boxes[:, 3])
    for number in np.flatnonzero(about)[::-1]:
        primitive = primitives[int(number)]
        item = Outlines.of([primitive]).rings(SideLimits())[0]
        if area_of(primitive, item).contains(shapely.Point(x_um, y_um)):
            return primitive.reflectance
    return scene.background
