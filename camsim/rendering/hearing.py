"""Which sides of a scene are heard of a pattern's rings, where what is nearer is cut out by a taper: whoever tells."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeAlias

from camsim.arrays import F64
from camsim.rendering.edges import Edges


class Heard(Protocol):
    """Sides as a frame hears them; pitches."""

    def beyond(self, distance: float) -> tuple[F64, F64]:
        """Return where sides are heard from a taper at a distance on, and what part of a line's."""
        ...


# Of edges seen from a first photosite, a frame's shape, how far a photosite reaches, and wavelengths of the fastest and
# of the slowest rings.
Hearing: TypeAlias = Callable[[Edges, tuple[int, int], float, float, float], Heard]
