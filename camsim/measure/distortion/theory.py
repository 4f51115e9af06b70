"""Expected positions of marks: the distortion of the lens, plus the centroid of its PSF at the mark.

Asymmetric photosites and crosstalk move this centroid too.

The image of a dot is taken as moved by that centroid; a fitted rim follows the peak of an asymmetric PSF slightly.
"""

from __future__ import annotations

from collections.abc import Sequence

from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.measure.distortion.marks import Marks
from camsim.measure.lens_places import fallen_um, middles_um


def expected_um(capture: Capture, marks: Marks, channels: Sequence[str]) -> dict[str, F64]:
    """Return the expected displacements (n, 2) of marks right and down, by channel.

    channels : channels of a picture; those that the camera lacks are omitted
    """
    fallen = fallen_um(capture.camera, marks.places_um)
    middles = middles_um(capture, fallen, marks.surfaces, channels)
    return {name: fallen - marks.places_um + middle for name, middle in middles.items()}
