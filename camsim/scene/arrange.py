"""Painter's order resolved: the visible regions, as edges with a spectrum on either side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64, picked, same_rows
from camsim.scene.outlines import Outlines
from camsim.scene.primitives import Primitive, flattened, numbered
from camsim.scene.rims import Discs, Rims, rims_of, sides_of
from camsim.scene.scene import Scene
from camsim.scene.side_limits import SideLimits
from camsim.scene.sides import Polygons
from camsim.scene.visible import Covers, visible_rings
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arrangement:
    """The visible regions' edges.

    start_um, end_um : (n, 2) x, y of the edges' ends, µm
    left, right      : (n,) index into ``spectra`` of the side where cross(end − start, x − start) is above 0
                       (in a frame with y down that is the viewer's right), and of the other side
    spectra          : distinct reflectances; index 0 is the background
    sides            : (primitives,) number of sides of each shape's outlines, before one covers another
    hidden           : (primitives,) mask of those that a single later one covers fully
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
        """Number of sides of all shapes."""
        return int(self.sides.sum())


def arrange(
    scene: Scene, limits: SideLimits | None = None, *, primitives: list[Primitive] | None = None
) -> Arrangement:
    """Remove covered parts, join regions of equal spectrum, and list the remaining edges.

    limits     : resolution of curved outlines as sides (``sides.polygons``)
    primitives : those of the scene, if already computed

    Every visible region contributes its outline against the background; where two regions share an edge
    exactly, the two become one edge with both spectra. Equal spectra on both sides leave no edge.

    >>> from camsim.scene import Rectangle
    >>> grey = Rectangle(width_um=2.0, height_um=2.0, reflectance=0.5)
    >>> len(arrange(Scene(background=1.0, shapes=[grey])).left)
    4
    >>> len(arrange(Scene(background=0.5, shapes=[grey])).left)
    0
    """
    primitives = flattened(scene.shapes) if primitives is None else primitives
    spectra, surfaces = numbered([scene.background, *(one.reflectance for one in primitives)])
    regions = surfaces[1:]
    outlines = Outlines.of(primitives)
    limits = limits or SideLimits()
    covers = Covers.of(primitives, outlines)
    round_ones = picked(Discs.of(outlines), covers.seen)
    sides = np.bincount(outlines.owner, minlength=len(primitives))
    discs = round_ones.among_discs(covers.first, covers.second) & ~covers.alone & (not limits.textured)
    drawn = _NOTHING
    if discs.any():
        number = np.cumsum(discs) - 1
        pairs = discs[covers.first]
        rims = rims_of(
            round_ones.centre_um[discs],
            round_ones.radius_um[discs],
            regions[covers.seen[discs]],
            (number[covers.first[pairs]], number[covers.second[pairs]]),
        )
        drawn = _rims_drawn(rims._replace(disc=covers.seen[discs][rims.disc]), outlines, limits)
    others = covers.some(~discs)
    polygonal = outlines.some(others.seen)
    polygons = polygonal.polygons(limits, meets=~others.alone)
    alone = _alone_drawn(polygonal, polygons, regions[others.seen], others.alone)
    meeting = np.flatnonzero(~others.alone)
    cut = _rings_drawn(
        [(primitives[i], int(regions[i])) for i in others.seen[meeting].tolist()],
        polygonal.each(polygons, meeting),
        others.some(~others.alone),
    )
    hidden = np.ones(len(primitives), bool)
    hidden[covers.seen] = False
    sides[covers.seen[discs]] = np.bincount(drawn.owner, minlength=len(primitives))[covers.seen[discs]]
    sides[others.seen] = np.bincount(polygonal.loop_of, np.diff(polygons.first), len(others.seen))
    rims_um = (drawn.start, drawn.end, regions[drawn.owner], drawn.right)
    start, end, left, right = (np.concatenate(parts) for parts in zip(alone, cut, rims_um, strict=True))
    long = np.sum((end - start) ** 2, axis=1) > 0.0  # without underflow
    edges = {"start_um": start[long], "end_um": end[long], "left": left[long], "right": right[long]}
    return Arrangement(**edges, spectra=spectra, sides=sides, hidden=hidden)


class _Drawn(NamedTuple):
    """Sides of discs: owner (n,), end points, and the region beyond."""

    owner: I64
    start: F64
    end: F64
    right: I64


_NOTHING = _Drawn(np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2)), np.empty(0, np.int64))


def _rims_drawn(rims: Rims, outlines: Outlines, limits: SideLimits) -> _Drawn:
    """Return the sides of visible parts of rims; ``rims.disc`` indexes primitives."""
    whole = picked(rims, rims.whole)
    order = np.argsort(whole.disc, kind="stable")
    closed_ones = outlines.some(whole.disc[order]).polygons(limits)
    closed = np.repeat(order, np.diff(closed_ones.first))
    starts, ends = closed_ones.sides_um(np.ones(len(order), bool))
    arcs = picked(rims, ~rims.whole)
    owner, start, end = sides_of(arcs, limits)
    drawn = _Drawn(
        np.concatenate([whole.disc[closed], arcs.disc[owner]]),
        np.concatenate([starts, start]),
        np.concatenate([ends, end]),
        np.concatenate([whole.behind[closed], arcs.behind[owner]]),
    )
    return picked(drawn, np.any(drawn.start != drawn.end, axis=1))


def _alone_drawn(outlines: Outlines, polygons: Polygons, regions: I64, alone: np.ndarray) -> tuple[F64, F64, I64, I64]:
    """Return the edges of simple polygons that touch no other shape."""
    loops = (alone & (regions != 0))[outlines.loop_of]
    owner, item = outlines.loop_of[loops], polygons.some(loops)
    start, end = item.sides_um(np.append(True, owner[1:] != owner[:-1])[: len(owner)])
    left = np.repeat(regions[owner], np.diff(item.first))
    return start, end, left, np.zeros_like(left)


def _rings_drawn(
    seen: list[tuple[Primitive, int]], rings: list[list[F64]], covers: Covers
) -> tuple[F64, F64, I64, I64]:
    """Return the edges of visible parts of polygons that touch others."""
    visible = [(region, ring) for region, some in visible_rings(seen, rings, covers) if region for ring in some]
    start = np.concatenate([_NOTHING.start, *(ring for _, ring in visible)])
    end = np.concatenate([_NOTHING.end, *(np.roll(ring, -1, axis=0) for _, ring in visible)])
    left = np.concatenate([_NOTHING.owner, *(np.full(len(ring), region) for region, ring in visible)])
    return _merge_shared(start, end, left)


def _merge_shared(start: F64, end: F64, left: I64) -> tuple[F64, F64, I64, I64]:
    """Merge coincident edges of opposite directions into one; drop it if both sides are equal."""
    right = np.zeros_like(left)
    flip = (end[:, 0] < start[:, 0]) | ((end[:, 0] == start[:, 0]) & (end[:, 1] < start[:, 1]))
    line = np.where(flip[:, None], np.hstack([end, start]), np.hstack([start, end]))
    _, group = same_rows(line + 0.0)
    counts = np.bincount(group)
    forth = np.full(len(counts), -1)
    back = np.full(len(counts), -1)
    forth[group[~flip]] = np.flatnonzero(~flip)
    back[group[flip]] = np.flatnonzero(flip)
    paired = (counts == 2) & (forth >= 0) & (back >= 0)
    right[forth[paired]] = left[back[paired]]
    keep = (~paired[group] | ~flip) & (left != right)
    return start[keep], end[keep], left[keep], right[keep]
