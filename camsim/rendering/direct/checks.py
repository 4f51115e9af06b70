"""Protocol of a check of renderings, and its result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.rendering.engine import Plan


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """The largest error among the photosites that were checked.

    error          : |image − reference| there, relative to the channel's full scale
    row, col       : the photosite
    photosites     : number of photosites checked
    standard_error : see ``Plan.standard_error``
    """

    error: float
    row: int
    col: int
    photosites: int
    standard_error: float | None = None

    @classmethod
    def of(cls, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with the reference; NaN counts as an infinite error."""
        difference = np.abs(values - right)
        difference = np.where(np.isnan(difference), np.inf, difference)
        worst = int(np.argmax(difference))
        return cls(
            error=float(difference[worst]),
            row=int(rows[worst]),
            col=int(cols[worst]),
            photosites=rows.size,
            standard_error=plan.standard_error(rows, cols),
        )


def in_channels(light: F64, sets: U8) -> F64:
    """Return the light (channels, n) of photosites, each in its channel of ``sets`` (..., n)."""
    found: F64 = np.take_along_axis(light, sets.reshape(-1, sets.shape[-1]).astype(np.int64), axis=0)
    return found.reshape(sets.shape)


class Checks(Protocol):
    """Protocol of a check, which recomputes photosites of a rendering."""

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to check."""
        ...

    def seconds(self, plan: Plan) -> float:
        """Return the expected seconds of the check."""
        ...

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Recompute photosites, each in its channel of ``sets`` (..., photosites)."""
        ...
