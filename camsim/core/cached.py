"""Cached properties that are computed once, even with several threads.

``functools.cached_property`` has one lock for all instances on Python 3.11, so that two threads wait for each other
whenever both compute the same property. From 3.12 on it has none, and two threads may compute a property of one
instance twice. Here, threads wait only for the same property of the same instance.
"""

from __future__ import annotations

import functools
import threading
from typing import Any, Self, TypeVar, overload

Cached = TypeVar("Cached")

_MAKING = " is being made"


class Caching:
    """Base of classes with such properties that can be pickled or copied while another thread computes one."""

    def __getstate__(self) -> dict[str, Any]:
        """Return the state without the locks of properties that are being computed."""
        held = self.__dict__.copy()  # atomic
        return {name: value for name, value in held.items() if not name.endswith(_MAKING)}


class cached_property(functools.cached_property[Cached]):
    """A method that is called once, on the first access.

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
        """Return the value and store it in the instance's dictionary, where later accesses find it."""
        if instance is None:
            return self
        cache, name = instance.__dict__, self.attrname
        assert name is not None
        making = f"{name}{_MAKING}"
        with cache.setdefault(making, threading.RLock()):  # atomic: both threads get the same lock
            try:
                if name not in cache:
                    cache[name] = self.func(instance)
                return cache[name]
            finally:
                cache.pop(making, None)
