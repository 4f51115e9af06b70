"""OpenEXR: electrons as 32-bit floating-point numbers, ZIP-compressed, with the description as attributes.

Half floats would not do: they step by 16 e⁻ at 30 000 and end at 65 504.
"""

from __future__ import annotations

import errno
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np

from camsim.arrays import F32, F64
from camsim.files.describe import description_hash, error_text, exif_datetime, record_json, software
from camsim.frame import Frame

_ROWS_PER_CHUNK = 16
"""Of ZIP compression, by the format's definition."""


def write_truth(frame: Frame, path: Path) -> None:
    """Write the mean electrons of every channel at every photosite, one plane per channel."""
    assert frame.truth is not None
    planes = {name: frame.truth[:, :, index] for index, name in enumerate(frame.channels)}
    _write(frame, "truth", planes, path)


def write_electrons(frame: Frame, path: Path) -> None:
    """Write each photosite's own electrons: layer ``mean`` before noise, layer ``noisy`` after."""
    _write(frame, "electrons", {"mean.Y": frame.mean_electrons, "noisy.Y": frame.electrons}, path)


def _write(frame: Frame, product: str, planes: Mapping[str, F32 | F64], path: Path) -> None:
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "capDate": exif_datetime(frame),
        "expTime": float(frame.time_s),
        "aperture": float(frame.f_number),
        "isoSpeed": float(frame.iso),
        "software": software(),
        # Text, because OpenEXR's integers have 32 bits and its numbers single precision.
        "camsim:seed": str(frame.seed),
        "camsim:errorEstimate": error_text(frame, product),
        "camsim:units": "electrons",
        "camsim:product": product,
        "camsim:descriptionSHA256": description_hash(frame),
        "camsim:record": record_json(frame, product),
    }
    channels = {name: np.ascontiguousarray(plane, dtype=np.float32) for name, plane in planes.items()}
    try:
        OpenEXR.File(header, channels).write(str(path))
    except RuntimeError as error:
        code = next((code for code in errno.errorcode if os.strerror(code) in str(error)), errno.EIO)
        raise OSError(code, os.strerror(code)) from error
    with path.open("rb") as file:
        if _last_byte(file, frame.mosaic.shape[0]) != file.seek(0, os.SEEK_END):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _last_byte(file: BinaryIO, rows: int) -> int:
    """Return where the file must end by its own chunk table.

    The library ignores what the system says when it closes a file, so a small one on a full disk ends early
    without an error.
    """

    def name() -> bytes:
        letters = b""
        while (letter := file.read(1)) not in (b"\0", b""):
            letters += letter
        return letters

    file.seek(8)
    while name():
        name()
        (size,) = struct.unpack("<i", file.read(4).ljust(4, b"\0"))
        file.seek(size, os.SEEK_CUR)
    file.seek(8 * ((rows - 1) // _ROWS_PER_CHUNK), os.SEEK_CUR)
    (last_chunk,) = struct.unpack("<q", file.read(8).ljust(8, b"\0"))
    file.seek(last_chunk + 4)
    (size,) = struct.unpack("<i", file.read(4).ljust(4, b"\0"))
    return int(last_chunk + 8 + size)
