"""Which photosites are worth checking: where each way of computing is at its limit. A pure function of the inputs."""

from __future__ import annotations

import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.grid import Grid
from camsim.rendering.plan import Settings
from camsim.rendering.spotcheck import Check

FEWEST, MOST = 4, 256
SHARE_OF_TIME = 0.1


def predict_seconds(edges: int, photosites: int, settings: Settings, lambda_n: F64, tables: int) -> float:
    """Predict a rendering's wall time on two cores (a model fitted once: no clock enters)."""
    near_nodes = settings.near / settings.panel * settings.panel_nodes
    table_size = (settings.near / settings.field_step) ** 2
    return (
        2e-3
        + photosites * 6e-9
        + edges * min(np.pi * settings.near**2, photosites) * 0.5 * near_nodes * 40e-9 / 2.0
        + tables * table_size * (60e-9 + 4e-9 * lambda_n.size / settings.near)
    )


def hardest_photosites(
    start: F64, end: F64, grid: Grid, settings: Settings, check: Check, lambda_n: F64, tables: int
) -> tuple[I64, I64]:
    """Return rows and columns of the photosites to check, at least four (all of a smaller grid), none twice.

    In turn: at a corner; just beyond the near radius from a corner, straight off the edge's end (where the far form
    omits most); across the middle of an edge, at the end of the edge response's table, beyond it, or close to the edge;
    a corner of the frame, far from everything. As many as a tenth of the predicted time pays for.
    """
    photosites = grid.rows * grid.cols
    budget = SHARE_OF_TIME * predict_seconds(len(start), photosites, settings, lambda_n, tables)
    count = min(photosites, MOST, max(FEWEST, int(budget / check.seconds(lambda_n, 2.0, len(start)))))
    x0, y0 = grid.first_centre
    spots: dict[tuple[int, int], None] = {}
    for turn in range(2 * count):
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
    edge = int((turn * 0.6180339887498949) % 1.0 * len(start))
    a, b = start[edge], end[edge]
    along = (b - a) / np.hypot(*(b - a))
    across = np.array([-along[1], along[0]]) * (1.0 if turn % 2 else -1.0)
    x0, y0 = grid.first_centre
    corner = np.array([x0 + (turn % 2) * (grid.cols - 1), y0 + (turn // 2 % 2) * (grid.rows - 1)])
    distance = (0.97 * settings.reach, 0.3, 1.03 * settings.reach, 0.5 * settings.reach)[turn % 4]
    beside = a + (0.45 + 0.09 * (turn % 5)) * (b - a) + distance * across
    points: F64 = np.stack([a, a + 1.02 * settings.near * across, beside, corner])
    return points
