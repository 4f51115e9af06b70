"""Distribution of captures to tasks of a second or more; those of one optical image go to as few tasks as possible."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

from camsim.api import Exposed

TASK = 4e6
"""Photosites of a task: a second or two of one core."""

_RENDERING = 5.0
"""Least cost of an optical image in frames; ``_SET_UP`` is its fixed cost in photosites."""

_SET_UP = 1e6
_AGAIN = 20.0
"""Frames of a task, in renderings' worth, beyond which another task renders the same image again."""


class Taken(Protocol):
    """Protocol of an item made from one capture."""

    @property
    def capture(self) -> Exposed:
        """The capture."""


T = TypeVar("T", bound=Taken)


def batches(items: Iterable[T], *, frames: int) -> Iterator[tuple[T, ...]]:
    """Yield lists of items, one for each task, grouped by optical image; ``frames``: number taken of each capture."""
    groups: dict[str, list[T]] = {}
    for item in items:
        groups.setdefault(item.capture.optical_key, []).append(item)
    batch: list[T] = []
    weight = 0.0
    for group in groups.values():
        grid = group[0].capture.grid
        photosites = grid.rows * grid.cols
        rendering = _RENDERING * photosites + _SET_UP
        weight += rendering
        for left, item in zip(range(len(group) - 1, -1, -1), group, strict=True):
            batch.append(item)
            weight += photosites * frames
            if weight >= max(TASK, _AGAIN * rendering if left else 0.0):
                yield tuple(batch)
                batch, weight = [], rendering if left else 0.0
    if batch:
        yield tuple(batch)
