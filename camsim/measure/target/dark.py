"""Dark charge in the picture of a chart."""

from __future__ import annotations

from camsim.camera.capture import Capture
from camsim.measure.picture import Plane


def dark_e(plane: Plane, capture: Capture) -> float:
    """Return the dark charge that a plane's samples contain: its mean over all photosites, electrons."""
    return capture.dark_e if plane.holds_dark else 0.0


def dark_signal(plane: Plane, capture: Capture) -> float:
    """Return the dark charge in the plane's own unit: codes if it has a white level, else electrons."""
    per_unit = 1.0 if plane.white is None else capture.camera.converter.electrons_per_dn_at(capture.exposure.iso)
    return dark_e(plane, capture) / per_unit
