"""The scene's outlines as the check takes them: straight parts and whole circles, nothing clipped or cut."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64
from camsim.scene import Scene


class Outlines(NamedTuple):
    """Straight and round parts of outlines, all of a shape's side by side, insides to the left (cross product above 0).

    x, y, dx, dy : start and vector to the end of a straight part; of a round one its centre, and (radius, 0)
    from_rad, turn_rad : of a round part, the angle at which it begins and how far it goes; a turn of 0 is straight
    shape        : which shape it belongs to
    """

    x: F64
    y: F64
    dx: F64
    dy: F64
    from_rad: F64
    turn_rad: F64
    shape: I64


def outlines_of(scene: Scene, pitch_um: float) -> Outlines:
    """Return the outlines of all shapes, pitches; discs are circles."""
    rows: list[F64] = []
    for number, shape in enumerate(scene.shapes):
        if shape.circle_um is not None:
            x, y, radius = np.array(shape.circle_um) / pitch_um
            rows.append(np.array([[x, y, radius, 0.0, 0.0, math.tau, number]]))
            continue
        corners = np.asarray(shape.outline_um(math.inf), float) / pitch_um
        along = np.roll(corners, -1, axis=0) - corners
        from_first = corners - corners[0]
        if (
            np.sum(from_first[:, 0] * np.roll(from_first[:, 1], -1) - from_first[:, 1] * np.roll(from_first[:, 0], -1))
            < 0
        ):
            corners, along = corners + along, -along
        part = np.concatenate([corners, along, np.zeros((len(corners), 2))], axis=1)
        rows.append(np.column_stack([part, np.full(len(corners), number)])[np.any(along != 0.0, axis=1)])
    table = np.concatenate(rows) if rows else np.empty((0, 7))
    x, y, dx, dy, from_rad, turn_rad = (np.ascontiguousarray(column) for column in table.T[:6])
    return Outlines(x, y, dx, dy, from_rad, turn_rad, table[:, 6].astype(np.int64))
