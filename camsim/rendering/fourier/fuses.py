"""Lenses that add up their wavelengths themselves: transfers of a whole tile at once."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from camsim.arrays import C128, F64


class Fused(Protocol):
    """Transfers of several sets of weights."""

    def on_half_plane(self, steps_per_um: tuple[float, float], counts: tuple[int, int]) -> C128:
        """Return them (sets, j, i) at (i, j)·steps, i from 0 on, j of either sign; counts: of 0 and above."""
        ...


@runtime_checkable
class Fuses(Protocol):
    """A lens that adds up its wavelengths itself."""

    def fused(self, wavelength_nm: F64, weights: F64, allowed: float) -> Fused:
        """Return transfers of sets of weights (sets, wavelengths)."""
        ...
