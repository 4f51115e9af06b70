"""The main directory of a TIFF or DNG, read with distrust: any count and any offset may be wrong."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO

from camsim.errors import InputError

IMAGE_WIDTH, IMAGE_LENGTH, IMAGE_DESCRIPTION = 256, 257, 270
COMPRESSION, LOSSLESS_JPEG = 259, 7
STRIP_OFFSETS, STRIP_BYTE_COUNTS = 273, 279
TILE_OFFSETS, TILE_BYTE_COUNTS = 324, 325
XMP, DNG_VERSION = 700, 50706

_CODES = {1: "B", 2: "s", 3: "H", 4: "I", 5: "II", 7: "s", 9: "i", 10: "ii", 12: "d"}
"""struct's letters of TIFF's types: BYTE, ASCII, SHORT, LONG, RATIONAL, UNDEFINED, SLONG, SRATIONAL, DOUBLE."""

_NUMBERS = "BHI"

_ENTRY = struct.Struct("<HHI4s")


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of the directory, its values not read yet."""

    code: str
    count: int
    field: bytes

    @property
    def size(self) -> int:
        """Bytes of the values."""
        return self.count * struct.calcsize("<" + self.code)


@dataclass(frozen=True, slots=True)
class Directory:
    """Entries by tag number, and the file that their values are read from."""

    file: BinaryIO
    size: int
    entries: Mapping[int, Entry]

    def bytes_of(self, number: int, most: int) -> bytes:
        """Return the bytes of a tag (none: it is not there); raises InputError over ``most`` bytes."""
        entry = self.entries.get(number)
        if entry is None:
            return b""
        if entry.size <= 4:
            return entry.field[: entry.size]
        (at,) = struct.unpack("<I", entry.field)
        if entry.size > most:
            raise InputError(f"tag {number} holds {entry.size} bytes, which is more than camsim ever writes")
        self.file.seek(at)
        found = self.file.read(entry.size)
        if len(found) < entry.size:
            raise InputError(f"it ends at byte {self.size}, before the end of its tag {number}")
        return found

    def numbers(self, number: int) -> tuple[int, ...]:
        """Return the numbers of a tag of BYTE, SHORT or LONG; none when it is not there."""
        entry = self.entries.get(number)
        if entry is None or entry.code not in _NUMBERS:
            return ()
        return struct.unpack(f"<{entry.count}{entry.code}", self.bytes_of(number, 1 << 20))

    def number(self, number: int) -> int:
        """Return the only number of a tag."""
        values = self.numbers(number)
        if len(values) != 1:
            raise InputError(f"its tag {number} holds {len(values)} numbers where one belongs")
        return values[0]

    def refuse_truncated(self) -> None:
        """Raise InputError when the image or a tag's values end beyond the file."""
        for number, entry in self.entries.items():
            at = struct.unpack("<I", entry.field)[0] if entry.size > 4 else 0
            if at + entry.size > self.size:
                raise InputError(f"it ends at byte {self.size}, before the end of its tag {number}")
        kinds = (STRIP_OFFSETS, STRIP_BYTE_COUNTS), (TILE_OFFSETS, TILE_BYTE_COUNTS)
        offsets, counts = next((pair for kind in kinds if (pair := tuple(map(self.numbers, kind)))[0]), ((), ()))
        if not offsets or len(offsets) != len(counts):
            raise InputError("its directory names no image")
        end = max(at + count for at, count in zip(offsets, counts, strict=True))
        if end > self.size:
            raise InputError(f"it is cut short: it has {self.size} bytes and its image ends at byte {end}")


def read_directory(file: BinaryIO, size: int) -> Directory:
    """Read the first directory of a classic little-endian TIFF, which is the kind that camsim writes."""
    file.seek(4)
    (at,) = struct.unpack("<I", file.read(4).ljust(4, b"\0"))
    file.seek(at)
    (count,) = struct.unpack("<H", file.read(2).ljust(2, b"\0"))
    table = file.read(_ENTRY.size * count)
    if not count or len(table) < _ENTRY.size * count:
        raise InputError(f"it is cut short: its directory is not within its {size} bytes")
    found = (_ENTRY.unpack_from(table, _ENTRY.size * k) for k in range(count))
    entries = {number: Entry(_CODES[kind], n, field) for number, kind, n, field in found if kind in _CODES}
    return Directory(file, size, entries)
