"""Sums of plane waves on lattices, and their squares, from points that are spread to a grid here."""

from camsim.gridded.grid import is_large
from camsim.gridded.powers import PER_WAVE, held_bytes, power_rows
from camsim.gridded.sums import sums

__all__ = ["PER_WAVE", "held_bytes", "is_large", "power_rows", "sums"]
