"""Custom stages: their detection, and validation that files can describe them."""

from __future__ import annotations

import cmath
import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from camsim.core.words import displayed
from camsim.errors import InvalidValueError

_LARGEST_WHOLE = 2**64
_HELD = "finite numbers, truth values, texts, None, and tuples, tables by name or frozen dataclasses of these"


def is_custom(stage: object) -> bool:
    """Return whether a stage is user-defined rather than one of camsim's."""
    return stage is not None and type(stage).__module__.partition(".")[0] != "camsim"


def custom_stages(stages: Iterable[object]) -> tuple[str, ...]:
    """Return the class names of the custom stages among these."""
    return tuple(dict.fromkeys(type(stage).__name__ for stage in stages if is_custom(stage)))


def refused(key: str, message: str) -> InvalidValueError:
    """Return the error of a camera about a custom stage; ``key``: parameter of the camera."""
    return InvalidValueError(message, key=key, stage="Camera")


def check_described(stage: Any, key: str) -> None:
    """Refuse a stage that is mutable, or whose fields a record cannot represent."""
    name = type(stage).__name__
    if not dataclasses.is_dataclass(stage):
        raise refused(key, f"{name} is no dataclass; files describe a camera by the fields of its stages")
    kind: Any = type(stage)
    if not kind.__dataclass_params__.frozen:
        raise refused(key, f"{name} could change after files have described it; write @dataclass(frozen=True)")
    for place, value in _fields(stage, name):
        for where, part in _unheld(value, place):
            what = displayed(part) if not isinstance(part, np.ndarray) else f"{displayed(part)}, to be given as a tuple"
            raise refused(key, f"{where} is {what}; a record of the stage holds {_HELD}")


def _fields(stage: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a dataclass that are parameters or in its repr; derived fields are ignored."""
    for field in dataclasses.fields(stage):
        if field.init or field.repr:
            yield f"{name}.{field.name}", getattr(stage, field.name, None)


def _unheld(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    """Yield the parts of a value that a record cannot represent exactly, each with its place."""
    if value is None or isinstance(value, bool | np.bool_ | str):
        return
    if isinstance(value, int | np.integer):
        if abs(int(value)) >= _LARGEST_WHOLE:
            yield place, value
    elif isinstance(value, float | complex | np.floating | np.complexfloating):
        if not cmath.isfinite(value):
            yield place, value
    elif isinstance(value, tuple | list):
        for index, item in enumerate(value):
            yield from _unheld(item, f"{place}[{index}]")
    elif isinstance(value, Mapping):
        for name, item in value.items():
            yield from _unheld(item, f"{place}[{name!r}]") if isinstance(name, str) else iter([(place, value)])
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        # camsim's classes have validated their fields.
        for where, part in _fields(value, place) if is_custom(value) else ():
            yield from _unheld(part, where)
    else:
        yield place, value
