"""Where marks should be seen: the lens's distortion, and the middle of the light of its pattern there.

Lopsided photosites and crosstalk move that middle too.

The image of a dot is taken as moved by that middle; a fitted rim follows the peak of a lopsided pattern a little more.
"""

from __future__ import annotations

from collections.abc import Sequence

from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.measure.distortion.marks import Marks
from camsim.measure.lens_places import fallen_um, middles_um


def expected_um(capture: Capture, marks: Marks, channels: Sequence[str]) -> dict[str, F64]:
    """Return by how much (n, 2) channels should see marks farther to the right and farther down.

    channels : a picture's; those that the camera does not have are missing
    """
    fallen = fallen_um(capture.camera, marks.places_um)
    middles = middles_um(capture, fallen, marks.surfaces, channels)
    return {name: fallen - marks.places_um + middle for name, middle in middles.items()}
