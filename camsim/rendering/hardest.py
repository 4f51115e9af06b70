"""Which photosites are worth checking: where each way of computing is at its limit. A pure function of the inputs."""

from __future__ import annotations

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.grid import Grid
from camsim.rendering.plan import Settings

FEWEST, MOST = 4, 256
MOST_EDGES = 256  # looked at for a hard tile; more are thinned out
SHARE_OF_TIME = 0.1


def how_many(photosites: int, *, render_seconds: float, check_seconds: float, fewest: int = FEWEST) -> int:
    """Return how many photosites are checked; seconds are those expected of the rendering, and of one check."""
    return min(photosites, MOST, max(fewest, int(SHARE_OF_TIME * render_seconds / check_seconds)))


def hardest_photosites(
    start: F64,
    end: F64,
    grid: Grid,
    settings: Settings,
    *,
    render_seconds: float,
    check_seconds: float,
    fewest: int = FEWEST,
) -> tuple[I64, I64]:
    """Return rows and columns of the photosites to check, at least ``fewest`` (all of a smaller grid), none twice.

    In turn: at a corner; just beyond the near radius from a corner, straight off the edge's end (where the far form
    omits most); across the middle of an edge, at the end of the edge response's table, beyond it, or close to the edge;
    a corner of a tile that is just far enough from a corner of the scene to be interpolated, or of the frame, far
    from everything. As many as a tenth of the predicted time pays for.

    render_seconds, check_seconds : expected of the rendering, and of the check of one photosite
    """
    photosites = grid.rows * grid.cols
    count = how_many(photosites, render_seconds=render_seconds, check_seconds=check_seconds, fewest=fewest)
    x0, y0 = grid.first_centre
    spots: dict[tuple[int, int], None] = {}
    for turn in range(2 * count):
        if len(spots) >= count:
            break
        for x, y in _hard_points(start, end, settings, grid, turn):
            spots[(_nearest(y - y0, grid.rows), _nearest(x - x0, grid.cols))] = None
    spread = max(1, photosites // (4 * count))
    for i in range(0, photosites, spread):
        if len(spots) >= count:
            break
        spots[(i // grid.cols, i % grid.cols)] = None
    chosen = np.array(list(spots)[:count])
    return chosen[:, 0], chosen[:, 1]


def _nearest(position: float, count: int) -> int:
    return int(min(max(round(position), 0), count - 1))


def _hard_points(start: F64, end: F64, settings: Settings, grid: Grid, turn: int) -> F64:
    """Return four points (4, 2), pitches; turns step through the edges by the golden ratio."""
    a, b = start[_edge(turn, len(start))], end[_edge(turn, len(start))]
    along = (b - a) / np.hypot(*(b - a))
    across = np.array([-along[1], along[0]]) * (1.0 if turn % 2 else -1.0)
    x0, y0 = grid.first_centre
    corner = None if turn % 4 else _tile_corner(start, end, settings, grid, turn)
    if corner is None:
        corner = np.array([x0 + (turn % 2) * (grid.cols - 1), y0 + (turn // 2 % 2) * (grid.rows - 1)])
    distance = (0.97 * settings.reach, 0.3, 1.03 * settings.reach, 0.5 * settings.reach)[turn % 4]
    beside = a + (0.45 + 0.09 * (turn % 5)) * (b - a) + distance * across
    points: F64 = np.stack([a, a + 1.02 * settings.near * across, beside, corner])
    return points


def _edge(turn: int, edges: int) -> int:
    return int((turn * 0.6180339887498949) % 1.0 * edges)


def _tile_corner(start: F64, end: F64, settings: Settings, grid: Grid, turn: int) -> F64 | None:
    """Return the photosite where interpolation over a tile has the hardest time, None if the frame has none.

    It lies in a tile that is just far enough from a corner of the scene, with part of the scene nearer than that:
    edges that meet in one corner and are interpolated together all but cancel, so it takes a tile that has some of
    them interpolated and some not.
    """
    size, half = settings.leaf, 0.5 * settings.leaf
    apart = max(settings.near, settings.separation * half)
    first, counts = np.array(grid.first_centre), np.array([grid.cols, grid.rows])
    ends = np.stack([start, end])[:, :: max(1, len(start) // MOST_EDGES)] - (first - 0.5)
    own = np.array([_edge(turn + k, ends.shape[1]) for k in range(16)])
    picked, along = ends[0, own], ends[1, own] - ends[0, own]
    tiles, corners = [], []
    for axis, side in ((0, 1), (0, -1), (1, 1), (1, -1)):
        low = np.floor(picked / size) * size
        beyond = np.ceil((side * picked[:, axis] + apart) / size) * size
        low[:, axis] = beyond if side > 0 else -beyond - size
        facing = low.copy()
        facing[:, axis] += 0 if side > 0 else size - 1
        tiles.append(low)
        corners.append(facing)
    low, corner = np.concatenate(tiles), np.concatenate(corners)
    own, along, picked = np.tile(own, 4), np.tile(along, (4, 1)), np.tile(picked, (4, 1))
    behind = np.sum((low + half - picked) * along, axis=1) < 0.0
    inside = np.all((corner >= 0) & (corner < counts), axis=1)
    low, corner, own, behind = low[inside], corner[inside], own[inside], behind[inside]
    beside = np.maximum(np.abs(ends - (low + half)[:, None, None]) - half, 0.0)
    is_far = np.hypot(beside[..., 0], beside[..., 1]).min(axis=1, initial=np.inf) >= apart
    mixed = is_far.any(axis=1) & ~is_far.all(axis=1)
    if not mixed.any():
        return None
    surely = mixed & behind & is_far[np.arange(own.size), own]
    place: F64 = first + corner[np.argmax(surely if surely.any() else mixed)]
    return place
