"""A lens that changes over the frame: what a place of the picture sees through, and where the scene's places fall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camsim.arrays import F64
from camsim.body import Body
from camsim.errors import UnsupportedError
from camsim.exposing import Capture
from camsim.optics import OpticalSystem
from camsim.optics.protocols import Varies

_PASSES = 50
_SETTLED_UM = 1e-6
_STAYS_PIXEL = 0.1


def system_at(camera: Body, x_um: float, y_um: float) -> OpticalSystem:
    """Return the stages that a photosite at a place of the sensor sees through."""
    system = camera.optics
    return replace(system, lens=system.lens.at(x_um, y_um)) if isinstance(system.lens, Varies) else system


def fallen_um(camera: Body, points_um: F64) -> F64:
    """Return where the distortion puts points (n, 2) of the scene."""
    lens = camera.lens
    return lens.distorted(points_um) if isinstance(lens, Varies) and lens.distorts else points_um


def scene_place_um(camera: Body, points_um: F64) -> F64:
    """Return the points (n, 2) of the scene that fall on places of the sensor: the distortion undone by iteration."""
    found = points_um
    for _ in range(_PASSES):
        off = fallen_um(camera, found) - points_um
        if not np.any(np.abs(off) > _SETTLED_UM):
            break
        found = found - off
    return found


def refuse_distortion(capture: Capture, stage: str, what: str) -> None:
    """Raise UnsupportedError where the lens moves what a picture shows away from the scene's places."""
    grid, pitch_um = capture.grid, capture.camera.pitch_um
    first = np.array(grid.first_centre) * pitch_um
    size = np.array([grid.cols - 1, grid.rows - 1]) * pitch_um
    corners = np.array([first + size * share for share in ((0, 0), (0, 1), (1, 0), (1, 1))])
    moved = float(np.hypot(*(fallen_um(capture.camera, corners) - corners).T).max()) / pitch_um
    if moved > _STAYS_PIXEL:
        raise UnsupportedError(
            f"the lens moves the scene by up to {moved:.3g} px here, and {what} measured where it stays in place; "
            "give the lens no distortion, or measure edges (camsim measure mtf)",
            stage=stage,
        )
