"""Painter's order resolved: what is visible, as edges with a spectrum on either side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene.outlines import Outlines
from camsim.scene.primitives import flattened
from camsim.scene.scene import Scene
from camsim.scene.sides import SideLimits
from camsim.scene.stretches import Apart
from camsim.scene.visible import Covers, visible_rings
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arrangement:
    """The visible regions' edges.

    start_um, end_um : (n, 2) x, y in µm
    left, right      : (n,) index into ``spectra`` of the side where cross(end − start, x − start) is above 0
                       (in a frame with y down that is the viewer's right), and of the other side
    spectra          : distinct reflectances; index 0 is the background
    sides            : (primitives,) of each shape's outlines, before one covers another
    hidden           : (primitives,) those that lie wholly under a single later one
    """

    start_um: F64
    end_um: F64
    left: I64
    right: I64
    spectra: tuple[Spectrum, ...]
    sides: I64
    hidden: np.ndarray

    @property
    def outline_edges(self) -> int:
        """Sides of all shapes."""
        return int(self.sides.sum())


def arrange(scene: Scene, limits: SideLimits | None = None, *, apart: Apart | None = None) -> Arrangement:
    """Cut away what later shapes cover, join regions of equal spectrum, and list the edges that remain.

    limits, apart : how finely curved outlines are cut into sides (``sides.polygons``)

    Every visible region contributes its outline against the background; where two regions share an edge
    exactly, the two become one edge with both spectra. Equal spectra on both sides leave no edge.

    >>> from camsim.scene import Rectangle
    >>> grey = Rectangle(width_um=2.0, height_um=2.0, reflectance=0.5)
    >>> len(arrange(Scene(background=1.0, shapes=[grey])).left)
    4
    >>> len(arrange(Scene(background=0.5, shapes=[grey])).left)
    0
    """
    spectra: dict[Spectrum, int] = {scene.background: 0}
    primitives = flattened(scene.shapes)
    regions = [spectra.setdefault(primitive.reflectance, len(spectra)) for primitive in primitives]
    outlines = Outlines.of(primitives)
    limits = limits or SideLimits()
    covers = Covers.of(primitives, outlines)
    rings = outlines.some(covers.seen).rings(limits, crossing=covers.crossing, apart=apart)
    starts: list[F64] = []
    ends: list[F64] = []
    lefts: list[I64] = []
    seen = [(primitives[i], regions[i]) for i in covers.seen.tolist()]
    for region, visible in visible_rings(seen, rings, covers):
        if region == 0:
            continue
        for ring in visible:
            starts.append(ring)
            ends.append(np.roll(ring, -1, axis=0))
            lefts.append(np.full(len(ring), region))
    hidden = np.ones(len(primitives), bool)
    hidden[covers.seen] = False
    sides = np.bincount(outlines.owner, minlength=len(primitives))
    sides[covers.seen] = [sum(map(len, own)) for own in rings]
    start, end = np.concatenate([np.empty((0, 2)), *starts]), np.concatenate([np.empty((0, 2)), *ends])
    left = np.concatenate([np.empty(0, np.int64), *lefts])
    # An edge whose squared length is no longer a number above 0 contributes nothing.
    keep = np.sum((end - start) ** 2, axis=1) > 0.0
    start, end, left, right = _merge_shared(start[keep], end[keep], left[keep])
    return Arrangement(
        start_um=start,
        end_um=end,
        left=left,
        right=right,
        spectra=tuple(spectra),
        sides=sides,
        hidden=hidden,
    )


def _merge_shared(start: F64, end: F64, left: I64) -> tuple[F64, F64, I64, I64]:
    """Make one edge of two that run along each other in opposite directions; drop it when both sides are equal."""
    right = np.zeros_like(left)
    flip = (end[:, 0] < start[:, 0]) | ((end[:, 0] == start[:, 0]) & (end[:, 1] < start[:, 1]))
    line = np.where(flip[:, None], np.hstack([end, start]), np.hstack([start, end]))
    _, group, counts = np.unique(line, axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    forth = np.full(len(counts), -1)
    back = np.full(len(counts), -1)
    forth[group[~flip]] = np.flatnonzero(~flip)
    back[group[flip]] = np.flatnonzero(flip)
    paired = (counts == 2) & (forth >= 0) & (back >= 0)
    right[forth[paired]] = left[back[paired]]
    keep = (~paired[group] | ~flip) & (left != right)
    return start[keep], end[keep], left[keep], right[keep]
