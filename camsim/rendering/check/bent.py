"""The check's outlines as a lens with distortion throws them: its own sides, cut more finely than the engine's."""

from __future__ import annotations

import dataclasses

import numpy as np

from camsim.rendering.bending import Bending
from camsim.rendering.check.polygons import polygons
from camsim.rendering.check.records import Outlines
from camsim.rendering.check.scenery import Pieces
from camsim.scene.arcs import Fineness

FINER = 0.25  # of what the engine's sides may be wrong by


def bent(pieces: Pieces, fine: Fineness, bending: Bending) -> Pieces:
    """Return pieces (pitches) as they fall on the sensor, all of them straight.

    fine : as the pieces were made
    """
    pitch_um = bending.grid.pitch_um
    edges = polygons(pieces, fine)
    own = dataclasses.replace(bending, allowed=FINER * bending.allowed)
    start, end, owner = own.sides(edges.start * pitch_um, edges.end * pitch_um)
    x, y = (start / pitch_um).T
    dx, dy = ((end - start) / pitch_um).T
    none = np.zeros(len(x))
    outlines = Outlines(x, y, dx, dy, none, none)
    return pieces._replace(
        outlines=outlines, left=edges.left[owner], right=edges.right[owner], bezier=np.full(len(x), -1)
    )
