"""The scene's outlines as the check takes them: straight parts, arcs of circles and Bézier curves, nothing clipped."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.check.beziers import alone, in_parts
from camsim.rendering.check.records import Outlines, Owners
from camsim.scene import Primitive, Scene, flattened
from camsim.scene.arcs import Fineness, arcs_of
from camsim.scene.curves import STRAIGHT, Curves, circles_among, joined

OF_CUSPS = 0.02  # of what may be off: what a line leaves out of one, at the most its room's square


def outlines_of(
    scene: Scene, pitch_um: float, fine: Fineness, *, whole: bool = False
) -> tuple[Outlines, Owners, list[Primitive], tuple[I64, F64]]:
    """Return the outlines of all shapes, pitches; circles stay circles, what else bends becomes arcs.

    whole   : parts of Bézier curves that nothing comes near stay what they are, and their chords are the outlines
    returns : and of which of those each part is the chord, −1 for none, and their control points (m, 4, 2)
    """
    primitives = flattened(scene.shapes)
    fills = [fill for one in primitives for fill in one.fills]
    curves = joined([fill.curves for fill in fills])
    curves = curves._replace(points=curves.points / pitch_um)
    pieces = np.cumsum([0, *(len(fill.curves.kind) for fill in fills)])
    kept = np.zeros(len(curves.kind), bool)
    if whole:
        curves, of_each, usable = in_parts(curves, fine.longest)
        pieces = np.concatenate([[0], np.cumsum(of_each)])[pieces]
        kept = alone(curves, usable, fine)
    outlines, ends, counts = parts_of(curves, kept, fine, cut=True)
    begins = np.concatenate([[0], np.cumsum(counts)])
    bezier = np.repeat(np.where(kept, np.cumsum(kept) - 1, -1), counts)
    owners = Owners(
        part=begins[pieces],
        fill=_firsts([len(layer) for one in primitives for layer in one.layers]),
        layer=_firsts([len(one.layers) for one in primitives]),
        even_odd=np.array([fill.rule == "evenodd" for fill in fills], bool),
        ends=ends,
    )
    return outlines, owners, primitives, (bezier, curves.points[kept])


def _firsts(counts: Sequence[int]) -> I64:
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int64)


def parts_of(curves: Curves, chords: np.ndarray, fine: Fineness, *, cut: bool = False) -> tuple[Outlines, F64, I64]:
    """Return the parts of all curves in order, their ends, and how many each curve has; of some their chords.

    cut : others may cross them
    """
    p, turn = curves.points, curves.turn_rad
    u, v = p[:, 1], p[:, 2]
    size = np.hypot(u[:, 0], u[:, 1])
    circle = circles_among(curves)
    straight = (curves.kind == STRAIGHT) | chords
    columns = np.zeros((len(straight), 10))
    columns[:, 6:8], columns[:, 8:] = p[:, 0], p[:, 3]
    columns[straight, :2], columns[straight, 2:4] = p[straight, 0], (p[:, 3] - p[:, 0])[straight]
    columns[circle, :2], columns[circle, 2] = (p[:, 0] - u)[circle], size[circle]
    way = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    columns[circle, 4] = np.arctan2(u[:, 1], u[:, 0])[circle]
    columns[circle, 5] = (way * turn)[circle]
    whole = straight | circle
    nowhere = straight & ~np.any(columns[:, 2:4] != 0.0, axis=1)
    owner, rows = np.flatnonzero(whole & ~nowhere), columns[whole & ~nowhere]
    if not whole.all():
        others = np.flatnonzero(~whole)
        bent = arcs_of(curves.some(others), fine, cut=cut, least=fine.longest * math.sqrt(OF_CUSPS * fine.allowed))
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
