"""Properties that are worked out once, also where several threads ask.

``functools.cached_property`` has one lock for all instances on Python 3.11: two captures on two threads wait for each
other wherever both work out the same property. From 3.12 on it has none, and what two threads ask of one instance is
worked out twice. Here only those wait that ask for the same property of the same instance.
"""

from __future__ import annotations

import functools
import threading
from typing import Any, Self, TypeVar, overload

Cached = TypeVar("Cached")

_MAKING = " is being made"


class Caching:
    """What keeps such properties, and may be pickled or copied while another thread works one out."""

    def __getstate__(self) -> dict[str, Any]:
        """Return what it holds, without the locks of what is being made."""
        held = self.__dict__.copy()  # one step
        return {name: value for name, value in held.items() if not name.endswith(_MAKING)}


class cached_property(functools.cached_property[Cached]):
    """A method that is called once, when its value is first asked for.

    >>> class Circle:
    ...     @cached_property
    ...     def area(self):
    ...         print("worked out")
    ...         return 3.0
    >>> circle = Circle()
    >>> circle.area + circle.area
    worked out
    6.0
    """

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> Self: ...

    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> Cached: ...

    def __get__(self, instance: object, owner: type[Any] | None = None) -> Any:
        """Return the value, which from now on lies in the instance's own dictionary and is found there."""
        if instance is None:
            return self
        kept, name = instance.__dict__, self.attrname
        assert name is not None
        making = f"{name}{_MAKING}"
        with kept.setdefault(making, threading.RLock()):  # one step: of two threads' locks one is taken by both
            try:
                if name not in kept:
                    kept[name] = self.func(instance)
                return kept[name]
            finally:
                kept.pop(making, None)
