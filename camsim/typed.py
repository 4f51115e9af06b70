"""A value from a file judged by the type that a parameter declares: what does not fit is never passed on."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Union, get_args, get_origin

from camsim.errors import InputError

_LARGEST_WHOLE = 2**64
_LARGEST = 1e15
"""No light, length, time or count is more; products of such numbers are far from overflow."""

_LONGEST_TEXT = 100_000
_SIMPLE = {float: "a number", int: "a whole number", bool: "true or false", str: "a text", types.NoneType: "nothing"}


def judged(value: Any, kind: Any, place: str) -> Any:
    """Return a value as a parameter of type ``kind`` takes it; lists become tuples, whole numbers floats.

    kind  : float, int, bool, str, None, Literal, unions, tuples, sequences, mappings of these; or a class or protocol,
            of which the value must then be
    place : which parameter, for the message

    Raises InputError.

    >>> judged([1, 2.5], tuple[float, ...], "values")
    (1.0, 2.5)
    >>> judged(True, float, "camera.pitch_um")
    Traceback (most recent call last):
        ...
    camsim.errors.InputError: camera.pitch_um: must be a number, not True
    """
    origin = get_origin(kind)
    if kind is Any:
        return value
    if origin is Union or origin is types.UnionType:
        fitting = [member for member in get_args(kind) if _may_be(value, member)]
        if fitting:
            return judged(value, fitting[0], place)
    if not _may_be(value, kind):
        raise InputError(f"must be {words(kind)}, not {_shown(value)}", stage=place)
    if kind is float:
        return _number(value, place)
    if (kind is int and abs(value) >= _LARGEST_WHOLE) or (kind is str and len(value) > _LONGEST_TEXT):
        raise InputError(f"{_shown(value)} is longer than anything that camsim writes", stage=place)
    if origin is tuple and get_args(kind)[-1:] != (...,):
        return tuple(judged(v, k, f"{place}.{i}") for i, (v, k) in enumerate(zip(value, get_args(kind), strict=True)))
    if origin in (tuple, Sequence):
        if get_args(kind)[0] is float and all(type(v) is float and abs(v) <= _LARGEST for v in value):
            return tuple(value)  # long tables
        return tuple(judged(v, get_args(kind)[0], f"{place}.{i}") for i, v in enumerate(value))
    if origin is Mapping:
        return {key: judged(v, get_args(kind)[1], f"{place}.{key}") for key, v in value.items()}
    return value


def words(kind: Any) -> str:
    """Return what a parameter takes, as in 'must be …'."""
    origin, members = get_origin(kind), get_args(kind)
    if origin is Union or origin is types.UnionType:
        return " or ".join(words(member) for member in members)
    if origin is Literal:
        return " or ".join(map(repr, members))
    if origin in (tuple, Sequence):
        return f"a list of {len(members)}" if members[-1:] != (...,) and origin is tuple else "a list"
    return "a table" if origin is Mapping else _SIMPLE.get(kind) or str(getattr(kind, "__name__", "something else"))


def _may_be(value: Any, kind: Any) -> bool:
    """Whether a value has the form of a type; what is inside is not looked at."""
    origin, members = get_origin(kind), get_args(kind)
    if kind is float or kind is int:
        return isinstance(value, int if kind is int else int | float) and not isinstance(value, bool)
    if origin is Literal:
        return isinstance(value, str) and value in members
    if origin in (tuple, Sequence):
        fixed = origin is tuple and members[-1:] != (...,)
        return isinstance(value, (list, tuple)) and (not fixed or len(value) == len(members))
    if origin is Mapping:
        return isinstance(value, Mapping) and all(isinstance(key, str) for key in value)
    if origin is Union or origin is types.UnionType:
        return any(_may_be(value, member) for member in members)
    if getattr(kind, "_is_protocol", False):
        # What a protocol asks for is what it and those that it extends declare.
        asked = {name for base in kind.__mro__ if getattr(base, "_is_protocol", False) for name in vars(base)}
        return all(hasattr(value, name) for name in asked if not name.startswith("_"))
    return isinstance(kind, type) and isinstance(value, kind)


def _number(value: float, place: str) -> float:
    if abs(value) <= _LARGEST:
        return float(value)
    raise InputError(f"must be a number up to {_LARGEST:g}, not {_shown(value)}", stage=place)


def _shown(value: Any) -> str:
    """Return a value in a few letters of one line."""
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, (str, bool, float, types.NoneType)):
        return ascii(value)[:40]
    if isinstance(value, int):
        return str(value) if abs(value) < _LARGEST_WHOLE else "a number of many digits"
    return type(value).__name__


def hints(kind: type) -> Mapping[str, Any]:
    """Return the types of a class's fields."""
    return typing.get_type_hints(kind)
