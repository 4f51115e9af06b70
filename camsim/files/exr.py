"""OpenEXR: electrons as 32-bit floating-point numbers, ZIP-compressed, with the description as attributes.

Half floats would not do: they step by 16 e⁻ at 30 000 and end at 65 504.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from camsim.arrays import F32, F64
from camsim.errors import InputError
from camsim.files.describe import description_hash, error_text, exif_datetime, record_json, software
from camsim.files.exr_reader import end_of_chunks, read_header
from camsim.frame import Frame


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
    _refuse_short(path)


def _refuse_short(path: Path) -> None:
    """Raise OSError when the file ends before its own table of chunks says.

    The library ignores what the system says when it closes a file, so a small one on a full disk ends early
    without an error.
    """
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        try:
            whole = end_of_chunks(file, read_header(file, size, size)) == size
        except InputError:
            whole = False
    if not whole:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
