"""What an image of a band is part of."""

from __future__ import annotations

from typing import Protocol

from camsim.arrays import F64
from camsim.rendering.across.bands import Listened
from camsim.rendering.across.tile_sums import Signals
from camsim.rendering.across.transfers import Transfers


class Whole(Signals, Protocol):
    """The image that a band is of."""

    @property
    def between(self) -> float: ...  # noqa: D102
    @property
    def transfers(self) -> Transfers: ...  # noqa: D102
    @property
    def angles(self) -> int: ...  # noqa: D102
    @property
    def listened(self) -> Listened: ...  # noqa: D102
    @property
    def changes(self) -> tuple[F64, F64]: ...  # noqa: D102
