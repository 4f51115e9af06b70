"""Pictures behind a lens that is a round one, moved, and a short difference: each part rendered in its own way.

Far away the pattern of a round pupil is that of its rim, whatever the wavefront. So the round part alone has light that
comes from afar, and takes it as round lenses do; what differs ends within a few lengths and is rendered in windows.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from camsim.arrays import F64, U8
from camsim.rendering.engine import Cost, added, in_turn, share
from camsim.rendering.fields.image import FieldImage
from camsim.rendering.fields.quiet import Reach
from camsim.repeated import Channels


class Part(NamedTuple):
    """Layers behind a part of the lens, whose pattern is moved along x and y, pitches."""

    image: FieldImage
    moved: tuple[float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldImages:
    """The parts, the one with the far light first; a lens that is not taken apart is one part that is not moved."""

    parts: Sequence[Part]

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes, of the part that takes most."""
        return max(part.image.wavelength_nm.size for part in self.parts)

    def rendered(
        self, origin: tuple[float, float], channel: U8, progress: Callable[[float], None] = lambda done: None
    ) -> F64:
        """Render every photosite in its own channel; arguments as of ``FieldImage.rendered``."""
        count = len(self.parts)
        first, *others = (
            part.image.rendered(_seen_from(origin, part), channel, functools.partial(share, progress, k, count))
            for k, part in enumerate(self.parts)
        )
        for other in others:
            first += other
        return first

    def bands(
        self, origin: tuple[float, float], channel: Channels, progress: Callable[[float], None] = lambda done: None
    ) -> Iterator[F64]:
        """Yield the same from the top, some rows at a time."""
        count = len(self.parts)
        each = [
            part.image.bands(_seen_from(origin, part), channel, functools.partial(share, progress, k, count))
            for k, part in enumerate(self.parts)
        ]
        return added(each)

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns from ``origin`` on are expected to take, and the number of frequencies."""
        each = [part.image.expected(_seen_from(origin, part), shape) for part in self.parts]
        return in_turn([cost for cost, _ in each]), sum(points for _, points in each)

    def reach(self, origin: tuple[float, float], shape: tuple[int, int]) -> list[Reach]:
        """Return how each part's pattern is parted for a window."""
        return [part.image.reach(_seen_from(origin, part), shape) for part in self.parts]


def _seen_from(origin: tuple[float, float], part: Part) -> tuple[float, float]:
    """Return where a window would lie if the pattern were not moved."""
    return origin[0] - part.moved[0], origin[1] - part.moved[1]
