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

from camsim.core.arrays import F64, I64, picked
from camsim.rendering.direct.cuts import Near, pieces_between_cuts
from camsim.rendering.direct.painter import OFFSET, WIDE_OFFSET, Rows, Shapes, sides_of
from camsim.rendering.direct.records import Outlines, Owners
from camsim.scene import Primitive, Scene, flattened
from camsim.scene.arcs import Arcs, Fineness, arcs_of
from camsim.scene.curves import STRAIGHT, Curves, circles_among, joined
from camsim.spectra.curve import Spectrum

# Distance below which places coincide: pitches, and a share of the largest coordinate, whose last bits are rounding.
# Outlines that cross at a small angle coincide over many times this length, and an edge may be lost there.
SAME, SAME_SHARE = 1e-12, 1e-12
OF_CUSPS = 0.02  # share of the error for cusps that a line replaces, at most the square of their size
OUTWARD = np.array([-1.0, -1.0, 1.0, 1.0])  # of a box
NO_ARCS = Arcs(np.empty(0, np.int64), np.empty(0, complex), np.empty(0, complex), np.empty(0))


class Pieces(NamedTuple):
    """Parts of the outlines, with the indices of the different spectra on their two sides."""

    outlines: Outlines
    left: I64
    right: I64


def pieces_of(scene: Scene, pitch_um: float, fine: Fineness) -> tuple[Pieces, tuple[Spectrum, ...]]:
    """Return the pieces of a scene, pitches, and its spectra, the background first."""
    shapes, primitives = shapes_of(scene, pitch_um, fine)
    outlines, spectra = shapes.parts, {scene.background: 0}
    of_primitive = np.array([spectra.setdefault(one.reflectance, len(spectra)) for one in primitives], np.int64)
    if not len(outlines.x):
        nothing = np.empty(0, np.int64)
        return Pieces(outlines, nothing, nothing), tuple(spectra)
    near = Near.of(shapes.boxes + 4.0 * OFFSET * float(shapes.same.max()) * OUTWARD)
    touching = Near.of(shapes.bounds)
    owner, low, high = pieces_between_cuts(outlines, shapes.owners.ends, shapes.bounds, touching, shapes.same)
    left, right = sides_of(shapes, near, touching, (owner, low, high), of_primitive)
    visible = left != right
    owner, low, high = owner[visible], low[visible], high[visible]
    return Pieces(_between(picked(outlines, owner), low, high), left[visible], right[visible]), tuple(spectra)


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


def shapes_of(scene: Scene, pitch_um: float, fine: Fineness) -> tuple[Shapes, list[Primitive]]:
    """Return all shapes, pitches, and their primitives."""
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
    boxes = _boxes_of(outlines, ends)
    # Points of an arc have the rounding of its centre and its radius.
    size = np.maximum(np.abs(outlines.x) + np.where(outlines.turn_rad == 0.0, 0.0, outlines.dx), np.abs(outlines.y))
    same = np.maximum(np.maximum(SAME, SAME_SHARE * np.abs(boxes).max(axis=1)), 1e-14 * size)
    bounds = boxes + 2.0 * WIDE_OFFSET * same[:, None] * OUTWARD
    return Shapes(outlines, owners, Rows.of(owners, bounds), same, bounds, _boxes_about(boxes, owners)), primitives


def _firsts(counts: Sequence[int]) -> I64:
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int64)


def _parts_of(curves: Curves, fine: Fineness) -> tuple[Outlines, F64, I64]:
    """Return the parts of all curves in order, their end points, and the number of parts of each curve."""
    first, u, v, last = np.ascontiguousarray(curves.points).view(np.complex128)[..., 0].T
    is_ring, is_line = circles_among(curves), curves.kind == STRAIGHT
    lines, rings = np.flatnonzero(is_line & (first != last)), np.flatnonzero(is_ring)
    others = np.flatnonzero(~(is_line | is_ring))
    least = fine.longest * math.sqrt(OF_CUSPS * fine.allowed)
    arcs = arcs_of(curves.some(others), fine, cut=True, least=least) if others.size else NO_ARCS
    start, chord, bend = arcs.start, arcs.end - arcs.start, arcs.bend_rad
    # The centre lies to the left of the chord by half of it over tan(bend/2).
    is_flat = bend == 0.0
    half = np.where(is_flat, 1.0, 0.5 * bend)
    centre = start + 0.5 * chord * (1.0 + 1j / np.tan(half))
    whole = np.concatenate([lines, rings])
    owner = np.concatenate([whole, others[arcs.owner]])
    place = np.concatenate([first[lines], (first - u)[rings], np.where(is_flat, start, centre)])
    radius = np.where(is_flat, chord, 0.5 * np.abs(chord) / np.abs(np.sin(half)))
    along = np.concatenate([(last - first)[lines], np.abs(u)[rings], radius])
    angle = np.where(is_flat, 0.0, np.angle(start - centre))
    from_rad = np.concatenate([np.zeros(lines.size), np.angle(u)[rings], angle])
    turn = np.sign((u.conj() * v).imag) * curves.turn_rad
    turn_rad = np.concatenate([np.zeros(lines.size), turn[rings], bend])
    ends = np.concatenate([np.stack([first, last], axis=1)[whole], np.stack([start, arcs.end], axis=1)])
    order = np.argsort(owner, kind="stable")
    columns = (place.real, place.imag, along.real, along.imag, from_rad, turn_rad)
    counts = np.bincount(owner, minlength=len(first))
    return Outlines(*(column[order] for column in columns)), ends[order].view(np.float64), counts


def _boxes_of(o: Outlines, ends: F64) -> F64:
    """Return the bounding box (n, 4) of each part: low x, low y, high x, high y."""
    places = np.stack([ends[:, :2], o.at(0.5), ends[:, 2:]])
    # An arc of up to half a turn lies within its sagitta of the box of its chord and middle; others use the circle.
    turn, centre, radius = np.abs(o.turn_rad)[:, None], np.stack([o.x, o.y], axis=1), o.dx[:, None]
    short, height = turn <= np.pi, radius * (1.0 - np.cos(0.5 * np.minimum(turn, np.pi)))
    low = np.where(short, places.min(axis=0) - height, centre - radius)
    high = np.where(short, places.max(axis=0) + height, centre + radius)
    return np.concatenate([low, high], axis=1)


def _boxes_about(boxes: F64, owners: Owners) -> F64:
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
