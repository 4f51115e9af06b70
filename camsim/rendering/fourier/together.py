"""An image that is the sum of several."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.arrays import F64, U8
from camsim.rendering.engine import Cost, Progress, in_turn, share

MOST_SECONDS = 300.0  # of parts, where all at once does not fit the memory


class Part(Protocol):
    """What renders windows, and knows what they take."""

    def rendered(self, origin: tuple[float, float], channel: U8, progress: Progress = ...) -> F64: ...  # noqa: D102

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]: ...  # noqa: D102


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sum:
    """An image whose parts are transformed one after the other."""

    parts: Sequence[Part]

    def rendered(self, origin: tuple[float, float], channel: U8, progress: Progress = lambda done: None) -> F64:
        """Render every photosite in its own channel; see ``FourierImage.rendered``."""
        image = np.zeros(channel.shape)
        count = len(self.parts)
        for number, part in enumerate(self.parts):
            image += part.rendered(origin, channel, functools.partial(share, progress, number, count))
        return image

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns take, and the number of frequencies."""
        each = [part.expected(origin, shape) for part in self.parts]
        return in_turn([cost for cost, _ in each]), sum(frequencies for _, frequencies in each)


def pays(apart: Cost, whole: Cost, memory_limit_bytes: float) -> bool:
    """Return whether parts take less than all at once, or fit the memory where that does not."""
    fits = whole.memory_bytes <= memory_limit_bytes
    # What would take hours is refused for what all at once would take of memory.
    absurd = apart.memory_bytes > memory_limit_bytes or (not fits and apart.seconds > MOST_SECONDS)
    return not absurd and not (fits and whole.seconds <= apart.seconds)
