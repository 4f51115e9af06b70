"""Kinds of values for validation, and the kinds of numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt, Le

from camsim.core.words import displayed, in_range, number_hint, percent_hint
from camsim.errors import InvalidValueError

LARGEST = 1e15
"""Upper limit of any light, length, time or count; products of such numbers are far from overflow."""

SMALLEST = 1e-30
"""Lower limit of positive numbers; products of such numbers are far from underflow."""

_LARGEST_WHOLE = 2**64
_NO_COLOURS = ("P", "PA", "HSV", "YCbCr", "LAB", "CMYK")


def array_of(given: Any, key: str = "", stage: str = "") -> npt.NDArray[Any]:
    """Return numbers, lists, arrays, tensors or images as an array.

    Raises InvalidValueError, with a hint, for a tensor that NumPy cannot read directly, and for an image of Pillow
    whose numbers are not those of its colours.
    """
    if hasattr(given, "getpalette") and given.mode in _NO_COLOURS:
        message = f"is an image of mode {given.mode!r}, whose numbers are no colours; give {key or 'x'}.convert('RGB')"
        raise InvalidValueError(message, key=key, stage=stage)
    try:
        if not hasattr(given, "__array__") and callable(getattr(given, "numpy", None)):
            given = given.numpy()
        return np.asarray(given)
    except (RuntimeError, TypeError, ValueError):
        message = f"must be numbers, not {displayed(given)}"
        if hasattr(given, "detach"):
            why = "needs gradients, which end here" if getattr(given, "requires_grad", False) else "NumPy cannot read"
            message = f"is a tensor that {why}; give {key or 'x'}.detach().cpu().numpy()"
        raise InvalidValueError(message, key=key, stage=stage) from None


class Misfit(InvalidValueError):
    """A value that does not fit its type; ``item``: index in a list."""

    def __init__(self, words: str, value: Any, *, item: str = "", hint: str = "") -> None:
        if isinstance(value, type) and not hint:
            hint = f"; give one of it, {value.__name__}(…)"
        self.words, self.value, self.item, self.hint = words, value, item, hint
        super().__init__(f"{f'item {item} ' if item else ''}must be {words}, not {displayed(value)}{hint}")


@dataclass(frozen=True, slots=True)
class Kind:
    """A type for validation.

    words    : name of the kind in messages
    has_form : whether a value has the right form, whatever its size
    take     : returns the standard form of a value; raises Misfit
    as_is    : fast test whether a value is in standard form already, for long tables
    """

    words: str
    has_form: Callable[[Any], bool]
    take: Callable[[Any], Any]
    as_is: Callable[[Any], bool] = lambda value: False


def number(bare: type, limits: Sequence[Any]) -> Kind:
    """Return the kind of a number within limits; "above 0" means from SMALLEST on."""
    most: float = LARGEST if bare is float else _LARGEST_WHOLE
    low: Any = next((limit.ge for limit in limits if isinstance(limit, Ge)), -most)
    above: Any = next((limit.gt for limit in limits if isinstance(limit, Gt)), None)
    low = low if above is None else SMALLEST if above == 0 else math.nextafter(above, math.inf)
    high: Any = next((limit.le for limit in limits if isinstance(limit, Le)), most)
    called = "a number" if bare is float else "a whole number"
    words = called + in_range(limits)
    plain: Callable[[Any], Any] = _as_float if bare is float else _as_int

    def take(value: Any) -> Any:
        number: Any = value if type(value) is bare else plain(value)
        if number is not None and low <= number <= high:
            return number
        said = words
        if bare is float and number is not None and not math.isfinite(number):
            said = words.replace("a number", "a finite number", 1)
        elif number is not None and (abs(number) > most or 0 < number < low):
            said = called + in_range(_closed(limits, most))
        if isinstance(value, str):
            raise Misfit(said, value, hint=number_hint(value))
        if number is None and hasattr(value, "item"):
            raise Misfit(said, value, hint="; of a tensor or an array of one number give .item()")
        raise Misfit(said, value, hint=percent_hint(value) if high == 1 and low >= 0 else "")

    def as_is(value: Any) -> bool:
        return type(value) is bare and low <= value <= high

    return Kind(words, lambda value: plain(value) is not None, take, as_is)


def _closed(limits: Sequence[Any], most: float) -> tuple[Any, ...]:
    """Return limits, with the general ones on sides without a limit."""
    one = [limit for limit in limits if not (isinstance(limit, Gt) and limit.gt == 0)]
    low = () if any(isinstance(limit, Ge | Gt) for limit in one) else (Ge(SMALLEST if one != list(limits) else -most),)
    high = () if any(isinstance(limit, Le) for limit in limits) else (Le(most),)
    return (*one, *low, *high)


def complex_number() -> Kind:
    """Return the kind of a complex number: one of Python's or numpy's, or a pair (real part, imaginary part)."""
    words = "a finite number, real or complex"

    def plain(value: Any) -> complex | None:
        value = _alone(value)
        if isinstance(value, complex | np.complexfloating):
            return complex(value)
        parts = [_as_float(part) for part in (value if isinstance(value, list | tuple) else (value, 0.0))]
        return complex(*parts) if len(parts) == 2 and None not in parts else None  # type: ignore[arg-type]

    def take(value: Any) -> complex:
        number = plain(value)
        if number is None or not abs(number) <= LARGEST:
            raise Misfit(words, value)
        return number

    return Kind(words, lambda value: plain(value) is not None, take, lambda value: False)


def _as_float(value: Any) -> float | None:
    value = _alone(value)
    if isinstance(value, bool) or not isinstance(value, int | float | np.floating | np.integer):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _as_int(value: Any) -> int | None:
    value = _alone(value)
    return int(value) if isinstance(value, int | np.integer) and not isinstance(value, bool) else None


def _alone(value: Any) -> Any:
    """Return the number in a zero-dimensional array, and any other value unchanged."""
    return value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
