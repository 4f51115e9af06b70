"""Random streams: draws depend on seed and position only, never on threads or other stages.

Every stage has a unique id and draws from Philox(SeedSequence([seed, stage id, frame number, block]))
for each block of 64 full-width rows. Fixed patterns belong to the sensor: they are drawn likewise from its
serial number, for blocks of the *full frame*, of which a window takes its part.
"""

from __future__ import annotations

import threading

import numpy as np

from camsim.core.arrays import F32
from camsim.errors import InvalidValueError

BLOCK_ROWS = 64
_AT_ONCE = 1 << 18  # normals that fit in a processor's cache

# Blocks of fixed patterns, normals of one, and normals of all: 64 MiB.
_MOST_CACHED, _LARGEST_CACHED, _ALL_CACHED = 256, 1 << 18, 1 << 24
_CACHED: dict[tuple[object, ...], F32] = {}
_CACHE_LOCK = threading.Lock()


def generator(seed: int, stream: int, *, block: int, frame_number: int = 0, read_out: int = 0) -> np.random.Generator:
    """Return the generator of one stage in one block of rows of one frame.

    stream   : the stage's id (``ElectronicStage.stream``)
    read_out : index among those of one exposure; 0 adds nothing to the seed sequence

    >>> generator(7, 2, block=0).random() == generator(7, 2, block=0).random()
    True
    """
    if not 0 <= seed < 2**63:
        raise InvalidValueError(f"{seed}; must be a whole number from 0 to 2^63 − 1", key="seed")
    words = [int(seed), int(stream), int(frame_number), int(block), *([int(read_out)] if read_out else [])]
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(words)))


def fixed_normals(serial: int, stream: int, *, rows: int, cols: int, origin: tuple[int, int], frame_cols: int) -> F32:
    """Return (rows, cols) standard normals that belong to the sensor's photosites from ``origin`` on.

    origin     : (row, col) of the first photosite in the full frame
    frame_cols : width of the full frame

    A window's normals are exactly that slice of the full frame's. 24 bits of a normal suffice: they are multiplied
    by a standard deviation and added to a number that is rounded far more coarsely. They are 0 beyond the left,
    right and upper edges of the frame. Those of windows up to 4096 wide are cached for the next exposure, read-only.
    """
    key = serial, stream, rows, cols, origin, frame_cols
    with _CACHE_LOCK:
        if (known := _CACHED.pop(key, None)) is not None:
            _CACHED[key] = known  # most recently used, so evicted last
            return known
    normals = _drawn(serial, stream, rows=rows, cols=cols, origin=origin, frame_cols=frame_cols)
    if normals.size <= _LARGEST_CACHED:
        normals.flags.writeable = False
        with _CACHE_LOCK:
            _CACHED[key] = normals
            while len(_CACHED) > _MOST_CACHED or sum(each.size for each in _CACHED.values()) > _ALL_CACHED:
                del _CACHED[next(iter(_CACHED))]
    return normals


def _drawn(serial: int, stream: int, *, rows: int, cols: int, origin: tuple[int, int], frame_cols: int) -> F32:
    normals = np.zeros((rows, cols), dtype=np.float32)
    first_row, first_col = origin
    stop_row, stop_col = first_row + rows, min(first_col + cols, frame_cols)
    left = max(first_col, 0)
    row = max(first_row, 0)
    while row < stop_row:
        block, skipped = divmod(row, BLOCK_ROWS)
        stop = min((block + 1) * BLOCK_ROWS, stop_row)
        # A block is drawn row by row: rows before the window are drawn too, those after it are not.
        drawing = generator(serial, stream, block=block)
        _pass_over(drawing, skipped * frame_cols)
        together = max(1, _AT_ONCE // frame_cols)
        for first in range(row, stop, together):
            last = min(first + together, stop)
            for begin in range(0, frame_cols, _AT_ONCE):
                part = drawing.standard_normal((last - first, min(_AT_ONCE, frame_cols - begin)), dtype=np.float32)
                low, high = (min(max(col - begin, 0), part.shape[1]) for col in (left, stop_col))
                place = begin - first_col
                normals[first - first_row : last - first_row, place + low : place + high] = part[:, low:high]
        row = stop
    return normals


def _pass_over(drawing: np.random.Generator, count: int) -> None:
    """Draw and discard normals in parts, so that memory does not grow with the width of the frame."""
    while count > 0:
        drawing.standard_normal(min(count, _AT_ONCE), dtype=np.float32)
        count -= _AT_ONCE


def fixed_count(rows: int, *, first_row: int, frame_cols: int) -> int:
    """Return how many normals ``fixed_normals`` draws when called for BLOCK_ROWS rows at a time.

    Each call within a block of the frame starts again at the top of the block.
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
