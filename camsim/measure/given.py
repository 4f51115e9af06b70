"""Checks of the arguments of measurements; messages say how to obtain the right ones."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from camsim.camera.capture import Capture
from camsim.camera.frame import Frame
from camsim.core.annotations import Called
from camsim.core.typed import check
from camsim.errors import UnsupportedError
from camsim.measure.picture import Picture

_ARRAY = Annotated[np.ndarray, Called("an array")]
_KINDS = {
    "picture": Annotated[Picture, Called("a Picture", "read_picture of a file or picture_of_frame of a Frame is one")],
    "capture": Annotated[Capture, Called("a Capture", "camsim.load of a scene gives one")],
    "frame": Annotated[Frame, Called("a Frame", "camsim.capture of a scene gives one")],
    "electrons": _ARRAY,
    "found": _ARRAY,
    "truth_e": _ARRAY,
}


def check_given(**given: Any) -> None:
    """Raise for arguments of the wrong type, and for a picture whose size differs from its capture's.

    >>> check_given(capture="slanted-edge")
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: capture: must be a Capture, not 'slanted-edge'; camsim.load of a scene \
gives one
    """
    for name, value in given.items():
        check(value, _KINDS[name], name)
    if {"picture", "capture"} <= given.keys():
        picture, grid = given["picture"], given["capture"].grid
        if picture.shape != (grid.rows, grid.cols):
            raise UnsupportedError(
                f"it has {picture.shape[0]} × {picture.shape[1]} photosites and its capture {grid.rows} × {grid.cols}",
                stage=picture.name,
            )
