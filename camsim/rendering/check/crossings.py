"""Where outlines lie in front of pictures and gradients: there photosites are checked, because two roads meet there."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.quadrature import GOLDEN
from camsim.rendering.check.polygons import polygons
from camsim.rendering.check.scenery import pieces_of
from camsim.rendering.grid import Grid
from camsim.scene import Picture, Scene
from camsim.scene.arcs import Fineness
from camsim.scene.raster import Field
from camsim.spectra.curve import Curve

BESIDE = 0.4  # pitches: outlines so far beyond the outermost photosites are in the frame
PER_SAMPLE, MOST = 4, 4096  # places looked at along outlines
HARD = 0.1  # of them, after the hardest one


class Bounds(NamedTuple):
    """Segments (n, 2) about what is seen of a field, pitches, in any order; which are outlines in front of it."""

    start: F64
    end: F64
    in_front: np.ndarray


def bounds_of(scene: Scene, number: int, pitch_um: float, fine: Fineness) -> Bounds | None:
    """Return what bounds what is seen of a field, by the painter's rule; None for all of a picture."""
    field, later = scene.shapes[number], scene.shapes[number + 1 :]
    if not later and isinstance(field, Picture):
        return None
    assert isinstance(field, Field)
    # Two colours that nothing else has.
    own, beyond = (
        Curve((400.0, 700.0), ends, name="the picture", outside="hold") for ends in ((0.25, 0.75), (0.75, 0.25))
    )
    covered = Scene(background=beyond, shapes=[field.frame(own), *later]).framed(0.5)
    pieces, spectra = pieces_of(covered, pitch_um)
    edges = polygons(pieces, fine, textured=isinstance(field, Picture))
    which = spectra.index(own)
    mine = (edges.left == which) | (edges.right == which)
    other = np.where(edges.left == which, edges.right, edges.left)[mine]
    return Bounds(edges.start[mine], edges.end[mine], other != 0)


def crossed(fields: Iterable[tuple[Field, Bounds | None]], grid: Grid, count: int) -> F64:
    """Return up to ``count`` places (n, 2) of the frame where outlines lie in front of fields.

    First where neighbouring samples differ most, then others of those where they differ much: an outline that is not
    where it should be is seen by what changes along it.
    """
    places, contrasts = [np.empty((0, 2))], [np.empty(0)]
    for field, bounds in fields:
        if bounds is not None:
            along = _along(bounds, grid, field.step_um / grid.pitch_um if isinstance(field, Picture) else 1.0)
            places.append(along)
            contrasts.append(
                _contrast(field, along * grid.pitch_um) if isinstance(field, Picture) else np.ones(len(along))
            )
    order = np.argsort(-np.concatenate(contrasts), kind="stable")
    if not order.size:
        return places[0]
    ranks = (np.arange(count) * GOLDEN % 1.0 * max(1.0, HARD * order.size)).astype(int)
    found: F64 = np.concatenate(places)[order[np.minimum(ranks, order.size - 1)]]
    return found


def _along(bounds: Bounds, grid: Grid, step: float) -> F64:
    """Return places evenly along outlines in front of a field, in the frame."""
    low = np.array(grid.first_centre) - BESIDE
    high = low + 2.0 * BESIDE + np.array([grid.cols - 1.0, grid.rows - 1.0])
    start, end = _within(bounds.start[bounds.in_front], bounds.end[bounds.in_front], low, high)
    length = np.hypot(*(end - start).T)
    total = float(length.sum())
    if total == 0.0:
        return np.empty((0, 2))
    many = int(min(max(PER_SAMPLE * total / step, PER_SAMPLE), MOST))
    at = (np.arange(many) + 0.5) / many * total
    ends = np.cumsum(length)
    own = np.minimum(np.searchsorted(ends, at), length.size - 1)
    share = (at - ends[own] + length[own]) / length[own]
    places: F64 = start[own] + share[:, None] * (end - start)[own]
    return places


def _contrast(picture: Picture, places_um: F64) -> F64:
    """Return by how much the four samples about places differ; beyond the picture there is nothing."""
    rows, cols = picture.shape
    u, v = np.einsum("nx,ax->an", places_um - np.array(picture.centre_um), picture.axes) / picture.step_um
    left, top = np.floor(u + 0.5 * cols - 0.5).astype(int), np.floor(v + 0.5 * rows - 0.5).astype(int)
    about = []
    for row, col in ((top, left), (top, left + 1), (top + 1, left), (top + 1, left + 1)):
        there = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        samples = picture.planes[:, np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)]
        about.append(np.where(there, samples, 0.0))
    spread: F64 = np.ptp(np.stack(about), axis=0).sum(axis=0)
    return spread


def _within(start: F64, end: F64, low: F64, high: F64) -> tuple[F64, F64]:
    """Return what of segments lies in a box."""
    way = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - start) / way, (high - start) / way
    enter = np.fmax(0.0, np.fmin(a, b).max(axis=1))
    leave = np.fmin(1.0, np.fmax(a, b).min(axis=1))
    some = enter < leave
    start, way = start[some], way[some]
    return start + enter[some, None] * way, start + leave[some, None] * way
