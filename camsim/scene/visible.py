"""The visible part of each shape: later ones cover earlier ones."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64, distinct
from camsim.errors import InvalidValueError
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import Primitive
from camsim.scene.regions import joined_areas, rings_of, without
from camsim.scene.rims import Discs
from camsim.scene.side_limits import SideLimits

MOST_PAIRS = 30_000_000  # of shapes with touching boxes: 8000 nested rings, 1 GB
TOGETHER = 1000  # boxes queried at a time
ROUGH = 0.01  # of a shape's size: bound of the deviation of a rough outline


@dataclass(frozen=True, slots=True, eq=False)
class Covers:
    """The pairs of primitives of which the later one may cover the earlier one.

    seen     : primitives that no single later one hides, in painter's order
    first, second : pairs with touching boxes, as indices into ``seen``; the first is painted earlier
    alone    : (seen,) those that touch no other and have simple outlines: their coordinates stay exact
    """

    seen: I64
    first: I64
    second: I64
    alone: np.ndarray

    @classmethod
    def of(cls, primitives: Sequence[Primitive], outlines: Outlines) -> Covers:
        """Return the covers of primitives."""
        boxes = outlines.boxes
        first, second = _touching(boxes)
        hidden = _hidden(primitives, outlines, boxes, first, second)
        seen = np.flatnonzero(~hidden)
        number = np.cumsum(~hidden) - 1
        both = ~hidden[first] & ~hidden[second]
        first, second = number[first[both]], number[second[both]]
        alone = outlines.simple[seen].copy()
        alone[first] = alone[second] = False
        return cls(seen, first, second, alone)

    def some(self, which: np.ndarray) -> Covers:
        """Return the covers among selected primitives, which meet none of the others."""
        number = np.cumsum(which) - 1
        selected = which[self.first]
        first, second = number[self.first[selected]], number[self.second[selected]]
        return Covers(self.seen[which], first, second, self.alone[which])

    def met(self, pairs: np.ndarray) -> Covers:
        """Return the covers when it is known which pairs meet: primitives in no such pair are alone, simple or not."""
        first, second = self.first[pairs], self.second[pairs]
        alone = np.ones(len(self.seen), bool)
        alone[first] = alone[second] = False
        return Covers(self.seen, first, second, alone)

    def after(self) -> list[I64]:
        """Return, for each primitive, the later ones that it touches."""
        order = np.lexsort((self.second, self.first))
        parts = np.searchsorted(self.first[order], np.arange(1, len(self.seen)))
        return np.split(self.second[order], parts)


def _touching(boxes: F64) -> tuple[I64, I64]:
    """Return the pairs of primitives whose boxes touch, the earlier first."""
    filled = np.flatnonzero(np.isfinite(boxes).all(axis=1))
    if len(filled) < 2:
        return filled[:0], filled[:0]
    import shapely

    areas = shapely.box(*boxes[filled].T)
    tree, pairs, count = shapely.STRtree(areas), [], 0
    for begin in range(0, len(areas), TOGETHER):
        first, second = tree.query(areas[begin : begin + TOGETHER])
        earlier = first + begin < second
        pairs.append((first[earlier] + begin, second[earlier]))
        count += len(pairs[-1][0])
        if count > MOST_PAIRS:
            raise InvalidValueError(
                f"of {len(areas)} shapes more than {MOST_PAIRS // 10**6} million pairs lie one over the other; "
                "draw fewer, or in parts that lie apart",
                key="shapes",
                stage="Scene",
            )
    first, second = (np.concatenate(column) for column in zip(*pairs, strict=True))
    return filled[first], filled[second]


def _hidden(primitives: Sequence[Primitive], outlines: Outlines, boxes: F64, first: I64, second: I64) -> np.ndarray:
    """Return a mask of primitives fully covered by a single later simple one.

    Discs under discs are exact; others use rough outlines, with boxes larger by their deviation.
    """
    hidden, discs = np.zeros(len(boxes), bool), Discs.of(outlines)
    hidden[first[discs.covered(first, second)]] = True
    others = ~(discs.sound[first] & discs.sound[second]) & ~hidden[first]
    first, second = first[others], second[others]
    if not first.size:
        return hidden
    size = boxes[:, 2:] - boxes[:, :2]
    grown = boxes + ROUGH * size.max(axis=1)[:, None] * [-1.0, -1.0, 1.0, 1.0]
    slack = ROUGH * size[second].max(axis=1)
    larger = outlines.simple[second] & (boxes[second, :2] + slack[:, None] <= grown[first, :2]).all(axis=1)
    larger &= (boxes[second, 2:] - slack[:, None] >= grown[first, 2:]).all(axis=1)
    if not larger.any():
        return hidden
    import shapely

    first, second, slack = first[larger], second[larger], slack[larger]
    covering, number = np.unique(second, return_inverse=True)
    rough = outlines.some(covering).rings(SideLimits())
    areas = np.array([area_of(primitives[i], rings) for i, rings in zip(covering.tolist(), rough, strict=True)])
    shapely.prepare(areas)
    wanted = grown[first] + slack[:, None] * [-1.0, -1.0, 1.0, 1.0]
    covered = shapely.contains_properly(areas[number.ravel()], shapely.box(*wanted.T))
    hidden[first[covered]] = True
    return hidden


def visible_rings(
    seen: Sequence[tuple[Primitive, int]], rings: Sequence[list[F64]], covers: Covers
) -> list[tuple[int, list[F64]]]:
    """Return (region, rings) of the visible parts of shapes; coordinates of shapes that meet no other stay exact.

    seen, rings : primitives with their regions, and the polygons of each;  covers: their covers
    """
    if not len(seen):
        return []
    import shapely

    areas = np.array([area_of(primitive, one) for (primitive, _), one in zip(seen, rings, strict=True)], object)
    covers = covers.met(shapely.intersects(areas[covers.first], areas[covers.second]))
    over = ~shapely.touches(areas[covers.first], areas[covers.second])  # those that only touch hide nothing
    hiding = dataclasses.replace(covers, first=covers.first[over], second=covers.second[over])
    sizes = shapely.area(areas)
    visible: list[tuple[int, list[F64]]] = []
    pieces: dict[int, list[Any]] = {}
    for i, after in enumerate(hiding.after()):
        region = seen[i][1]
        if covers.alone[i]:
            visible.append((region, rings_of(areas[i])))
            continue
        later = areas[after[np.argsort(-sizes[after], kind="stable")]]  # the largest first: they remove most
        piece = without(areas[i], later)  # exact coordinates if shapes only touch it
        if not piece.is_empty:
            pieces.setdefault(region, []).append(piece)
    for region, parts in pieces.items():
        visible += [(region, rings_of(together)) for together in _joined(parts)]
    return visible


def _joined(parts: list[Any]) -> list[Any]:
    """Return the areas of one region, with touching ones joined."""
    import shapely

    if len(parts) == 1:
        return parts
    found = np.array(parts)
    first, second = shapely.STRtree(found).query(found, predicate="intersects")
    group = np.arange(len(found))
    while True:  # label propagation: least label among neighbours
        least = group.copy()
        np.minimum.at(least, first, group[second])
        least = least[least]
        if np.array_equal(least, group):
            break
        group = least
    return [joined_areas(found[group == number]) for number in distinct(group).tolist()]
