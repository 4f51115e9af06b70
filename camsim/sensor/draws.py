"""How many random numbers a capture draws: counted from what its stages draw, not drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from camsim.sensor.streams import BLOCK_ROWS

PER_PHOTOSITE = ("shot_noise", "reset_noise", "read_noise", "output_noise")


def random_numbers(
    stages: Mapping[str, Any], *, rows: int, cols: int, origin: tuple[int, int], frame_cols: int, noise: bool
) -> int:
    """Return the count for one frame of a window; the places of drawn defects are left out, for chance decides them.

    stages     : by the names of ``chain.record``, None for one that is left out
    origin     : (row, col) of the window's first photosite in the full frame
    frame_cols : width of the full frame: fixed patterns are drawn for whole rows, from the top of a block of rows on
    """
    if not noise:
        return 0
    acting = {name for name, stage in stages.items() if stage is not None}
    border = 1 if "crosstalk" in acting else 0
    count = rows * cols * len(acting.intersection(PER_PHOTOSITE))
    if "prnu" in acting:
        # Crosstalk mixes neighbours' light, and a block begins again at the top for each part of it that is asked for.
        count += _fixed(rows + 2 * border, origin[0] - border, frame_cols)
    if "dsnu" in acting:
        count += _fixed(rows, origin[0], frame_cols)
    dark = stages.get("dark_current")
    if dark is not None and dark.nonuniformity:
        count += _fixed(rows, origin[0], frame_cols)
    if "row_noise" in acting:
        count += rows
    if "flicker_rows" in acting:
        count += 2 * rows
    if "column_noise" in acting:
        count += frame_cols
    return count


def _fixed(rows: int, first_row: int, frame_cols: int) -> int:
    """Return how many normals ``fixed_normals`` draws, called as the chain does: for BLOCK_ROWS rows at a time."""
    drawn = 0
    for begin in range(first_row, first_row + rows, BLOCK_ROWS):
        row, stop = max(begin, 0), min(begin + BLOCK_ROWS, first_row + rows)
        while row < stop:
            block = row // BLOCK_ROWS
            end = min((block + 1) * BLOCK_ROWS, stop)
            drawn += (end - block * BLOCK_ROWS) * frame_cols
            row = end
    return drawn
