"""The header of an OpenEXR file, read with distrust, and where its last chunk must end."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO

from camsim.errors import InputError

MAGIC = struct.pack("<i", 20000630)

_LONGEST_NAME = 255
_MOST_ATTRIBUTES = 4096
_ROWS_PER_CHUNK = {0: 1, 2: 1, 3: 16}
"""By the format's code of the compression: none, one row by ZIP, 16 rows by ZIP."""


@dataclass(frozen=True, slots=True)
class Header:
    """Attributes by name, as type and bytes, and the offset of the table of chunks behind them."""

    attributes: Mapping[str, tuple[str, bytes]]
    chunk_table: int

    def text(self, name: str) -> str | None:
        """Return a string attribute; None when it is not there or is something else."""
        kind, value = self.attributes.get(name, ("", b""))
        return value.decode("utf-8", "replace") if kind == "string" else None

    def size(self) -> tuple[int, int]:
        """Return rows and columns."""
        kind, value = self.attributes.get("dataWindow", ("", b""))
        if kind != "box2i" or len(value) != 16:
            raise InputError("its header has no dataWindow")
        left, top, right, bottom = struct.unpack("<4i", value)
        if right < left or bottom < top:
            raise InputError("its dataWindow is empty")
        return bottom - top + 1, right - left + 1


def read_header(file: BinaryIO, size: int, most: int) -> Header:
    """Read the attributes of a file of one part; raises InputError over ``most`` bytes of them."""
    file.seek(8)
    attributes: dict[str, tuple[str, bytes]] = {}
    for _ in range(_MOST_ATTRIBUTES):
        name = _name(file)
        if not name:
            return Header(attributes, file.tell())
        kind = _name(file)
        (length,) = struct.unpack("<i", file.read(4).ljust(4, b"\xff"))
        if not 0 <= length <= most:
            raise InputError(f"its attribute {name!r} has {length} bytes, which camsim never writes")
        value = file.read(length)
        if len(value) < length:
            raise InputError(f"it is cut short: it has {size} bytes and ends within its header")
        attributes[name] = kind, value
        most -= length
    raise InputError("its header has no end")


def end_of_chunks(file: BinaryIO, header: Header) -> int:
    """Return where the file must end by its own table of chunks; 0 when the table is not whole."""
    rows, _ = header.size()
    kind, compression = header.attributes.get("compression", ("", b""))
    rows_per_chunk = _ROWS_PER_CHUNK.get(compression[0]) if kind == "compression" and compression else None
    if rows_per_chunk is None:
        raise InputError("it has a compression that camsim never writes")
    file.seek(header.chunk_table + 8 * ((rows - 1) // rows_per_chunk))
    (last,) = struct.unpack("<Q", file.read(8).ljust(8, b"\0"))
    if not 0 < last < 1 << 62:
        return 0
    file.seek(last + 4)
    (length,) = struct.unpack("<i", file.read(4).ljust(4, b"\xff"))
    return last + 8 + length if length > 0 else 0


def _name(file: BinaryIO) -> str:
    letters = bytearray()
    while (letter := file.read(1)) not in (b"\0", b""):
        letters += letter
        if len(letters) > _LONGEST_NAME:
            raise InputError("its header holds a name that never ends")
    return letters.decode("latin-1")
