"""Validation of parameters against their declared types, and conversion to a standard form.

A constructor calls ``validate(self)`` first. Numbers of numpy become Python's, lists and arrays tuples; a number is
within the limits of its type, finite, and never a truth value or a text. Files are validated by the same limits and in
the same words (``camsim.config``).
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import os
import typing
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt, Le

from camsim.core.annotations import Before, Called
from camsim.core.declared_types import kind_of
from camsim.core.number_kinds import Kind
from camsim.core.words import displayed, either
from camsim.errors import InvalidValueError, UnknownNameError

Number: TypeAlias = float | np.floating[Any] | np.integer[Any]
Whole: TypeAlias = int | np.integer[Any]
Truth: TypeAlias = bool | np.bool_
"""Types that constructors accept and convert to Python's float, int and bool."""

Positive: TypeAlias = Annotated[float, Gt(0)]
NonNegative: TypeAlias = Annotated[float, Ge(0)]
Fraction: TypeAlias = Annotated[float, Ge(0), Le(1)]
Celsius: TypeAlias = Annotated[float, Ge(-273.15), Le(200)]
# In air no lens is faster than f/0.5, where rays come from the whole half-space; pinholes are slower than f/100.
FNumber: TypeAlias = Annotated[float, Ge(0.5), Le(10_000)]
# Below a few tenths of a wavelength nothing is resolved; a detector of a centimetre is a single one, not an array.
Pitch: TypeAlias = Annotated[float, Ge(0.1), Le(10_000)]
# The fastest gates are open for fractions of a nanosecond; files can express up to 30 years.
SHORTEST_S, LONGEST_S = 1e-9, 1e9
Seconds: TypeAlias = Annotated[float, Ge(SHORTEST_S), Le(LONGEST_S)]
Count: TypeAlias = Annotated[int, Ge(1)]
Index: TypeAlias = Annotated[int, Ge(0)]
Iso: TypeAlias = Annotated[float, Ge(1e-3), Le(1e9)]
LARGEST_SEED, LARGEST_FRAME_NUMBER = 2**63 - 1, 2**31 - 1
Seed: TypeAlias = Annotated[int, Ge(0), Le(LARGEST_SEED)]
FrameNumber: TypeAlias = Annotated[int, Ge(0), Le(LARGEST_FRAME_NUMBER)]


def text_of_path(given: Any) -> Any:
    """Return a path as text, and any other value unchanged."""
    return os.fspath(given) if isinstance(given, os.PathLike) else given


FilePath: TypeAlias = Annotated[str, Before(text_of_path), Called("a path")]

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])

if TYPE_CHECKING:
    Several: TypeAlias = Sequence[T] | npt.NDArray[Any]
    Point: TypeAlias = Sequence[float] | npt.NDArray[Any]
else:

    class Several:
        """A list, a tuple or an array as a parameter, stored as a tuple."""

        def __class_getitem__(cls, item: Any) -> Any:
            return tuple[item, ...]

    Point = tuple[float, float]

Place: TypeAlias = Sequence[Number] | npt.NDArray[Any]
"""Types that constructors accept for a point."""

Corners: TypeAlias = Annotated[
    Several[Point], Called("a list of corners (x, y)", "of a shapely polygon give its exterior.coords")
]


def validate(stage: Any) -> None:
    """Validate the parameters of a frozen dataclass, and store them in standard form.

    >>> from camsim.optics import Airy
    >>> Airy(f_number="8")
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: Airy.f_number: must be a number above 0, not '8'
    """
    for name, kind in _parameters(stage.__class__):
        given = getattr(stage, name)
        if kind.as_is(given):
            continue
        try:
            stored = kind.take(given)
        except InvalidValueError as error:
            raise refusal(stage, name, error.message) from None
        if stored is not given:
            object.__setattr__(stage, name, stored)


def refusal(stage: object, key: str, message: str) -> InvalidValueError:
    """Return the error of a constructor about one of its parameters."""
    return InvalidValueError(message, key=key, stage=type(stage).__name__)


def check(value: Any, kind: Any, key: str, stage: str = "") -> Any:
    """Return a value in the standard form of a type; raises InvalidValueError that names the key and the stage."""
    try:
        return kind_of(kind).take(value)
    except InvalidValueError as error:
        raise InvalidValueError(error.message, key=key, stage=stage) from None


def check_truths(**given: Any) -> None:
    """Raise InvalidValueError for the first value that is neither true nor false, such as the text "no".

    >>> check_truths(force=True, compress="no")
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: compress: must be true or false, not 'no'
    """
    for key, value in given.items():
        check(value, bool, key)


def known_name(kind: str, name: Any, known: Collection[str], key: str = "") -> str:
    """Return a name if it is in a list; raises UnknownNameError if not, InvalidValueError if it is not a text.

    >>> known_name("method", None, ["boundary", "fourier"])
    Traceback (most recent call last):
        ...
    camsim.errors.InvalidValueError: method: must be 'boundary' or 'fourier', not None
    """
    if not isinstance(name, str):
        raise InvalidValueError(
            f"must be {either([repr(word) for word in known])}, not {displayed(name)}", key=key or kind
        )
    if name not in known:
        raise UnknownNameError(kind, name, known, key=key)
    return name


def spelled_out(keywords: type) -> Callable[[F], F]:
    """Make help and completion list the keywords of a method that takes ``**changes: Unpack[keywords]``.

    keywords : a TypedDict without required keys
    """

    def spelled(method: F) -> F:
        named = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=_UNCHANGED, annotation=_as_written(kind))
            for name, kind in keywords.__annotations__.items()
        ]
        signature = inspect.signature(method)
        first = [part for part in signature.parameters.values() if part.kind is not inspect.Parameter.VAR_KEYWORD]
        method.__signature__ = signature.replace(parameters=[*first, *named])  # type: ignore[attr-defined]
        return method

    return spelled


class _Unchanged:
    """The default that help displays for a keyword whose absence changes nothing."""

    def __repr__(self) -> str:
        return "unchanged"


_UNCHANGED = _Unchanged()


def _as_written(kind: Any) -> Any:
    return kind.__forward_arg__ if isinstance(kind, typing.ForwardRef) else kind


@functools.cache
def _parameters(stage: type) -> tuple[tuple[str, Kind], ...]:
    kinds = hints(stage)
    return tuple((field.name, kind_of(kinds[field.name])) for field in dataclasses.fields(stage) if field.init)


@functools.cache
def hints(kind: type) -> dict[str, Any]:
    """Return the types of a class's fields, with their limits."""
    return typing.get_type_hints(kind, include_extras=True)
