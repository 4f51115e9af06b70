"""Point-in-shape tests on exact curves, by counting crossings of a horizontal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64, distinct
from camsim.scene.curves import Curves
from camsim.scene.outlines import Outlines
from camsim.scene.primitives import Primitive
from camsim.scene.regions import inside

HALVINGS = 60  # of a stretch: then its two ends are equal numbers
AT_ONCE = 1 << 20  # stretches times places


def covered(places_um: F64, before: I64, primitives: Sequence[Primitive]) -> np.ndarray:
    """Return a mask of places (n, 2) that primitives cover; before: (n,) index of the first primitive to test.

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
    for one in distinct(number).tolist():
        about = place[np.searchsorted(number, one, "left") : np.searchsorted(number, one, "right")]
        asked = about[~found[about]]
        found[asked] = _covers(primitives[one], places_um[asked])
    return found


def _covers(primitive: Primitive, places: F64) -> np.ndarray:
    """Return a mask of places covered by some fill in every layer."""
    all_layers = np.ones(len(places), bool)
    for layer in primitive.layers:
        filled = np.zeros(len(places), bool)
        for fill in layer:
            filled |= inside(_windings(_Stretches.of(fill.curves), places), fill.rule)
        all_layers &= filled
    return all_layers


class _Stretches(NamedTuple):
    """Parts of curves along which y is monotone.

    curves       : the curve of each, without loops
    begin, end   : parameters;  y0, y1: y there, bit-identical to those of adjacent stretches
    left, right  : bounds of x over the curve
    """

    curves: Curves
    begin: F64
    end: F64
    y0: F64
    y1: F64
    left: F64
    right: F64

    @classmethod
    def of(cls, curves: Curves) -> _Stretches:
        """Cut curves at extrema of y."""
        extremes = curves.extremes(1)
        count = len(extremes)
        shares = np.concatenate([np.zeros((count, 1)), extremes, np.ones((count, 1))], axis=1)
        heights = np.stack([curves.at(share)[:, 1] for share in shares.T], axis=1)
        heights[:, 0] = curves.points[:, 0, 1]
        ends = shares == 1.0
        heights[ends] = np.broadcast_to(curves.points[:, 3, 1, None], heights.shape)[ends]
        owner, column = np.nonzero(shares[:, 1:] > shares[:, :-1])
        boxes = curves.boxes[owner]
        return cls(
            curves.some(owner), shares[owner, column], shares[owner, column + 1],
            heights[owner, column], heights[owner, column + 1], boxes[:, 0], boxes[:, 2],
        )  # fmt: skip


def _windings(of: _Stretches, places: F64) -> I64:
    """Return winding numbers of curves about places (n, 2): crossings of the horizontal to the right, up minus down."""
    windings = np.zeros(len(places), np.int64)
    step = max(1, AT_ONCE // max(1, len(of.begin)))
    for begin in range(0, len(places), step):
        x, y = places[begin : begin + step].T
        level = (of.y0 <= y[:, None]) != (of.y1 <= y[:, None])
        place, stretch = np.nonzero(level & (of.right > x[:, None]))
        spans = of.left[stretch] <= x[place]
        crossing = np.full(place.size, np.inf)
        crossing[spans] = _crossing(of, stretch[spans], y[place[spans]])
        up = np.where(of.y1[stretch] > of.y0[stretch], 1, -1)
        np.add.at(windings, begin + place, np.where(crossing > x[place], up, 0))
    return windings


def _crossing(of: _Stretches, which: I64, y: F64) -> F64:
    """Return x at which stretches cross their horizontals, by bisection."""
    curves, low, high = of.curves.some(which), of.begin[which], of.end[which]
    rises = of.y1[which] > of.y0[which]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        under = (curves.at(middle)[:, 1] <= y) == rises
        low, high = np.where(under, middle, low), np.where(under, high, middle)
    return curves.at(0.5 * (low + high))[:, 0]
