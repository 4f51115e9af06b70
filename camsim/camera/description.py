"""What was computed, as a plain tree: every stage by its class name and parameters, nothing about when or where."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np


def describe(value: Any) -> Any:
    """Return stages, tuples and numbers as dicts, lists and scalars that JSON can hold.

    >>> from camsim.optics import SquarePhotosite
    >>> describe(SquarePhotosite(side_um=3.66))
    {'kind': 'SquarePhotosite', 'side_um': 3.66}
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value) if f.repr}
        # A field that few ever use is told where it is used: files without it keep their bytes.
        usual = {f.name: f.default for f in dataclasses.fields(value) if f.metadata.get("described") == "if any"}
        stated = {name: describe(part) for name, part in fields.items() if name not in usual or part != usual[name]}
        return {"kind": type(value).__name__, **stated}
    if isinstance(value, Mapping):
        return {str(k): describe(v) for k, v in value.items()}
    if isinstance(value, (tuple, list)):
        return [describe(v) for v in value]
    if isinstance(value, np.generic):
        return describe(value.item())
    if isinstance(value, np.ndarray):
        return describe(value.tolist())
    if isinstance(value, complex):
        return describe((value.real, value.imag) if value.imag else value.real)
    if isinstance(value, float) and value.is_integer():
        return int(value)  # 5000 and 5000.0 are the same light, whichever way it was written
    if value is None or isinstance(value, bool | int | float | str):
        return value
    # What a stage of one's own may hold besides numbers: a function, say.
    return getattr(value, "__qualname__", type(value).__qualname__)


CUSTOM_STAGES = "not_reproducible_by_camsim_alone"
"""Where a description names the stages of one's own that a capture was taken with."""

OF_A_FRAME = (
    *("camera", "scene", "light", "exposure", "region", "seed", "frame_number"),
    *("tolerance", "method", "noise", "colour_matrix", "spectral_nm"),
)
"""What a frame is made of: fields of the capture."""
