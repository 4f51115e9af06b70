"""Lazy import of colour-science, without its side effects."""

from __future__ import annotations

import functools
import warnings
from types import ModuleType

import numpy as np


@functools.cache
def colour_science() -> ModuleType:
    """Import colour-science (about a second) and leave the process as it was.

    Its import warns about optional packages that camsim does not use, and switches numpy's printing to the
    format of 2017 for the whole process; both are undone here.
    """
    with np.printoptions(), np.errstate(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour

        # The data sets are loaded lazily, each with its warnings.
        for data in (colour.SDS_ILLUMINANTS, colour.SDS_COLOURCHECKERS, colour.MSDS_CAMERA_SENSITIVITIES):
            len(data)
    module: ModuleType = colour
    return module
