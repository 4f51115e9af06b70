"""How captures are shared out: tasks of a second or more, and one optical image in as few of them as may be."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

from camsim.api import Exposed

TASK = 4e6
"""Photosites of a task: a second or two of one core."""

_RENDERING = 5.0
"""What an optical image costs in frames, at the least; and ``_SET_UP`` photosites whatever its size."""

_SET_UP = 1e6
_AGAIN = 20.0
"""Renderings' worth of frames that a task has before others of the same image go to another, which renders it too."""


class Taken(Protocol):
    """What is made of one capture."""

    @property
    def capture(self) -> Exposed:
        """The capture."""


T = TypeVar("T", bound=Taken)


def batches(items: Iterable[T], *, frames: int) -> Iterator[tuple[T, ...]]:
    """Yield what goes to one worker; what shares an optical image lies together. ``frames``: of each capture."""
    groups: dict[str, list[T]] = {}
    for item in items:
        groups.setdefault(item.capture.optical_key, []).append(item)
    own: list[T] = []
    weight = 0.0
    for group in groups.values():
        grid = group[0].capture.grid
        photosites = grid.rows * grid.cols
        rendering = _RENDERING * photosites + _SET_UP
        weight += rendering
        for left, item in zip(range(len(group) - 1, -1, -1), group, strict=True):
            own.append(item)
            weight += photosites * frames
            if weight >= max(TASK, _AGAIN * rendering if left else 0.0):
                yield tuple(own)
                own, weight = [], rendering if left else 0.0
    if own:
        yield tuple(own)
