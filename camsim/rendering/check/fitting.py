"""Windows that the check has transformed: as finely as it wants them, or as memory and patience allow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from camsim.arrays import F64, U8
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Cost

COARSER = 4.0  # times, from one try to the next: a pattern's reach falls as fast
PATIENCE_SECONDS = 4.0  # of one core, expected: a check forty times as fine as the image took ten times as long as it


class Windows(Protocol):
    """What renders windows of a scene; ``origin`` is a window's first photosite's centre, pitches."""

    def rendered(self, origin: tuple[float, float], channel: U8) -> F64:
        """Render every photosite in its own channel (..., rows, cols)."""
        ...

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns take, and how many frequencies."""
        ...


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
            cost = found.expected(origin, shape)[0]
            fits = cost.memory_bytes <= MEMORY_LIMIT_BYTES and cost.seconds <= PATIENCE_SECONDS
            if fits or tolerance >= self._coarsest:
                return found
            tolerance = min(COARSER * tolerance, self._coarsest)
