"""Orientation of a photograph (tag Orientation of EXIF and TIFF)."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from camsim.files.exif import in_exif
from camsim.files.tiff_reader import Directory

_ORIENTATION = 274


def orientation_in_exif(exif: bytes) -> int:
    """Return the orientation in a block of EXIF, which is a TIFF without an image; 1 if none can be read.

    >>> orientation_in_exif(b"MM\\0*" + bytes([0, 0, 0, 8, 0, 1, 1, 18, 0, 3, 0, 0, 0, 1, 0, 6, *bytes(6)]))
    6
    """
    return in_exif(exif, orientation_in, 1)


def orientation_in(directory: Directory) -> int:
    """Return the orientation in a directory, 1 to 8 (TIFF 6.0, section 8); 1 for none or invalid."""
    noted = directory.numbers(_ORIENTATION)
    return noted[0] if len(noted) == 1 and 1 <= noted[0] <= 8 else 1


def upright(image: npt.NDArray[Any], orientation: int) -> npt.NDArray[Any]:
    """Return the upright image, a view of the stored one.

    >>> import numpy as np
    >>> upright(np.array([[1, 2, 3]]), 8).tolist()
    [[3], [2], [1]]
    """
    seen = image.swapaxes(0, 1) if orientation >= 5 else image
    return seen[:: -1 if orientation in (3, 4, 7, 8) else 1, :: -1 if orientation in (2, 3, 6, 7) else 1]
