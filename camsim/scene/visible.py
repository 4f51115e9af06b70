"""What of each shape can be seen: later ones cover earlier ones."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.errors import InvalidValueError
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import Primitive
from camsim.scene.regions import joined_areas, rings_of, without
from camsim.scene.rims import Discs
from camsim.scene.side_limits import SideLimits

MOST_PAIRS = 30_000_000  # of shapes whose boxes touch: 8000 rings in one another, a gigabyte
TOGETHER = 1000  # boxes that are looked up at a time
ROUGH = 0.01  # of a shape's size: more than a rough outline is off


@dataclass(frozen=True, slots=True, eq=False)
class Covers:
    """Which primitives may cover which.

    seen     : those that no single later one hides, in painter's order
    first, second : pairs of them, by their place in ``seen``, whose boxes touch; the first is painted earlier
    alone    : (seen,) those that touch no other and whose outlines are simple: they keep their very numbers
    """

    seen: I64
    first: I64
    second: I64
    alone: np.ndarray

    @classmethod
    def of(cls, primitives: Sequence[Primitive], outlines: Outlines) -> Covers:
        """Find them."""
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
        """Return those among some that meet none of the others."""
        number = np.cumsum(which) - 1
        kept = which[self.first]
        first, second = number[self.first[kept]], number[self.second[kept]]
        return Covers(self.seen[which], first, second, self.alone[which])

    def met(self, pairs: np.ndarray) -> Covers:
        """Return the same, knowing which pairs meet: what has none is alone, simple or not."""
        first, second = self.first[pairs], self.second[pairs]
        alone = np.ones(len(self.seen), bool)
        alone[first] = alone[second] = False
        return Covers(self.seen, first, second, alone)

    def some_pairs(self, pairs: np.ndarray) -> Covers:
        """Return the same with some of the pairs only: those that touch and no more hide nothing of one another."""
        return dataclasses.replace(self, first=self.first[pairs], second=self.second[pairs])

    def after(self) -> list[I64]:
        """Return which later ones each touches."""
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
    """Return which primitives lie wholly under a single later one that is simple.

    Discs under discs are known; of others rough outlines are asked, and boxes larger than these are off.
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
    """Return (region, rings) of what can be seen of shapes that may cover one another; one that meets no other keeps
    its very numbers.

    seen, rings : primitives with their regions, and the polygons of each;  covers: of them
    """
    if not len(seen):
        return []
    import shapely

    areas = np.array([area_of(primitive, one) for (primitive, _), one in zip(seen, rings, strict=True)], object)
    covers = covers.met(shapely.intersects(areas[covers.first], areas[covers.second]))
    hiding = covers.some_pairs(~shapely.touches(areas[covers.first], areas[covers.second]))
    sizes = shapely.area(areas)
    visible: list[tuple[int, list[F64]]] = []
    pieces: dict[int, list[Any]] = {}
    for i, after in enumerate(hiding.after()):
        region = seen[i][1]
        if covers.alone[i]:
            visible.append((region, rings_of(areas[i])))
            continue
        later = areas[after[np.argsort(-sizes[after], kind="stable")]]  # the largest first: they leave least
        piece = without(areas[i], later)  # its very numbers, where shapes lie beside it only
        if not piece.is_empty:
            pieces.setdefault(region, []).append(piece)
    for region, parts in pieces.items():
        visible += [(region, rings_of(together)) for together in _joined(parts)]
    return visible


def _joined(parts: list[Any]) -> list[Any]:
    """Return areas of one region: those joined that touch."""
    import shapely

    if len(parts) == 1:
        return parts
    found = np.array(parts)
    first, second = shapely.STRtree(found).query(found, predicate="intersects")
    group = np.arange(len(found))
    while True:  # each takes the least number among its neighbours
        least = group.copy()
        np.minimum.at(least, first, group[second])
        least = least[least]
        if np.array_equal(least, group):
            break
        group = least
    together = []
    for number in np.unique(group).tolist():
        members = found[group == number]
        together.append(joined_areas(members))
    return together
