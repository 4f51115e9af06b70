"""Description of a computation as a plain tree: each stage by class name and parameters, no time or place."""

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
        # A rarely used field is written only when set, so that files without it stay byte-identical.
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
        return int(value)  # 5000 and 5000.0 describe the same light
    if value is None or isinstance(value, bool | int | float | str):
        return value
    # A custom stage may hold values other than numbers, such as a function.
    return getattr(value, "__qualname__", type(value).__qualname__)


CUSTOM_STAGES = "not_reproducible_by_camsim_alone"
"""Key under which a description lists the custom stages of a capture."""

OF_A_FRAME = (
    *("camera", "scene", "light", "exposure", "region", "seed", "frame_number"),
    *("tolerance", "method", "noise", "colour_matrix", "spectral_nm"),
)
"""Fields of the capture that determine a frame."""
