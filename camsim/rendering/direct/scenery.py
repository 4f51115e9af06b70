"""The check's model of a scene: straight and round pieces of outlines, with the spectrum visible on either side.

No polygon is clipped. Every outline is cut where it crosses another or itself. In the middle of each piece the
painter's rule is applied just to its left and just to its right: the last of all shapes that cover the place is
visible. A shape covers a place if its outlines wind about it, by its fill rule and by those of all its clips.
Circles stay circles; other curves become arcs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.rendering.direct.cuts import Sorted, pairs, pieces_between_cuts
from camsim.rendering.direct.painter import BESIDE, Near, Rows, sides_of
from camsim.rendering.direct.records import Outlines, Owners
from camsim.scene import Primitive, Scene, flattened
from camsim.scene.arcs import Fineness, arcs_of
from camsim.scene.curves import STRAIGHT, Curves, circles_among, joined
from camsim.spectra.curve import Spectrum

# Distance below which places coincide: pitches, and a share of the largest coordinate, whose last bits are rounding.
# Outlines that cross at a small angle coincide over many times this length, and an edge may be lost there.
SAME, SAME_SHARE = 1e-12, 1e-12
SHORTEST = 0.1  # over that distance: shorter pieces have no direction
OF_CUSPS = 0.02  # share of the error for cusps that a line replaces, at most the square of their size


class Pieces(NamedTuple):
    """Parts of the outlines, with the indices of the different spectra on their two sides."""

    outlines: Outlines
    left: I64
    right: I64


def pieces_of(scene: Scene, pitch_um: float, fine: Fineness) -> tuple[Pieces, tuple[Spectrum, ...]]:
    """Return the pieces of a scene, pitches, and its spectra, the background first."""
    outlines, owners, primitives = outlines_of(scene, pitch_um, fine)
    spectra: dict[Spectrum, int] = {scene.background: 0}
    of_primitive = np.array([spectra.setdefault(one.reflectance, len(spectra)) for one in primitives], np.int64)
    if not len(outlines.x):
        nothing = np.empty(0, np.int64)
        return Pieces(outlines, nothing, nothing), tuple(spectra)
    boxes = boxes_of(outlines)
    same = same_of(outlines, boxes)
    near = _neighbours(boxes_about(boxes, owners), 4.0 * BESIDE * float(same.max()))
    piece = pieces_between_cuts(outlines, boxes, same)
    rows = Rows.of(owners, boxes, same)
    left, right = sides_of(outlines, rows, owners, near, piece, owners.primitive, of_primitive, same)
    owner, low, high = piece
    # A piece no longer than rounding has no direction.
    seen = (left != right) & ((high - low) * outlines.length[owner] > SHORTEST * same[owner])
    owner, low, high = owner[seen], low[seen], high[seen]
    return Pieces(_between(outlines.some(owner), low, high), left[seen], right[seen]), tuple(spectra)


def _between(part: Outlines, low: F64, high: F64) -> Outlines:
    """Return each part between the fractions ``low`` and ``high`` of its length."""
    straight = part.turn_rad == 0.0
    return Outlines(
        x=part.x + np.where(straight, low * part.dx, 0.0),
        y=part.y + np.where(straight, low * part.dy, 0.0),
        dx=np.where(straight, (high - low) * part.dx, part.dx),
        dy=np.where(straight, (high - low) * part.dy, 0.0),
        from_rad=part.from_rad + low * part.turn_rad,
        turn_rad=(high - low) * part.turn_rad,
    )


def outlines_of(scene: Scene, pitch_um: float, fine: Fineness) -> tuple[Outlines, Owners, list[Primitive]]:
    """Return the outlines of all shapes, pitches."""
    primitives = flattened(scene.shapes)
    fills = [fill for one in primitives for fill in one.fills]
    curves = joined([fill.curves for fill in fills])
    curves = curves._replace(points=curves.points / pitch_um)
    pieces = np.cumsum([0, *(len(fill.curves.kind) for fill in fills)])
    outlines, ends, counts = _parts_of(curves, fine)
    begins = np.concatenate([[0], np.cumsum(counts)])
    owners = Owners(
        part=begins[pieces],
        fill=_firsts([len(layer) for one in primitives for layer in one.layers]),
        layer=_firsts([len(one.layers) for one in primitives]),
        even_odd=np.array([fill.rule == "evenodd" for fill in fills], bool),
        ends=ends,
    )
    return outlines, owners, primitives


def _firsts(counts: Sequence[int]) -> I64:
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int64)


def _parts_of(curves: Curves, fine: Fineness) -> tuple[Outlines, F64, I64]:
    """Return the parts of all curves in order, their end points, and the number of parts of each curve."""
    p, turn = curves.points, curves.turn_rad
    u, v = p[:, 1], p[:, 2]
    circle, straight = circles_among(curves), curves.kind == STRAIGHT
    columns = np.zeros((len(straight), 10))
    columns[:, 6:8], columns[:, 8:] = p[:, 0], p[:, 3]
    columns[straight, :2], columns[straight, 2:4] = p[straight, 0], (p[:, 3] - p[:, 0])[straight]
    columns[circle, :2], columns[circle, 2] = (p[:, 0] - u)[circle], np.hypot(u[:, 0], u[:, 1])[circle]
    way = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    columns[circle, 4] = np.arctan2(u[:, 1], u[:, 0])[circle]
    columns[circle, 5] = (way * turn)[circle]
    whole = straight | circle
    nowhere = straight & ~np.any(columns[:, 2:4] != 0.0, axis=1)
    owner, rows = np.flatnonzero(whole & ~nowhere), columns[whole & ~nowhere]
    if not whole.all():
        others = np.flatnonzero(~whole)
        bent = arcs_of(curves.some(others), fine, cut=True, least=fine.longest * math.sqrt(OF_CUSPS * fine.allowed))
        owner = np.concatenate([owner, others[bent.owner]])
        start, chord, bend = bent.start, bent.end - bent.start, bent.bend_rad
        # The centre lies to the left of the chord by half of it over tan(bend/2).
        half = np.where(bend == 0.0, 1.0, 0.5 * bend)
        centre = start + 0.5 * chord * (1.0 + 1j / np.tan(half))
        radius = 0.5 * np.abs(chord) / np.abs(np.sin(half))
        line = bend == 0.0
        place = np.where(line, start, centre)
        more = np.stack(
            [
                place.real,
                place.imag,
                np.where(line, chord.real, radius),
                np.where(line, chord.imag, 0.0),
                np.where(line, 0.0, np.angle(start - centre)),
                bend,
                *(start.real, start.imag, bent.end.real, bent.end.imag),
            ],
            axis=1,
        )
        rows = np.concatenate([rows, more])
        order = np.argsort(owner, kind="stable")
        owner, rows = owner[order], rows[order]
    counts = np.bincount(owner, minlength=len(straight))
    return Outlines(*(np.ascontiguousarray(column) for column in rows.T[:6])), rows[:, 6:].copy(), counts


def same_of(outlines: Outlines, boxes: F64) -> F64:
    """Return the distance (n,) below which places coincide, for each part."""
    # Points of an arc have the rounding of its centre and its radius.
    size = np.maximum(np.abs(outlines.x) + np.where(outlines.turn_rad == 0.0, 0.0, outlines.dx), np.abs(outlines.y))
    same: F64 = np.maximum(np.maximum(SAME, SAME_SHARE * np.abs(boxes).max(axis=1)), 1e-14 * size)
    return same


def boxes_of(o: Outlines) -> F64:
    """Return the bounding box (n, 4) of each part: low x, low y, high x, high y."""
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
    # An arc of up to half a turn lies within its sagitta of the box of its chord and middle; others use the circle.
    turn = np.abs(o.turn_rad)
    short, height = turn <= np.pi, o.dx * (1.0 - np.cos(0.5 * np.minimum(turn, np.pi)))
    low, high = (
        [np.where(short, each.min(axis=0) - height, place - o.dx) for each, place in ((x, o.x), (y, o.y))],
        [np.where(short, each.max(axis=0) + height, place + o.dx) for each, place in ((x, o.x), (y, o.y))],
    )
    return np.stack([*low, *high], axis=1)


def boxes_about(boxes: F64, owners: Owners) -> F64:
    """Return bounds (primitives, 4) of the region that each primitive covers: where the boxes of its layers overlap."""
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
    """Return for each primitive those with touching boxes, itself included, in painter's order."""
    some = np.flatnonzero(np.isfinite(boxes).all(axis=1))
    if some.size < 2:
        return Near(np.searchsorted(some, np.arange(len(boxes) + 1)), some, boxes)
    a, b = pairs(Sorted.of(boxes[some] + same * np.array([-1.0, -1.0, 1.0, 1.0])))
    one, two = np.concatenate([some, some[a], some[b]]), np.concatenate([some, some[b], some[a]])
    sort = np.lexsort((two, one))
    return Near(np.searchsorted(one[sort], np.arange(len(boxes) + 1)), two[sort], boxes)
