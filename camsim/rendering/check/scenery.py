"""What the check sees of a scene: pieces of outlines, straight or round, and what is to be seen on either side of each.

No polygon is clipped. Every outline is cut where another crosses it, or where it crosses itself; in the middle of each
piece the painter's rule is asked twice, just to its left and just to its right: of all shapes that cover the place the
last one is seen. A shape covers a place when its outlines wind about it, by its rule and by that of all that clips it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.rendering.check.beziers import between, polynomials
from camsim.rendering.check.cuts import pieces_between_cuts
from camsim.rendering.check.near import Squares, pairs
from camsim.rendering.check.outlines import outlines_of, parts_of
from camsim.rendering.check.painter import BESIDE, Near, Rows, sides_of
from camsim.rendering.check.records import Outlines, Owners
from camsim.scene import Scene
from camsim.scene.arcs import Fineness
from camsim.scene.curves import CUBIC, Curves
from camsim.spectra.curve import Spectrum

# Pitches, and of the largest coordinate, whose last bits differ: so near are places one. Outlines that cross at a small
# angle are as near for many times as long, and what is left out there is an edge that others lack: with 1e-10 in place
# of 1e-12 the check was 1e-10 off.
SAME, SAME_SHARE = 1e-12, 1e-12
SHORTEST = 0.1  # of that: what is shorter has no direction
STRAIGHT_RAD = 1e-10  # a curve that turns by less is its chord


class Pieces(NamedTuple):
    """What is left of the outlines: parts with different spectra on their two sides.

    bezier : (n,) which Bézier curve a straight part is but the chord of, −1 for none
    curves : (m, 4) control points of these, x + iy
    """

    outlines: Outlines
    left: I64
    right: I64
    bezier: I64
    curves: C128

    @property
    def round(self) -> Outlines:
        """The outlines with arcs in the place of Bézier curves: of one's circle in its middle, about as long."""
        bent = np.flatnonzero(self.bezier >= 0)
        if not bent.size:
            return self.outlines
        middle, way, bend, _ = polynomials(self.curves[self.bezier[bent]]).T
        turn = 4.0 * (way.conj() * bend).imag / np.abs(way) ** 2
        some = np.abs(turn) > STRAIGHT_RAD
        bent, middle, way, turn = bent[some], middle[some], way[some], turn[some]
        radius, back = 2.0 * np.abs(way) / np.abs(turn), turn < 0.0
        centre = middle + 1j * np.where(back, -1.0, 1.0) * radius * way / np.abs(way)
        from_rad = np.angle(middle - centre) - 0.5 * np.abs(turn)
        o = Outlines(*(column.copy() for column in self.outlines))
        for column, values in zip(o, (centre.real, centre.imag, radius, 0.0, from_rad, np.abs(turn)), strict=True):
            column[bent] = values
        return o


def pieces_of(
    scene: Scene,
    pitch_um: float,
    fine: Fineness = Fineness(),  # noqa: B008 (a tuple of numbers)
    *,
    whole: bool = False,
) -> tuple[Pieces, tuple[Spectrum, ...]]:
    """Return the pieces of a scene, pitches, and its spectra: the background first; whole: see ``outlines_of``."""
    outlines, owners, primitives, (bezier, points) = outlines_of(scene, pitch_um, fine, whole=whole)
    spectra: dict[Spectrum, int] = {scene.background: 0}
    of_primitive = np.array([spectra.setdefault(one.reflectance, len(spectra)) for one in primitives], np.int64)
    if not len(outlines.x):
        nothing = np.empty(0, np.int64)
        return Pieces(outlines, nothing, nothing, nothing, np.empty((0, 4), np.complex128)), tuple(spectra)
    boxes = _boxes(outlines)
    # An arc's places are its centre's and its radius's numbers.
    size = np.maximum(np.abs(outlines.x) + np.where(outlines.turn_rad == 0.0, 0.0, outlines.dx), np.abs(outlines.y))
    same = np.maximum(np.maximum(SAME, SAME_SHARE * np.abs(boxes).max(axis=1)), 1e-14 * size)
    whose = owners.primitive
    near = _neighbours(_around(boxes, owners), 4.0 * BESIDE * float(same.max()))
    piece = pieces_between_cuts(outlines, boxes, same)
    rows = Rows.of(owners, boxes, same)
    left, right = sides_of(outlines, rows, owners, near, piece, whose, of_primitive, same)
    owner, low, high = piece
    # A piece as short as rounding has no direction.
    seen = (left != right) & ((high - low) * outlines.length[owner] > SHORTEST * same[owner])
    owner, low, high = owner[seen], low[seen], high[seen]
    part = outlines.some(owner)
    straight = part.turn_rad == 0.0
    cut = Outlines(
        x=part.x + np.where(straight, low * part.dx, 0.0),
        y=part.y + np.where(straight, low * part.dy, 0.0),
        dx=np.where(straight, (high - low) * part.dx, part.dx),
        dy=np.where(straight, (high - low) * part.dy, 0.0),
        from_rad=part.from_rad + low * part.turn_rad,
        turn_rad=(high - low) * part.turn_rad,
    )
    # Nothing crosses a chord; where rounding cuts off its last bit the curve is cut with it.
    bent = np.flatnonzero(bezier[owner] >= 0)
    curves = between((points[..., 0] + 1j * points[..., 1])[bezier[owner[bent]]], low[bent], high[bent])
    index = np.full(len(owner), -1)
    index[bent] = np.arange(bent.size)
    return Pieces(_one_way_round(cut), *_sides(cut, left[seen], right[seen]), index, curves), tuple(spectra)


def followed(pieces: Pieces, fine: Fineness) -> Pieces:
    """Return the same with Bézier curves followed by arcs."""
    if not len(pieces.curves):
        return pieces
    bent = pieces.bezier >= 0
    curves, owner = pieces.curves, np.flatnonzero(bent)
    points = np.stack([curves.real, curves.imag], axis=2)[pieces.bezier[owner]]
    drawn = Curves(points, np.zeros(owner.size), np.full(owner.size, CUBIC), np.array([0, owner.size]))
    arcs, _, counts = parts_of(drawn, np.zeros(owner.size, bool), fine)
    own = np.repeat(owner, counts)
    left, right = _sides(arcs, pieces.left[own], pieces.right[own])
    rest = pieces.outlines.some(~bent)
    outlines = Outlines(*(np.concatenate(both) for both in zip(rest, _one_way_round(arcs), strict=True)))
    left, right = np.concatenate([pieces.left[~bent], left]), np.concatenate([pieces.right[~bent], right])
    return Pieces(outlines, left, right, np.full(len(left), -1), pieces.curves[:0])


def _one_way_round(o: Outlines) -> Outlines:
    """Return the same with all arcs the positive way round."""
    back = o.turn_rad < 0.0
    return o._replace(from_rad=np.where(back, o.from_rad + o.turn_rad, o.from_rad), turn_rad=np.abs(o.turn_rad))


def _sides(o: Outlines, left: I64, right: I64) -> tuple[I64, I64]:
    """Return what is left and right of each when all arcs go the positive way round."""
    back = o.turn_rad < 0.0
    return np.where(back, right, left), np.where(back, left, right)


def _boxes(o: Outlines) -> F64:
    """Return (n, 4) low x, low y, high x, high y of each part."""
    boxes = np.empty((len(o.x), 4))
    np.minimum(o.x, o.x + o.dx, out=boxes[:, 0])
    np.minimum(o.y, o.y + o.dy, out=boxes[:, 1])
    np.maximum(o.x, o.x + o.dx, out=boxes[:, 2])
    np.maximum(o.y, o.y + o.dy, out=boxes[:, 3])
    bent = np.flatnonzero(o.turn_rad)
    if bent.size:
        boxes[bent] = _boxes_about_arcs(o.some(bent))
    return boxes


def _boxes_about_arcs(o: Outlines) -> F64:
    x, y = (
        place + o.dx * np.stack([way(o.from_rad + share * o.turn_rad) for share in (0.0, 0.5, 1.0)])
        for place, way in ((o.x, np.cos), (o.y, np.sin))
    )
    # An arc of up to half a turn lies about its chord and middle by no more than its height; others about the centre.
    turn = np.abs(o.turn_rad)
    short, height = turn <= np.pi, o.dx * (1.0 - np.cos(0.5 * np.minimum(turn, np.pi)))
    low, high = (
        [np.where(short, own.min(axis=0) - height, place - o.dx) for own, place in ((x, o.x), (y, o.y))],
        [np.where(short, own.max(axis=0) + height, place + o.dx) for own, place in ((x, o.x), (y, o.y))],
    )
    return np.stack([*low, *high], axis=1)


def _around(boxes: F64, owners: Owners) -> F64:
    """Return boxes (primitives, 4) about what each covers at the most: what those about its layers have in common."""
    part, around = owners.part[owners.fill], np.full((len(owners.layer) - 1, 4), np.inf)
    around[:, 2:] = -np.inf
    of_layer = np.repeat(np.arange(len(part) - 1), np.diff(part))
    filled, first = np.unique(of_layer, return_index=True)
    low, high = np.minimum.reduceat(boxes[:, :2], first), np.maximum.reduceat(boxes[:, 2:], first)
    of_primitive = np.repeat(np.arange(len(around)), np.diff(owners.layer))[filled]
    filled, first = np.unique(of_primitive, return_index=True)
    low, high = np.maximum.reduceat(low, first), np.minimum.reduceat(high, first)
    some = (low <= high).all(axis=1)
    around[filled[some]] = np.concatenate([low, high], axis=1)[some]
    return around


def _neighbours(boxes: F64, same: float) -> Near:
    """Return for each primitive those whose boxes touch its own, itself among them, in painter's order."""
    some = np.flatnonzero(np.isfinite(boxes).all(axis=1))
    if some.size < 2:
        return Near(np.searchsorted(some, np.arange(len(boxes) + 1)), some, boxes)
    a, b = pairs(Squares.of(boxes[some] + same * np.array([-1.0, -1.0, 1.0, 1.0])))
    one, two = np.concatenate([some, some[a], some[b]]), np.concatenate([some, some[b], some[a]])
    sort = np.lexsort((two, one))
    return Near(np.searchsorted(one[sort], np.arange(len(boxes) + 1)), two[sort], boxes)
