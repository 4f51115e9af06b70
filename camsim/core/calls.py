"""Readable messages for calls with wrong parameters, which Python would refuse with a plain TypeError."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar

from camsim.core.declared_types import kind_of
from camsim.core.number_kinds import Kind
from camsim.core.typed import hints
from camsim.core.words import both, meant
from camsim.errors import WrongCallError

P = ParamSpec("P")
R = TypeVar("R")

_LONGEST_DISPLAYED = 40


def in_words(call: Callable[P, R]) -> Callable[P, R]:
    """Make a function's errors name the parameter that is misspelt, missing, or must be given by name.

    >>> @in_words
    ... def expose(*, time_s, iso=100): ...
    >>> expose(shutter=0.01)
    Traceback (most recent call last):
        ...
    camsim.errors.WrongCallError: expose.shutter: unknown parameter; did you mean 'time_s'?
    >>> expose(0.01)
    Traceback (most recent call last):
        ...
    camsim.errors.WrongCallError: expose: takes time_s by name; write expose(time_s=0.01)
    """
    return _stated(call, lambda given: (call.__name__, given))


def constructors_in_words(kind: type) -> None:
    """Do what ``in_words`` does for a class: for constructors, and for methods with keyword-only parameters."""
    inherited = {"__init__": inspect.getattr_static(kind, "__init__")}
    for name, made in {**inherited, **vars(kind)}.items():
        call = made.__func__ if isinstance(made, classmethod) else made
        if not inspect.isfunction(call) or hasattr(call, "__wrapped__"):
            continue
        stated: Any
        if name == "__init__":
            stated = _stated(call, lambda given: (type(given[0]).__name__, given[1:]), kind)
        elif name.startswith("_"):
            continue
        elif isinstance(made, classmethod):
            stated = classmethod(_stated(call, _of_class(name)))
        elif _takes_names(call):
            stated = _stated(call, _of_object(name))
        else:
            continue
        setattr(kind, name, stated)


def _kinds(kind: type | None) -> Mapping[str, Kind]:
    """Return the kind of each parameter of a class whose fields are validated."""
    try:
        return {} if kind is None else {name: kind_of(declared) for name, declared in hints(kind).items()}
    except NameError:  # its annotations are imported for type checkers only: not validated
        return {}


def _takes_names(call: Callable[..., Any]) -> bool:
    return any(part.kind is part.KEYWORD_ONLY for part in inspect.signature(call).parameters.values())


Split = Callable[[Sequence[Any]], tuple[str, Sequence[Any]]]
"""Function of the positional arguments that returns the name of the callable, and those that are parameters."""


def _of_class(name: str) -> Split:
    return lambda given: (f"{given[0].__name__}.{name}", given[1:])


def _of_object(name: str) -> Split:
    return lambda given: (f"{type(given[0]).__name__}.{name}", given[1:])


def _stated(call: Callable[P, R], split: Split, kind: type | None = None) -> Callable[P, R]:
    @functools.wraps(call)
    def stated(*given: P.args, **named: P.kwargs) -> R:
        try:
            return call(*given, **named)
        except TypeError:
            signature = inspect.signature(call)
            try:
                signature.bind(*given, **named)
            except TypeError:
                called, rest = split(given)
                taken = list(signature.parameters.values())[len(given) - len(rest) :]
                if len(rest) == 1 and isinstance(rest[0], str) and hasattr(kind, "from_yaml"):
                    read = f"{called}.from_yaml({_written(rest[0])}, …)"
                    raise WrongCallError(f"takes its parts, by name; {read} reads one", stage=called) from None
                raise _refusal(called, taken, rest, named, _kinds(kind)) from None
            raise

    return stated


def _refusal(
    called: str,
    parameters: Sequence[inspect.Parameter],
    given: Sequence[Any],
    named: Mapping[str, Any],
    kinds: Mapping[str, Kind],
) -> WrongCallError:
    known = [part.name for part in parameters]
    if unknown := [name for name in named if name not in known]:
        free = [name for name in known if name not in named]
        near = meant(unknown[0], free)
        way_out = f"did you mean {near!r}?" if near else f"known here: {', '.join(known)}"
        return WrongCallError(f"unknown parameter; {way_out}", key=unknown[0], stage=called)
    by_place = [part.name for part in parameters if part.kind is not part.KEYWORD_ONLY]
    if twice := [name for name in by_place[: len(given)] if name in named]:
        return WrongCallError("given twice, by its place and by its name; leave one out", key=twice[0], stage=called)
    if len(given) > len(by_place):
        free_ones = [part for part in parameters if part.name not in named]
        by_name = [part.name for part in free_ones if part.name not in by_place]
        if len(given) > len(free_ones):
            count = len(given) + len(named)
            return WrongCallError(f"takes {both(known)}, and no more: {count} were given", stage=called)
        if (paired := _paired(given, free_ones, kinds)) is None:
            return WrongCallError(f"takes {both(by_name)} by name", stage=called)
        names = both([name for name in paired if name in by_name])
        written = ", ".join(f"{name}={_written(value)}" for name, value in {**paired, **named}.items())
        return WrongCallError(f"takes {names} by name; write {called}({written})", stage=called)
    missing = [p.name for p in parameters if p.default is p.empty and p.name not in {*by_place[: len(given)], *named}]
    words = f"; {kinds[missing[0]].words}" if missing[0] in kinds else ""
    more = f"; so {'are' if len(missing) > 2 else 'is'} {both(missing[1:])}" if len(missing) > 1 else ""
    return WrongCallError(f"missing{words}{more}", key=missing[0], stage=called)


def _paired(
    given: Sequence[Any], parameters: Sequence[inspect.Parameter], kinds: Mapping[str, Kind]
) -> dict[str, Any] | None:
    """Return the values by the parameters for which they were meant; None if that is ambiguous.

    Required parameters are assigned first, in order; an optional one only if no other one fits.
    """
    left, paired = list(parameters), {}
    for value in given:
        fitting = [part for part in left if part.name not in kinds or kinds[part.name].has_form(value)]
        required = [part for part in fitting if part.default is part.empty]
        if not required and len(fitting) != 1:
            return None
        part = (required or fitting)[0]
        left.remove(part)
        paired[part.name] = value
    return paired


def _written(value: Any) -> str:
    """Return a value as source text for a call; … for a long one."""
    plain = isinstance(value, int | float | str | list | tuple | dict)
    return text if plain and len(text := repr(value)) <= _LONGEST_DISPLAYED else "…"
