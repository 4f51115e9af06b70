"""Size and texts of a PNG, read with distrust."""

from __future__ import annotations

import struct
import zlib
from typing import BinaryIO

from camsim.errors import InputError

MAGIC = b"\x89PNG\r\n\x1a\n"


def read_png(file: BinaryIO, size: int, most: int) -> tuple[int, int, str | None]:
    """Return rows, columns and camsim's text (None: there is none); raises InputError on a damaged chunk.

    most : the longest text, unpacked, in bytes
    """
    file.seek(len(MAGIC))
    rows = cols = 0
    text = None
    while True:
        head = file.read(8)
        if len(head) < 8:
            raise InputError(f"it is cut short: it has {size} bytes and no end")
        length, kind = struct.unpack(">I4s", head)
        if file.tell() + length + 4 > size:
            raise InputError(f"it is cut short: it has {size} bytes and ends within its chunk {kind!r}")
        if kind == b"IEND":
            return rows, cols, text
        if kind not in (b"IHDR", b"zTXt"):
            file.seek(length + 4, 1)
            continue
        content = file.read(min(length, most))
        file.seek(length - len(content), 1)
        if file.read(4) != struct.pack(">I", zlib.crc32(kind + content)):
            raise InputError(f"its chunk {kind!r} is damaged (its checksum does not fit)")
        if kind == b"IHDR" and length == 13:
            cols, rows = struct.unpack(">2I", content[:8])
        elif content.startswith(b"camsim\0\0"):
            text = _unpacked(content[8:], most)


def _unpacked(packed: bytes, most: int) -> str:
    try:
        return zlib.decompressobj().decompress(packed, most).decode("latin-1")
    except zlib.error as error:
        raise InputError(f"its text is damaged ({error})") from None
