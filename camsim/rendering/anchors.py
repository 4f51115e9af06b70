"""Additional corners near the frame for long sides, whose far ends are affected by rounding.

Coordinates of a side's ends relative to a photosite are rounded to a part in 2⁵² of their distance, which displaces the
line between them by as much. Corners near the frame, placed on the line in extended precision, avoid this.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from camsim.core.arrays import F64
from camsim.rendering.grid import Grid
from camsim.scene import Arrangement

MOVED = 1e-3  # largest displacement of a line in pitches, over the tolerance; its effect is at most 1/λN times that
BESIDE = 4.0  # half diagonals of the window (plus a pitch) up to which a side counts as near
AFTER = 2.0  # distance of the corners from the middle, over that


def anchored(arrangement: Arrangement, grid: Grid, tolerance: float) -> Arrangement:
    """Return the same outlines, with corners near the window in sides that rounding of far ends would displace."""
    pitch_um = grid.pitch_um
    size = np.array([grid.cols - 1, grid.rows - 1])
    middle = (np.array(grid.first_centre) + 0.5 * size) * pitch_um
    near = BESIDE * (0.5 * float(np.hypot(*size)) + 1.0) * pitch_um
    most = MOVED * tolerance * pitch_um / float(np.finfo(float).eps)
    ends = np.maximum(
        *(np.abs(end - middle).max(axis=1, initial=0.0) for end in (arrangement.start_um, arrangement.end_um))
    )
    far = np.flatnonzero(ends > max(most, 2.0 * AFTER * near))
    if not far.size:
        return arrangement
    # The point nearest to the middle: a difference that cancels, in extended precision.
    start, along = arrangement.start_um[far].astype(np.longdouble), arrangement.end_um[far].astype(np.longdouble)
    along -= start
    length = np.hypot(along[:, 0], along[:, 1])
    along /= length[:, None]
    at = np.clip(((middle - start) * along).sum(axis=1), 0.0, length)
    foot = start + at[:, None] * along
    close = np.hypot(*(foot - middle).astype(float).T) <= near
    corners = np.stack([(foot + way * AFTER * near * along).astype(float) for way in (-1.0, 1.0)])
    within = np.stack([close & (at > AFTER * near), close & (at < length - AFTER * near)])
    count = np.zeros((2, len(arrangement.left)), np.int64)
    count[:, far] = within
    times = 1 + count.sum(axis=0)
    first = np.cumsum(times) - times
    start_um: F64 = np.repeat(arrangement.start_um, times, axis=0)
    end_um: F64 = np.repeat(arrangement.end_um, times, axis=0)
    for k, (one, corner) in enumerate(zip(within, corners, strict=True)):
        # The corner before the middle ends a side's first part, the one after it its last but one.
        ended = first[far[one]] + (k * count[0, far[one]])
        end_um[ended] = start_um[ended + 1] = corner[one]
    return dataclasses.replace(
        arrangement,
        start_um=start_um,
        end_um=end_um,
        left=np.repeat(arrangement.left, times),
        right=np.repeat(arrangement.right, times),
    )
