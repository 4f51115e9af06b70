"""The edge as each method draws it, and by how much it is wrong: the panels of the paper's figures 13 and 14."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bench.paper.cases import IMPORTANCE, TURN_DEG, Psf, Setting, edge_distance_px
from bench.results import Results
from camsim.core.arrays import F64

PANELS = {"gaussian-0.25": "13", "airy-f8": "14"}
METHODS = ("uniform-pixel", "uniform", "importance", "strips", "auto")
TOLERANCE = 1e-6
HALF_WIDTH_PX, CORNER_ROWS, POINTS = 8.0, 20, 201


def add_panel(results: Results, psf: Psf, setting: Setting, images: Sequence[F64], truths: F64, shifts: F64) -> None:
    """Write an edge spread function: distance from the edge, value and error at about 200 photosites of all shifts.

    Rows near the corner are left out: there the edge is not what distance alone says.
    """
    if setting.tolerance not in (None, TOLERANCE) or setting.samples not in (None, *IMPORTANCE[:2]):
        return
    turn = math.radians(TURN_DEG)
    moved = shifts @ np.array([math.cos(turn), math.sin(turn)])
    distance = np.concatenate([(edge_distance_px() - m)[CORNER_ROWS:].ravel() for m in moved])
    value = np.concatenate([image[CORNER_ROWS:].ravel() for image in images])
    error = value - np.concatenate([truth[CORNER_ROWS:].ravel() for truth in truths])
    near = np.flatnonzero(np.abs(distance) <= HALF_WIDTH_PX)
    order = near[np.argsort(distance[near])]
    some = order[np.round(np.linspace(0, order.size - 1, min(POINTS, order.size))).astype(int)]
    results.add(
        "esf",
        psf=psf.name,
        figure=PANELS[psf.name],
        method=setting.method,
        label=setting.label,
        distance_px=distance[some],
        value=value[some],
        error=error[some],
    )
