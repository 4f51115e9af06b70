"""Which sides of a scene are heard of a pattern's rings, where what is nearer is cut out by a taper: whoever tells."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeAlias

from camsim.arrays import F64
from camsim.rendering.edges import Edges
from camsim.rendering.job import Job


class Heard(Protocol):
    """Sides as a frame hears them; pitches."""

    def beyond(self, distance: float) -> tuple[F64, F64]:
        """Return where sides are heard from a taper at a distance on, and what part of a line's."""
        ...


# Of edges seen from a first photosite, a frame's shape, how far a photosite reaches, and wavelengths of the fastest and
# of the slowest rings.
Hearing: TypeAlias = Callable[[Edges, tuple[int, int], float, float, float], Heard]


class Listening(NamedTuple):
    """Who tells what is heard of a pattern's rings.

    until : of a job, how far they are, and what is past three powers of 1/r; None: only edges tell
    sides : of edges, which of them are
    """

    until: Callable[[Job], float] | None
    sides: Hearing
