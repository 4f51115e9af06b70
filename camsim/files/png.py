"""PNG: the developed preview, or the raw codes as 16-bit grey."""

from __future__ import annotations

import io
from pathlib import Path

from camsim.camera.frame import Frame
from camsim.core.arrays import U8, U16
from camsim.files.atomic import write_chunks
from camsim.files.describe import record_json
from camsim.files.preview import develop

_DEFLATE_LEVEL = 3
"""Level 6 takes up to 1.6 times as long on a noisy frame, for 3-5 % fewer bytes."""

_SMALLEST_DISPLAYED, _LARGEST_DISPLAYED = 240, 800
"""Pixels along the longer side of pictures in notebooks."""


def write_preview(frame: Frame, path: Path) -> None:
    """Write the preview: 8-bit sRGB, or grey for mono."""
    _write(develop(frame), frame, "preview", path)


def write_mosaic(frame: Frame, path: Path) -> None:
    """Write the raw codes as 16-bit grey, black level included."""
    _write(frame.mosaic, frame, "mosaic", path)


def picture(pixels: U8) -> bytes:
    """Return pixels as PNG for viewing, without a record: small pictures enlarged, large ones reduced.

    A notebook stores every picture in its file.
    """
    from PIL import Image

    longest = max(pixels.shape[:2])
    displayed = Image.fromarray(pixels)
    if longest > _LARGEST_DISPLAYED:
        displayed.thumbnail((_LARGEST_DISPLAYED, _LARGEST_DISPLAYED), Image.Resampling.BOX)
    else:
        times = max(1, _SMALLEST_DISPLAYED // longest)
        displayed = displayed.resize((displayed.width * times, displayed.height * times), Image.Resampling.NEAREST)
    buffer = io.BytesIO()
    displayed.save(buffer, format="png")
    return buffer.getvalue()


def plain(pixels: U8) -> bytes:
    """Return pixels as PNG without a record."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="png", compress_level=_DEFLATE_LEVEL)
    return buffer.getvalue()


def _write(pixels: U8 | U16, frame: Frame, product: str, path: Path) -> None:
    from PIL import Image, PngImagePlugin

    text = PngImagePlugin.PngInfo()
    text.add_text("camsim", record_json(frame, product), zip=True)
    # In memory first: Pillow's writing does not report a full disk.
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="png", pnginfo=text, compress_level=_DEFLATE_LEVEL)
    write_chunks(path, (buffer.getbuffer(),))
