"""Validation and conversion for declared types, compiled once per type from its annotation."""

from __future__ import annotations

import functools
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
from annotated_types import MaxLen, MinLen

from camsim.core.annotations import After, Before, Called, Hinted
from camsim.core.arrays import is_masked
from camsim.core.number_kinds import Kind, Misfit, array_of, complex_number, number
from camsim.core.words import called, either, word_hint

_LONGEST_TEXT = 100_000


@functools.cache
def kind_of(declared: Any) -> Kind:
    """Return the kind of a type: numbers, bool, str, None, Literal, unions, tuples, sequences and mappings of these.

    For any other class or protocol, the value must be an instance.
    """
    origin, members = get_origin(declared), get_args(declared)
    if origin is Annotated:
        return _annotated(members[0], members[1:])
    if declared is Any:
        return _checked("anything", lambda value: True)
    if declared in (float, int):
        return number(declared, ())
    if declared is complex:
        return complex_number()
    if origin is Union or origin is types.UnionType:
        return _one_of(declared)
    if origin is tuple and members[-1:] != (...,):
        return _row([kind_of(member) for member in members])
    if origin in (tuple, Sequence):
        return _list(members[0])
    if origin is Mapping:
        return _table(kind_of(members[1]))
    return _simple(declared, origin, members)


def _simple(declared: Any, origin: Any, members: tuple[Any, ...]) -> Kind:
    if origin is Literal:
        return _word(members)
    if origin is Callable:
        return _checked("a function", callable)
    if declared is bool:
        return _checked("true or false", lambda value: isinstance(value, bool | np.bool_), made=bool)
    if declared is str:
        return _checked("a text", lambda value: isinstance(value, str) and len(value) <= _LONGEST_TEXT, made=str)
    if declared is types.NoneType:
        return _checked("None", lambda value: value is None)
    if getattr(declared, "_is_protocol", False):
        # A protocol requires the members that it and its base protocols declare.
        asked = {name for base in declared.__mro__ if getattr(base, "_is_protocol", False) for name in vars(base)}
        names = [name for name in asked if not name.startswith("_")]
        return _checked(
            called(declared), lambda value: not isinstance(value, type) and all(hasattr(value, name) for name in names)
        )
    return _checked(called(declared), lambda value: isinstance(value, declared))


def _word(known: tuple[str, ...]) -> Kind:
    words = either([repr(word) for word in known])

    def take(value: Any) -> Any:
        if isinstance(value, str) and value in known:
            return value
        raise Misfit(words, value, hint=word_hint(value, known) if isinstance(value, str) else "")

    return Kind(words, lambda value: isinstance(value, str), take, lambda value: type(value) is str and value in known)


def _checked(words: str, holds: Callable[[Any], bool], *, made: Callable[[Any], Any] | None = None) -> Kind:
    def take(value: Any) -> Any:
        if holds(value):
            return value if made is None else made(value)
        raise Misfit(words, value)

    return Kind(words, holds, take, holds if made is None else lambda value: type(value) is made and holds(value))


def _one_of(declared: Any) -> Kind:
    members = [kind_of(member) for member in get_args(declared)]
    words = either([member.words for member in members])

    def take(value: Any) -> Any:
        for member in members:
            if member.has_form(value):
                try:
                    return member.take(value)
                except Misfit as misfit:
                    if misfit.item:
                        raise
                    hint = _way_out(members, value) if isinstance(value, str) else misfit.hint
                    stated = either([misfit.words if one is member else one.words for one in members])
                    raise Misfit(stated, value, hint=hint) from None
        raise Misfit(words, value, hint=_way_out(members, value))

    def as_is(value: Any) -> bool:
        return any(member.as_is(value) for member in members)

    return Kind(words, lambda value: any(member.has_form(value) for member in members), take, as_is)


def _way_out(members: Sequence[Kind], value: Any) -> str:
    """Return the first hint about a value from several types."""
    for member in members:
        try:
            member.take(value)
        except Misfit as misfit:
            if misfit.hint:
                return misfit.hint
    return ""


def _list(declared: Any) -> Kind:
    member = kind_of(declared)

    def take(value: Any) -> tuple[Any, ...]:
        given = _items(value)
        if given is None:
            image = hasattr(value, "__array_interface__")
            raise Misfit("a list", value, hint="; np.asarray(…) makes an array of an image" if image else "")
        return tuple(given if all(map(member.as_is, given)) else _each(given, [member] * len(given)))

    def as_is(value: Any) -> bool:
        return type(value) is tuple and all(map(member.as_is, value))

    return Kind("a list", lambda value: _items(value) is not None, take, as_is)


def _row(members: Sequence[Kind]) -> Kind:
    words = f"a list of {len(members)}"

    def take(value: Any) -> tuple[Any, ...]:
        given = _items(value)
        if given is None or len(given) != len(members):
            raise Misfit(words, value)
        return tuple(_each(given, members))

    def as_is(value: Any) -> bool:
        if type(value) is not tuple or len(value) != len(members):
            return False
        for member, item in zip(members, value, strict=True):  # noqa: SIM110 (a third of the time of all())
            if not member.as_is(item):
                return False
        return True

    return Kind(words, lambda value: _items(value) is not None, take, as_is)


def _table(member: Kind) -> Kind:
    def take(value: Any) -> dict[str, Any]:
        if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
            raise Misfit("a table", value)
        return dict(zip(value, _each(list(value.values()), [member] * len(value)), strict=True))

    return Kind("a table", lambda value: isinstance(value, Mapping), take)


def _items(value: Any) -> Sequence[Any] | None:
    """Return the items of a list, a tuple or an array; None for anything else, texts included."""
    if isinstance(value, list | tuple):
        return value
    if hasattr(value, "__array__") and not isinstance(value, np.generic):
        # Masked values become not a number, and are refused.
        listed = (value.astype(float).filled(np.nan) if is_masked(value) else array_of(value)).tolist()
        return listed if isinstance(listed, list) else None
    return value if isinstance(value, Sequence) and not isinstance(value, str | bytes) else None


def _each(values: Sequence[Any], members: Sequence[Kind]) -> list[Any]:
    taken = []
    for index, (value, member) in enumerate(zip(values, members, strict=True)):
        try:
            taken.append(member.take(value))
        except Misfit as misfit:
            item = f"{index}.{misfit.item}" if misfit.item else str(index)
            raise Misfit(misfit.words, misfit.value, item=item, hint=misfit.hint) from None
    return taken


def _annotated(bare: Any, marks: Sequence[Any]) -> Kind:
    """Return a kind with limits on its number or its length, another name, or a conversion before or after."""
    kind = number(bare, marks) if bare in (float, int) else kind_of(bare)
    for mark in marks:
        kind = _marked(kind, mark)
    return kind


def _marked(kind: Kind, mark: Any) -> Kind:
    take, words = kind.take, kind.words
    if isinstance(mark, Before):
        return Kind(words, lambda value: kind.has_form(mark.turned(value)), lambda value: take(mark.turned(value)))
    if isinstance(mark, After):
        return Kind(words, kind.has_form, lambda value: mark.settled(take(value)))
    if isinstance(mark, Hinted):
        return Kind(words, kind.has_form, _hinted(take, mark), kind.as_is)
    if isinstance(mark, Called):
        return Kind(mark.words, kind.has_form, _renamed(take, mark), kind.as_is)
    if isinstance(mark, MinLen | MaxLen):
        least, most = getattr(mark, "min_length", 0), getattr(mark, "max_length", None)
        words = f"{words} of at {f'least {least}' if most is None else f'most {most}'}"

        def of_length(value: Any) -> Any:
            taken = take(value)
            if len(taken) < least or (most is not None and len(taken) > most):
                raise Misfit(words, value)
            return taken

        return Kind(words, kind.has_form, of_length)
    return kind


def _renamed(take: Callable[[Any], Any], mark: Called) -> Callable[[Any], Any]:
    def renamed(value: Any) -> Any:
        try:
            return take(value)
        except Misfit as misfit:
            if misfit.item:
                raise
            hint = f"; {mark.way_out}" if mark.way_out else misfit.hint
            raise Misfit(mark.words, value, hint=hint) from None

    return renamed


def _hinted(take: Callable[[Any], Any], mark: Hinted) -> Callable[[Any], Any]:
    def hinted(value: Any) -> Any:
        try:
            return take(value)
        except Misfit as misfit:
            hint = misfit.hint or mark.way_out(value)
            raise Misfit(misfit.words, value, item=misfit.item, hint=hint) from None

    return hinted
