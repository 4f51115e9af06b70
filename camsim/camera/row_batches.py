"""Rows that come as they are finished, handed on in the groups that noise is drawn in."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camsim.core.arrays import F64


class RowBatches:
    """Rows as they come, handed on in groups of so many, the last group as it is.

    together : rows of a group, or a multiple of it;  overlap: rows that a group shares with the next
    """

    def __init__(self, take: Callable[[F64], None], *, together: int, overlap: int) -> None:
        self._take, self._together, self._overlap = take, together, overlap
        self._held: list[F64] = []

    def add(self, band: F64) -> None:
        """Take in rows; hand on what is whole."""
        self._held.append(band)
        count = sum(map(len, self._held)) - self._overlap
        whole = count // self._together * self._together
        if whole > 0:
            rows = self._joined()
            self._held = [rows[whole:].copy()]  # a view would keep all of them
            self._take(rows[: whole + self._overlap])

    def finish(self) -> None:
        """Hand on the rest."""
        rows = self._joined()
        if len(rows) > self._overlap:
            self._take(rows)

    def _joined(self) -> F64:
        return self._held[0] if len(self._held) == 1 else np.concatenate(self._held)
