"""What the check sees of a scene: pieces of outlines, straight or round, and what is to be seen on either side of each.

No polygon is clipped. Every outline is cut where another crosses it; in the middle of each piece the painter's rule is
asked twice, on its left and on its right: of all shapes that cover the place the last one is seen. A shape covers a
place when its outline winds about it; where the place lies on the shape's own outline, one side is inside and the other
is not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.check.cuts import between, cuts_of
from camsim.rendering.check.outlines import Outlines, outlines_of
from camsim.rendering.check.painter import sides_of
from camsim.scene import Scene
from camsim.spectra.curve import Spectrum

SAME = 1e-10  # pitches, and as a share of the largest coordinate: places this near are one


class Pieces(NamedTuple):
    """What is left of the outlines: parts with different spectra on their two sides."""

    outlines: Outlines
    left: I64
    right: I64


def pieces_of(scene: Scene, pitch_um: float) -> tuple[Pieces, tuple[Spectrum, ...]]:
    """Return the pieces of a scene, pitches, and its spectra: the background first."""
    spectra: dict[Spectrum, int] = {scene.background: 0}
    of_shape = np.array([spectra.setdefault(shape.reflectance, len(spectra)) for shape in scene.shapes], np.int64)
    outlines = outlines_of(scene, pitch_um)
    if not len(outlines.x):
        nothing = np.empty(0, np.int64)
        return Pieces(outlines, nothing, nothing), tuple(spectra)
    boxes = _boxes(outlines)
    first = np.searchsorted(outlines.shape, np.arange(len(scene.shapes) + 1))
    filled = np.flatnonzero(np.diff(first))
    shape_boxes = np.full((len(scene.shapes), 4), np.inf)
    shape_boxes[:, 2:] = -np.inf
    shape_boxes[filled, :2] = np.minimum.reduceat(boxes[:, :2], first[filled])
    shape_boxes[filled, 2:] = np.maximum.reduceat(boxes[:, 2:], first[filled])
    size = float(np.abs(np.concatenate([outlines.x, outlines.y])).max())
    same = SAME * max(1.0, size)
    begin, near = _neighbours(shape_boxes, same)
    cuts, places = cuts_of(outlines, boxes, first, begin, near, shape_boxes, same)
    owner, low, high = between(cuts, places)
    left, right = sides_of(outlines, owner, low, high, first, begin, near, shape_boxes, of_shape, same)
    length = np.where(outlines.turn_rad == 0.0, np.hypot(outlines.dx, outlines.dy), outlines.dx * outlines.turn_rad)
    # A piece as short as rounding has no direction.
    seen = (left != right) & ((high - low) * length[owner] > 1e-3 * same)
    owner, low, high = owner[seen], low[seen], high[seen]
    whole = Outlines(*(column[owner] for column in outlines))
    straight = whole.turn_rad == 0.0
    cut = Outlines(
        x=whole.x + np.where(straight, low * whole.dx, 0.0),
        y=whole.y + np.where(straight, low * whole.dy, 0.0),
        dx=np.where(straight, (high - low) * whole.dx, whole.dx),
        dy=np.where(straight, (high - low) * whole.dy, 0.0),
        from_rad=whole.from_rad + low * whole.turn_rad,
        turn_rad=(high - low) * whole.turn_rad,
        shape=whole.shape,
    )
    return Pieces(cut, left[seen], right[seen]), tuple(spectra)


def _boxes(o: Outlines) -> F64:
    """Return (n, 4) low x, low y, high x, high y; of a round part its whole circle's."""
    straight = o.turn_rad == 0.0
    x2, y2 = np.where(straight, o.x + o.dx, o.x), np.where(straight, o.y + o.dy, o.y)
    more = np.where(straight, 0.0, o.dx)
    return np.stack(
        [
            np.minimum(o.x, x2) - more,
            np.minimum(o.y, y2) - more,
            np.maximum(o.x, x2) + more,
            np.maximum(o.y, y2) + more,
        ],
        axis=1,
    )


def _neighbours(boxes: F64, same: float) -> tuple[I64, I64]:
    """Return for each shape the others whose boxes touch its own, in painter's order: where they begin, and they."""
    count = len(boxes)
    order = np.argsort(boxes[:, 0], kind="stable")
    lows = boxes[order, 0]
    pairs: list[tuple[I64, I64]] = []
    for place, i in enumerate(order.tolist()):
        stop = int(np.searchsorted(lows, boxes[i, 2] + same, side="right"))
        other = order[place + 1 : stop]
        other = other[(boxes[other, 1] <= boxes[i, 3] + same) & (boxes[other, 3] >= boxes[i, 1] - same)]
        pairs.append((np.full(other.size, i), other))
    one = np.concatenate([pair[0] for pair in pairs])
    two = np.concatenate([pair[1] for pair in pairs])
    a, b = np.concatenate([one, two]), np.concatenate([two, one])
    sort = np.lexsort((b, a))
    return np.searchsorted(a[sort], np.arange(count + 1)), b[sort]
