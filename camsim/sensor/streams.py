"""Random streams: what a stage draws depends on the seed and the place, never on threads or other stages.

Every stage has an id of its own and draws from Philox(SeedSequence([seed, stage id, frame number, block]))
for each block of 64 full-width rows. Fixed patterns belong to the sensor: they draw the same way from its
serial number, for blocks of the *full frame*, and a window cuts its part out.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from camsim.arrays import F32
from camsim.errors import InvalidValueError

BLOCK_ROWS = 64


class Stream(IntEnum):
    """Ids of the stages that draw; a number once used keeps its meaning, or old captures change."""

    PRNU = 1
    SHOT = 2
    READ = 3
    DSNU = 4


def generator(seed: int, stream: int, *, block: int, frame_number: int = 0) -> np.random.Generator:
    """Return the generator of one stage in one block of rows of one frame.

    >>> generator(7, Stream.SHOT, block=0).random() == generator(7, Stream.SHOT, block=0).random()
    True
    """
    if not 0 <= seed < 2**63:
        raise InvalidValueError(f"seed {seed}; must be a whole number from 0 to 2^63 − 1")
    words = [int(seed), int(stream), int(frame_number), int(block)]
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(words)))


def fixed_normals(
    serial: int, stream: int, *, rows: int, cols: int, origin: tuple[int, int], frame_cols: int
) -> F32:
    """Return (rows, cols) standard normals that belong to the sensor's photosites from ``origin`` on.

    origin     : (row, col) of the first photosite in the full frame
    frame_cols : width of the full frame

    A window's normals are that slice of the full frame's, exactly. 24 bits of a normal are plenty: they are
    multiplied by a spread and added to a number that is rounded far more coarsely.
    """
    first_row, first_col = origin
    normals = np.empty((rows, cols), dtype=np.float32)
    row = first_row
    while row < first_row + rows:
        block, skipped = divmod(row, BLOCK_ROWS)
        stop = min((block + 1) * BLOCK_ROWS, first_row + rows)
        # A block's numbers come row by row, so the rows below the window need not be drawn.
        drawn = generator(serial, stream, block=block).standard_normal(
            (stop - block * BLOCK_ROWS, frame_cols), dtype=np.float32
        )
        normals[row - first_row : stop - first_row] = drawn[skipped:, first_col : first_col + cols]
        row = stop
    return normals
