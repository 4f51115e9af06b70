"""Conversion of a scene file's lengths from its unit to µm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias, TypeVar

from camsim.config import schema
from camsim.config.tree import KeyPath
from camsim.config.validated import Validated
from camsim.errors import CamsimError

T = TypeVar("T")

SceneDocument: TypeAlias = Validated[schema.SceneFile]

_NO_LENGTHS = {"arc": (3, 4, 5)}
"""Indices of a segment's numbers that are not lengths."""


def made(
    scene: SceneDocument,
    path: KeyPath,
    make: Callable[[float], T],
    unit_um: float,
    keys: Mapping[str, KeyPath],
) -> T | None:
    """Return what ``make(unit_um)`` makes of the part at ``path``; None when it is wrong (the document has the fault).

    make : makes the part from its lengths times a number
    keys : YAML keys of the parameters that messages may name
    """
    try:
        return make(unit_um)
    except CamsimError:
        # Messages must show the file's numbers: in its unit, not µm.
        in_its_unit = scene.build(path, lambda: make(1.0), keys=keys)
        return None if in_its_unit is None else scene.build(path, lambda: make(unit_um), keys=keys)


def scaled(value: Any, scale: float) -> Any:
    """Return a length, a point, or a list of these or of segments, times a number; other values unchanged."""
    if isinstance(value, list | tuple):
        if value and isinstance(value[0], str):
            bare = _NO_LENGTHS.get(value[0], ())
            return (value[0], *(v if k in bare else scaled(v, scale) for k, v in enumerate(value[1:], 1)))
        return tuple(scaled(part, scale) for part in value)
    return value * scale if isinstance(value, int | float) else value
