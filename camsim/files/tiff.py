"""TIFF: the mosaic as a plain 16-bit grey image, or the truth as 32-bit electrons; the description as JSON."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Literal

from camsim.camera.frame import Frame
from camsim.core.arrays import F32, U16
from camsim.files.atomic import write_chunks
from camsim.files.describe import exif_datetime, record_json, software


def write_mosaic(frame: Frame, path: Path) -> None:
    """Write the raw codes, black level included."""
    _write(frame, "mosaic", frame.mosaic, "minisblack", path)


def write_truth(frame: Frame, path: Path) -> None:
    """Write the mean electrons of every channel as 32-bit floating-point numbers, one sample a channel."""
    truth = frame.truth
    assert truth is not None
    if len(frame.channels) == 3:
        _write(frame, "truth", truth, "rgb", path)
    else:
        _write(frame, "truth", truth[:, :, 0] if len(frame.channels) == 1 else truth, "minisblack", path)


def _write(
    frame: Frame, product: str, pixels: U16 | F32, photometric: Literal["minisblack", "rgb"], path: Path
) -> None:
    import tifffile

    # In memory first: tifffile's writing does not report a full disk.
    buffer = io.BytesIO()
    tifffile.imwrite(
        buffer,
        pixels,
        byteorder="<",
        photometric=photometric,
        planarconfig="contig" if pixels.ndim == 3 else None,
        description=record_json(frame, product),
        software=software(),
        datetime=exif_datetime(frame),
        metadata=None,
    )
    write_chunks(path, (buffer.getbuffer(),))
