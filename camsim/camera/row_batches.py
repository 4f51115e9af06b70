"""Regroups finished rows into the batches in which noise is drawn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camsim.core.arrays import F64


class RowBatches:
    """Regroups bands of rows as they come into batches of ``together`` rows; the last batch may be shorter.

    together : batches are multiples of this many rows;  overlap: rows that a batch shares with the next
    """

    def __init__(self, take: Callable[[F64], None], *, together: int, overlap: int) -> None:
        self._take, self._together, self._overlap = take, together, overlap
        self._held: list[F64] = []

    def add(self, band: F64) -> None:
        """Add rows; pass on complete batches."""
        self._held.append(band)
        count = sum(map(len, self._held)) - self._overlap
        whole = count // self._together * self._together
        if whole > 0:
            rows = self._joined()
            self._held = [rows[whole:].copy()]  # a view would hold all of them in memory
            self._take(rows[: whole + self._overlap])

    def finish(self) -> None:
        """Pass on the remaining rows."""
        rows = self._joined()
        if len(rows) > self._overlap:
            self._take(rows)

    def _joined(self) -> F64:
        return self._held[0] if len(self._held) == 1 else np.concatenate(self._held)
