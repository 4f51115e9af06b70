"""What a judge of renderings is, what it is given, and what it says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from camsim.core.arrays import F64, I64, U8
from camsim.rendering.engine import Plan


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """The worst of the photosites that were checked.

    error          : |image − reference| there, relative to the channel's full scale
    row, col       : where
    photosites     : how many were checked
    standard_error : see ``Plan.standard_error``
    """

    error: float
    row: int
    col: int
    photosites: int
    standard_error: float | None = None


class Checks(Protocol):
    """What recomputes photosites of a rendering."""

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at."""
        ...

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        ...

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        ...

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        ...
