"""JPEG: the size in its header, and the pixels of a complete file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, in_brief
from camsim.files.limits import refuse_bomb

MAGIC = b"\xff\xd8"

_ALONE = frozenset((0x01, *range(0xD0, 0xD9)))
"""Markers without a length."""

_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""SOF0 … SOF15; the three between them are tables."""


@dataclass(frozen=True, slots=True)
class FrameHeader:
    """The contents of a start-of-frame segment."""

    bits: int
    rows: int
    cols: int
    components: int


def frame_header(data: bytes) -> FrameHeader:
    """Find the start of the frame in the markers of a JPEG (ITU-T T.81, B.2.2), without decoding the JPEG."""
    at = 2 if data.startswith(MAGIC) else len(data)
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            break
        marker = data[at + 1]
        if marker == 0xFF:  # fill
            at += 1
        elif marker in _ALONE:
            at += 2
        elif marker in _FRAMES and at + 10 <= len(data):
            rows, cols = int.from_bytes(data[at + 5 : at + 7]), int.from_bytes(data[at + 7 : at + 9])
            if not rows or not cols:
                raise InputError(f"its JPEG says {rows} × {cols} pixels")
            return FrameHeader(data[at + 4], rows, cols, data[at + 9])
        elif marker == 0xDA:  # the scan begins without a frame
            break
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4])
    raise InputError("its JPEG is damaged: no frame begins in it")


def profile(data: bytes) -> bytes:
    """Return the first part of the ICC profile, empty for none."""
    return _noted(data, 0xE2, b"ICC_PROFILE\0")[2:]


def exif(data: bytes) -> bytes:
    """Return the EXIF data, empty if none."""
    return _noted(data, 0xE1, b"Exif\0\0")


def _noted(data: bytes, marker: int, name: bytes) -> bytes:
    """Return the data after the name in the first segment of a marker (APPn, before the frame) with that name."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] not in _FRAMES and data[at + 1] != 0xDA:
        length = int.from_bytes(data[at + 2 : at + 4])
        if data[at + 1] == marker and data[at + 4 : at + 4 + len(name)] == name:
            return data[at + 4 + len(name) : at + 2 + length]
        at += 1 if data[at + 1] == 0xFF else 2 + length
    return b""


def read_pixels(file: BinaryIO, size: int) -> npt.NDArray[Any]:
    """Return the pixels of a file, (rows, cols) or (rows, cols, channels)."""
    from PIL import JpegImagePlugin

    file.seek(0)
    frame = frame_header(file.read(size))
    if frame.components not in (1, 3):
        raise InputError(f"it has {frame.components} colours (CMYK, for printing); convert it to sRGB first")
    refuse_bomb(frame.rows * frame.cols * frame.components, size)
    file.seek(0)
    try:
        # Not Image.open, which tries all formats and has a process-wide limit.
        with JpegImagePlugin.JpegImageFile(file) as opened:
            if opened.size != (frame.cols, frame.rows):
                raise InputError("its JPEG has two frames of different sizes")
            return np.asarray(opened)
    except (OSError, SyntaxError, ValueError) as error:
        raise InputError(f"its JPEG is damaged ({in_brief(error)})") from None
