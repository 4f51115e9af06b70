"""What the functions of measuring are given, judged in words that say where to get one."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from camsim.errors import UnsupportedError
from camsim.exposing import Capture
from camsim.frame import Frame
from camsim.marks import Called
from camsim.measure.picture import Picture
from camsim.typed import check

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
    """Refuse what is not of the kind that its name says.

    >>> check_given(capture="slanted-edge")
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: capture: must be a Capture, not 'slanted-edge'; camsim.load of a scene gives one
    """
    for name, value in given.items():
        check(value, _KINDS[name], name)


def check_size(picture: Picture, capture: Capture) -> None:
    """Refuse a picture of another size than the capture that it is said to be of: nothing would lie where it says."""
    size = capture.grid.rows, capture.grid.cols
    if picture.shape != size:
        raise UnsupportedError(
            f"{picture.shape[0]} × {picture.shape[1]} photosites, and what it says of itself has {size[0]} × {size[1]}",
            stage=picture.name,
        )
