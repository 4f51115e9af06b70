"""What an annotation may say of a parameter besides its type."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Called:
    """What messages call a type where its own name would say too little, and a way out that they may offer."""

    words: str
    way_out: str = ""


@dataclass(frozen=True, slots=True)
class Hinted:
    """The way out that messages offer of a value that does not fit; empty where there is none to offer."""

    way_out: Callable[[Any], str]


@dataclass(frozen=True, slots=True)
class Before:
    """What a value is turned into before it is judged."""

    turned: Callable[[Any], Any]


@dataclass(frozen=True, slots=True)
class After:
    """What becomes of a value that fits; raises InvalidValueError where more is wrong than its type says."""

    settled: Callable[[Any], Any]
