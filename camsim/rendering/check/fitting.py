"""Windows that the check has transformed: as finely as it wants them, or as memory and patience allow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from camsim.arrays import F64, U8
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Cost

COARSER = 4.0  # times, from one try to the next: a pattern's reach falls as fast
MUCH_LESS = 0.5  # of the time: what is looked at otherwise than the image is worth twice as much
PATIENCE_SECONDS = 4.0  # of one core, expected: a check forty times as fine as the image took ten times as long as it


class Windows(Protocol):
    """What renders windows of a scene; ``origin`` is a window's first photosite's centre, pitches."""

    def rendered(self, origin: tuple[float, float], channel: U8) -> F64:
        """Render every photosite in its own channel (..., rows, cols)."""
        ...

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns take, and how many frequencies."""
        ...


class Either:
    """Windows of one kind, or of another where the first take long and these much less, or alone fit the memory."""

    def __init__(self, first: Windows, other: Windows) -> None:
        self._first, self._other = first, other

    def rendered(self, origin: tuple[float, float], channel: U8) -> F64:
        """Render every photosite in its own channel (..., rows, cols)."""
        return self._for(origin, (channel.shape[-2], channel.shape[-1])).rendered(origin, channel)

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns take, and how many frequencies."""
        return self._for(origin, shape).expected(origin, shape)

    def _for(self, origin: tuple[float, float], shape: tuple[int, int]) -> Windows:
        cost = self._first.expected(origin, shape)[0]
        if _fits(cost):
            return self._first
        other = self._other.expected(origin, shape)[0]
        soon = other.seconds < MUCH_LESS * cost.seconds or cost.memory_bytes > MEMORY_LIMIT_BYTES
        return self._other if soon and other.memory_bytes <= MEMORY_LIMIT_BYTES else self._first


class Fitting:
    """Windows to a tolerance that is wanted, coarser where they would take long, but no coarser than the image is.

    A scene that the image's own tolerance can be rendered to is not refused because the check would be finer.
    """

    def __init__(self, make: Callable[[float], Windows], *, wanted: float, coarsest: float) -> None:
        self._make = make
        self._wanted, self._coarsest = wanted, max(wanted, coarsest)
        self._made: dict[float, Windows] = {}

    def rendered(self, origin: tuple[float, float], channel: U8) -> F64:
        """Render every photosite in its own channel (..., rows, cols)."""
        return self._about(origin, (channel.shape[-2], channel.shape[-1])).rendered(origin, channel)

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns take, and how many frequencies."""
        return self._about(origin, shape).expected(origin, shape)

    def _about(self, origin: tuple[float, float], shape: tuple[int, int]) -> Windows:
        tolerance = self._wanted
        while True:
            if tolerance not in self._made:
                self._made[tolerance] = self._make(tolerance)
            found = self._made[tolerance]
            if tolerance >= self._coarsest or _fits(found.expected(origin, shape)[0]):
                return found
            tolerance = min(COARSER * tolerance, self._coarsest)


def _fits(cost: Cost) -> bool:
    return cost.memory_bytes <= MEMORY_LIMIT_BYTES and cost.seconds <= PATIENCE_SECONDS
