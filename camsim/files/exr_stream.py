"""An OpenEXR file written scan line by scan line: memory does not grow with the image.

The OpenEXR package's class holds the whole image, and its older streaming one drops unknown attributes.
 The format is open: one part, scan lines, 32-bit channels, ZIP of 16 rows (OpenEXR File Layout).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from camsim.core.arrays import F32
from camsim.core.cores import cores
from camsim.core.kernels import ahead
from camsim.files.exr_reader import MAGIC

ROWS_PER_CHUNK = 16
"""Rows per chunk of ZIP compression, by the format's definition."""

_ZIP, _FLOAT, _INCREASING_Y = 3, 2, 0
_DEFLATE_LEVEL = 4
"""OpenEXR's default."""

_AHEAD_BYTES = 16 << 20
"""Most bytes of chunks waiting to be written; at least one chunk for each core."""


def write_exr(
    path: Path,
    *,
    rows: int,
    cols: int,
    channels: Sequence[str],
    attributes: Mapping[str, str | float],
    block: Callable[[int, int], F32],
) -> None:
    """Write float32 channels.

    channels   : names, ascending
    attributes : custom texts and numbers besides the format's
    block      : (first row, number of rows) → (channels, that many rows, cols)
    """
    starts = range(0, rows, ROWS_PER_CHUNK)
    header = _header(rows, cols, channels, attributes)
    with path.open("wb") as file:
        file.write(header)
        file.write(bytes(8 * len(starts)))
        offsets = []
        most = max(cores(), _AHEAD_BYTES // (4 * ROWS_PER_CHUNK * cols * len(channels)))
        # zlib releases the GIL, so threads help.
        for first, packed in zip(starts, ahead(_zip, _chunks(starts, rows, block), most), strict=True):
            offsets.append(file.tell())
            file.write(struct.pack("<ii", first, len(packed)))
            file.write(packed)
        file.seek(len(header))
        file.write(struct.pack(f"<{len(offsets)}Q", *offsets))


def _chunks(starts: range, rows: int, block: Callable[[int, int], F32]) -> Iterator[bytes]:
    """Yield the bytes of each chunk: channel after channel within a row, row after row."""
    for first in starts:
        lines = np.swapaxes(block(first, min(ROWS_PER_CHUNK, rows - first)), 0, 1)
        yield np.ascontiguousarray(lines, dtype="<f4").tobytes()


def _zip(raw: bytes) -> bytes:
    """Compress as OpenEXR does: bytes of even places first, differences of neighbours, deflate."""
    values = np.frombuffer(raw, np.uint8)
    parted = np.concatenate([values[::2], values[1::2]])
    # uint8 arithmetic wraps intentionally.
    parted[1:] = np.diff(parted) + np.uint8(128)
    packed = zlib.compress(parted.tobytes(), _DEFLATE_LEVEL)
    return packed if len(packed) < len(raw) else raw


def _header(rows: int, cols: int, channels: Sequence[str], attributes: Mapping[str, str | float]) -> bytes:
    window = struct.pack("<4i", 0, 0, cols - 1, rows - 1)
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", _FLOAT, 0, 1, 1) for name in channels)
    fields = [
        ("channels", "chlist", listed + b"\0"),
        ("compression", "compression", bytes([_ZIP])),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", bytes([_INCREASING_Y])),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    for name, value in attributes.items():
        fields.append(
            (name, "string", value.encode()) if isinstance(value, str) else (name, "float", struct.pack("<f", value))
        )
    body = b"".join(
        name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
        for name, kind, value in fields
    )
    return MAGIC + struct.pack("<i", 2) + body + b"\0"
