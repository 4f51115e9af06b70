"""The check's outlines as straight sides: what its transforms and its pictures take."""

from __future__ import annotations

import numpy as np

from camsim.rendering.check.far_arcs import far_apart
from camsim.rendering.check.polygon_kernels import count_sides, draw_sides
from camsim.rendering.check.scenery import Pieces, followed
from camsim.rendering.edges import Edges
from camsim.scene.arcs import Fineness

OF_ARCS = 0.05  # of what sides may be wrong by: what Bézier curves are followed to by arcs


def polygons(pieces: Pieces, fine: Fineness, *, textured: bool = False) -> Edges:
    """Return the pieces as straight edges: round ones as sides of the same area each, shorter than waves that pass or,
    far away, as long as may be.

    What stays of a circle's wobble is of second order: half its mean square, (s²/8R)²·4/45, times the slope of the line
    spread, at most 2π over a square wave.
    textured : edges of samples cut the sides anywhere. What is left of one then counts at once, its area, at most
               s³/(72·√3·R), times the pattern's peak, about 1/longest²; a tenth for each of those that lie near
    """
    pieces = followed(pieces, fine._replace(allowed=OF_ARCS * fine.allowed))
    o = pieces.outlines
    straight, bent = np.flatnonzero(o.turn_rad == 0.0), np.flatnonzero(o.turn_rad > 0.0)
    arcs, which = far_apart(np.stack([o.x, o.y, o.dx, o.from_rad, o.turn_rad], axis=1)[bent], fine)
    bent = bent[which]
    limits = fine.longest, fine.allowed, textured
    counts = np.empty(bent.size, np.int64)
    count_sides(arcs, limits, counts)
    sides = np.empty((int(counts.sum()), 4))
    draw_sides(arcs, limits, sides)
    begin = np.stack([o.x, o.y], axis=1)[straight]
    along = np.stack([o.dx, o.dy], axis=1)[straight]
    owner = np.concatenate([straight, np.repeat(bent, counts)])
    return Edges(
        start=np.concatenate([begin, sides[:, :2]]),
        end=np.concatenate([begin + along, sides[:, 2:]]),
        left=pieces.left[owner],
        right=pieces.right[owner],
    )
