"""TIFF: the mosaic as a plain 16-bit grey image, with the description as JSON."""

from __future__ import annotations

import io
from pathlib import Path

from camsim.files.atomic import write_chunks
from camsim.files.describe import exif_datetime, record_json, software
from camsim.frame import Frame


def write_tiff(frame: Frame, path: Path) -> None:
    """Write the raw codes; a reader sees them as they are, black level included."""
    import tifffile

    # In memory first: tifffile's own writing does not say whether the disk is full.
    buffer = io.BytesIO()
    tifffile.imwrite(
        buffer,
        frame.mosaic,
        byteorder="<",
        photometric="minisblack",
        description=record_json(frame, "mosaic"),
        software=software(),
        datetime=exif_datetime(frame),
        metadata=None,
    )
    write_chunks(path, (buffer.getbuffer(),))
