"""The window of a bench: the one with most outline in it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from camsim.camera.window import Region
from camsim.core.arrays import F64, distinct
from camsim.rendering import Grid
from camsim.rendering.edges import shares_within
from camsim.scene import Scene, flattened
from camsim.scene.outlines import Outlines
from camsim.scene.side_limits import SideLimits

SIDE = 128  # photosites: one or two seconds for every engine at its finest
STEPS = 4  # trial positions of the window per side length
MOST_POINTS = 200_000  # along all outlines: enough to compare windows


def busiest(scene: Scene, grid: Grid, side: int = SIDE) -> Region:
    """Return a window of at most ``side`` photosites a side with the longest outlines, the nearest to the middle.

    Hidden outlines count too: the window only decides where to measure.
    """
    rows, cols = min(side, grid.rows), min(side, grid.cols)
    places = along_outlines(scene, grid)
    row_starts, col_starts = _starts(grid.rows, rows), _starts(grid.cols, cols)
    found = np.zeros((row_starts.size, col_starts.size))
    for i, first in enumerate(row_starts):
        within = places[(places[:, 0] >= first) & (places[:, 0] < first + rows), 1]
        ordered = np.sort(within)
        found[i] = np.searchsorted(ordered, col_starts + cols) - np.searchsorted(ordered, col_starts)
    off = np.hypot(
        row_starts[:, None] + 0.5 * (rows - grid.rows),
        col_starts[None, :] + 0.5 * (cols - grid.cols),
    )
    # A few points more are no reason to look elsewhere than in the middle.
    good = found >= 0.95 * found.max()
    row, col = np.unravel_index(int(np.argmin(np.where(good, off, np.inf))), off.shape)
    origin = grid.origin[0] + int(row_starts[row]), grid.origin[1] + int(col_starts[col])
    return Region(rows=rows, cols=cols, origin=origin)


def along_outlines(scene: Scene, grid: Grid) -> F64:
    """Return points (n, 2), row and col of the grid, spread evenly along the outlines within it."""
    primitives = flattened(scene.shapes)
    rings = Outlines.of(primitives).rings(SideLimits(64.0 * grid.pitch_um))
    outlines = [ring / grid.pitch_um for one in rings for ring in one]
    if not outlines:
        return np.empty((0, 2))
    starts = np.concatenate(outlines)
    ends = np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines])
    x0, y0 = grid.first_centre
    starts, ends = (points - np.array([x0 - 0.5, y0 - 0.5]) for points in (starts, ends))
    enters, leaves = shares_within(starts, ends, np.zeros(2), np.array([grid.cols, grid.rows], float))
    seen = enters < leaves
    starts, along = starts[seen], (ends - starts)[seen]
    starts, ends = starts + enters[seen, None] * along, starts + leaves[seen, None] * along
    lengths = np.hypot(*(ends - starts).T)
    if not lengths.sum() > 0.0:
        return np.empty((0, 2))
    step = max(1.0, float(lengths.sum()) / MOST_POINTS)
    # One point for every step along all of them, laid end to end.
    passed = np.concatenate([[0.0], np.cumsum(lengths)])
    at = np.arange(0.5 * step, passed[-1], step)
    edge = np.minimum(np.searchsorted(passed, at, side="right") - 1, lengths.size - 1)
    share = ((at - passed[edge]) / np.where(lengths[edge] > 0.0, lengths[edge], 1.0))[:, None]
    points: F64 = (starts[edge] + share * (ends[edge] - starts[edge]))[:, ::-1]
    return points


def _starts(count: int, side: int) -> F64:
    """Return first rows or columns of windows, the last of which ends with the frame, and the one in the middle."""
    steps: Iterable[int] = (*range(0, count - side + 1, max(1, side // STEPS)), (count - side) // 2, count - side)
    return distinct(np.array(list(steps), float))
