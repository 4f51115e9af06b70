"""Marks for annotations of parameters, in addition to their types."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Called:
    """Name of a type in messages, instead of the default, and an optional hint."""

    words: str
    way_out: str = ""


@dataclass(frozen=True, slots=True)
class Hinted:
    """Function that returns a hint about a value that does not fit, or an empty text."""

    way_out: Callable[[Any], str]


@dataclass(frozen=True, slots=True)
class Before:
    """Conversion of a value before its validation."""

    turned: Callable[[Any], Any]


@dataclass(frozen=True, slots=True)
class After:
    """Conversion of a value after its validation; raises InvalidValueError if a further condition fails."""

    settled: Callable[[Any], Any]
