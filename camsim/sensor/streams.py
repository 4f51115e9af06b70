"""Random streams: what a stage draws depends on the seed and the place, never on threads or other stages.

Every stage has an id of its own and draws from Philox(SeedSequence([seed, stage id, frame number, block]))
for each block of 64 full-width rows. Fixed patterns belong to the sensor: they draw the same way from its
serial number, for blocks of the *full frame*, and a window cuts its part out.
"""

from __future__ import annotations

import numpy as np

from camsim.arrays import F32
from camsim.errors import InvalidValueError

BLOCK_ROWS = 64


def generator(seed: int, stream: int, *, block: int, frame_number: int = 0) -> np.random.Generator:
    """Return the generator of one stage in one block of rows of one frame.

    stream : the stage's id (``ElectronicStage.stream``)

    >>> generator(7, 2, block=0).random() == generator(7, 2, block=0).random()
    True
    """
    if not 0 <= seed < 2**63:
        raise InvalidValueError(f"{seed}; must be a whole number from 0 to 2^63 − 1", key="seed")
    words = [int(seed), int(stream), int(frame_number), int(block)]
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(words)))


def fixed_normals(serial: int, stream: int, *, rows: int, cols: int, origin: tuple[int, int], frame_cols: int) -> F32:
    """Return (rows, cols) standard normals that belong to the sensor's photosites from ``origin`` on.

    origin     : (row, col) of the first photosite in the full frame
    frame_cols : width of the full frame

    A window's normals are that slice of the full frame's, exactly. 24 bits of a normal are plenty: they are
    multiplied by a spread and added to a number that is rounded far more coarsely. Beyond the frame's left, right
    and upper edges, where no photosite has a pattern, they are 0.
    """
    normals = np.zeros((rows, cols), dtype=np.float32)
    first_row, first_col = origin
    stop_row, stop_col = first_row + rows, min(first_col + cols, frame_cols)
    left = max(first_col, 0)
    row = max(first_row, 0)
    while row < stop_row:
        block, skipped = divmod(row, BLOCK_ROWS)
        stop = min((block + 1) * BLOCK_ROWS, stop_row)
        # A block's numbers come row by row, so the rows below the window need not be drawn.
        drawn = generator(serial, stream, block=block).standard_normal(
            (stop - block * BLOCK_ROWS, frame_cols), dtype=np.float32
        )
        inside = drawn[skipped:, left:stop_col]
        normals[row - first_row : stop - first_row, left - first_col : stop_col - first_col] = inside
        row = stop
    return normals


def fixed_count(rows: int, *, first_row: int, frame_cols: int) -> int:
    """Return how many normals ``fixed_normals`` draws when it is asked for BLOCK_ROWS rows at a time.

    A block of the frame begins again at its top for each part of it that is asked for.
    """
    drawn = 0
    for begin in range(first_row, first_row + rows, BLOCK_ROWS):
        row, stop = max(begin, 0), min(begin + BLOCK_ROWS, first_row + rows)
        while row < stop:
            block = row // BLOCK_ROWS
            end = min((block + 1) * BLOCK_ROWS, stop)
            drawn += (end - block * BLOCK_ROWS) * frame_cols
            row = end
    return drawn
