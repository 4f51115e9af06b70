"""What an image of a band is part of."""

from __future__ import annotations

from typing import Protocol

from camsim.arrays import F64, I64
from camsim.rendering.across.bands import Listened
from camsim.rendering.across.transfers import Transfers
from camsim.rendering.job import Job


class Whole(Protocol):
    """The image that a band is of."""

    @property
    def job(self) -> Job: ...  # noqa: D102
    @property
    def between(self) -> float: ...  # noqa: D102
    @property
    def transfers(self) -> Transfers: ...  # noqa: D102
    @property
    def angles(self) -> int: ...  # noqa: D102
    @property
    def signals(self) -> tuple[F64, I64, F64]: ...  # noqa: D102
    @property
    def contrast(self) -> F64: ...  # noqa: D102
    @property
    def listened(self) -> Listened: ...  # noqa: D102
    @property
    def changes(self) -> tuple[F64, F64]: ...  # noqa: D102
