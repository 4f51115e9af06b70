"""The directories of an untrusted TIFF or DNG: any count and any offset may be wrong.

Classic and big files of either byte order, from any writer.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import BinaryIO, Literal

from camsim.errors import InputError

SUBFILE_TYPE, IMAGE_WIDTH, IMAGE_LENGTH, IMAGE_DESCRIPTION = 254, 256, 257, 270
COMPRESSION, LOSSLESS_JPEG = 259, 7
STRIP_OFFSETS, STRIP_BYTE_COUNTS = 273, 279
TILE_OFFSETS, TILE_BYTE_COUNTS = 324, 325
SUB_DIRECTORIES = 330
XMP, DNG_VERSION, RAW_DATA_UNIQUE_ID = 700, 50706, 50781

_REDUCED, _MASK = 1, 4  # bits of the subfile's type

MAGICS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
MAKERS_MAGICS = (b"IIRO", b"IIRS", b"MMOR", b"IIU\0")
"""Olympus and Panasonic use other magic numbers than TIFF's 42."""

_CODES = {
    1: "B", 2: "s", 3: "H", 4: "I", 5: "II", 6: "b", 7: "s", 8: "h", 9: "i", 10: "ii", 11: "f", 12: "d",
    13: "I", 16: "Q", 17: "q", 18: "Q",
}  # fmt: skip
"""struct's letters of TIFF's types: BYTE, ASCII, SHORT, LONG, RATIONAL, SBYTE, UNDEFINED, SSHORT, SLONG, SRATIONAL,
FLOAT, DOUBLE, IFD, and the big file's LONG8, SLONG8, IFD8."""

_NUMBERS = "BHIQ"
_FRACTIONS = ("II", "ii")
_LONGEST_NUMBERS = 4 << 20
"""Bytes of numbers in one tag: offsets of half a million pieces."""

_MOST_DIRECTORIES = 64
_MOST_ENTRIES = 4096


@dataclass(frozen=True, slots=True)
class Form:
    """Number format of a file: byte order in struct's notation, and whether offsets have 64 bits."""

    order: Literal["<", ">"]
    big: bool

    @property
    def offset(self) -> struct.Struct:
        """One offset."""
        return struct.Struct(f"{self.order}{'Q' if self.big else 'I'}")

    @property
    def count(self) -> struct.Struct:
        """How many entries a directory has."""
        return struct.Struct(f"{self.order}{'Q' if self.big else 'H'}")

    @property
    def entry(self) -> struct.Struct:
        """Number, type, count and value (or its offset) of one entry."""
        return struct.Struct(f"{self.order}HH{'Q8s' if self.big else 'I4s'}")


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a directory, with values not yet read."""

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
    form: Form
    entries: Mapping[int, Entry]
    following: int = 0

    def bytes_of(self, number: int, most: int) -> bytes:
        """Return the bytes of a tag (empty if absent); raises InputError over ``most`` bytes."""
        entry = self.entries.get(number)
        if entry is None:
            return b""
        if entry.size <= len(entry.field):
            return entry.field[: entry.size]
        if entry.size > most:
            raise InputError(f"tag {number} holds {entry.size} bytes, and {most} are the most that are read")
        at = self._offset(entry)
        if at + entry.size > self.size:
            raise InputError(f"it ends at byte {self.size}, before the end of its tag {number}")
        self.file.seek(at)
        return self.file.read(entry.size)

    def numbers(self, number: int) -> tuple[int, ...]:
        """Return the integers of a tag; empty if absent or of another type."""
        entry = self.entries.get(number)
        if entry is None or entry.code not in _NUMBERS:
            return ()
        return struct.unpack(
            f"{self.form.order}{entry.count}{entry.code}", self.bytes_of(number, min(_LONGEST_NUMBERS, self.size))
        )

    def number(self, number: int, default: int | None = None) -> int:
        """Return the single number of a tag; ``default`` if absent."""
        if default is not None and number not in self.entries:
            return default
        values = self.numbers(number)
        if len(values) != 1:
            raise InputError(f"its tag {number} holds {len(values)} numbers where one belongs")
        return values[0]

    def values(self, number: int) -> tuple[float, ...]:
        """Return the numbers of a tag, fractions divided; empty if absent."""
        entry = self.entries.get(number)
        if entry is None or entry.code == "s":
            return ()
        code = f"{self.form.order}{entry.count * len(entry.code)}{entry.code[0]}"
        found = struct.unpack(code, self.bytes_of(number, min(_LONGEST_NUMBERS, self.size)))
        if entry.code not in _FRACTIONS:
            if not all(map(math.isfinite, found)):
                raise InputError(f"its tag {number} holds values that are no numbers")
            return tuple(map(float, found))
        if 0 in found[1::2]:
            raise InputError(f"its tag {number} holds a fraction over zero")
        return tuple(a / b for a, b in zip(found[::2], found[1::2], strict=True))

    def below(self, number: int) -> Directory | None:
        """Return the directory that a tag points to; None if absent."""
        at = self.number(number, 0)
        return _directory(self.file, self.size, self.form, at) if at else None

    def pieces(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return offsets and sizes of the image's strips or tiles; all of which are within the file."""
        kinds = (STRIP_OFFSETS, STRIP_BYTE_COUNTS), (TILE_OFFSETS, TILE_BYTE_COUNTS)
        offsets, counts = next((pair for kind in kinds if (pair := tuple(map(self.numbers, kind)))[0]), ((), ()))
        if not offsets or len(offsets) != len(counts):
            raise InputError("its directory names no image")
        end = max(at + count for at, count in zip(offsets, counts, strict=True))
        if end > self.size:
            raise InputError(f"it is cut short: it has {self.size} bytes and its image ends at byte {end}")
        return offsets, counts

    def refuse_truncated(self) -> None:
        """Raise InputError if the image or a tag's values exceed the file."""
        for number, entry in self.entries.items():
            if entry.size > len(entry.field) and self._offset(entry) + entry.size > self.size:
                raise InputError(f"it ends at byte {self.size}, before the end of its tag {number}")
        self.pieces()

    def _offset(self, entry: Entry) -> int:
        at: int = self.form.offset.unpack(entry.field)[0]
        return at


def read_directory(file: BinaryIO, size: int) -> Directory:
    """Read the first directory."""
    form, at = _begin(file)
    return _directory(file, size, form, at)


def read_image_directory(file: BinaryIO, size: int) -> Directory:
    """Read the directory of the largest image of the file; raises InputError if several are equally large.

    Those declared reduced or masks are skipped.
    """
    pages = list(_pages(file, size, set())) or [read_directory(file, size)]
    images = [page for page in pages if not page.number(SUBFILE_TYPE, 0) & (_REDUCED | _MASK)] or pages[:1]
    pixels = [page.number(IMAGE_LENGTH, 0) * page.number(IMAGE_WIDTH, 0) for page in images]
    if pixels.count(max(pixels)) > 1:
        raise InputError(
            f"it holds {pixels.count(max(pixels))} pages of one size, and nobody knows which is meant; "
            "save one as a separate file"
        )
    return images[pixels.index(max(pixels))]


def read_directories(file: BinaryIO, size: int) -> Iterator[Directory]:
    """Yield all directories, each followed by its sub-directories."""
    seen: set[int] = set()
    for page in _pages(file, size, seen):
        yield page
        for below in page.numbers(SUB_DIRECTORIES):
            yield _directory(file, size, page.form, _fresh(below, seen))


def _pages(file: BinaryIO, size: int, seen: set[int]) -> Iterator[Directory]:
    """Yield chained directories; ``seen``: offsets of directories already read, which is updated."""
    form, at = _begin(file)
    while at:
        page = _directory(file, size, form, _fresh(at, seen))
        yield page
        at = page.following


def _fresh(at: int, seen: set[int]) -> int:
    if at in seen or len(seen) >= _MOST_DIRECTORIES:
        raise InputError(f"its directories are a circle, or more than {_MOST_DIRECTORIES}")
    seen.add(at)
    return at


def _begin(file: BinaryIO) -> tuple[Form, int]:
    """Return the file's form and the offset of its first directory."""
    file.seek(0)
    head = file.read(16).ljust(16, b"\0")
    if head[:4] not in MAGICS + MAKERS_MAGICS:
        raise InputError("it is no TIFF and no DNG")
    form = Form("<" if head[:2] == b"II" else ">", b"+" in head[:4])
    at: int = form.offset.unpack_from(head, 8 if form.big else 4)[0]
    return form, at


def _directory(file: BinaryIO, size: int, form: Form, at: int) -> Directory:
    if at + form.count.size <= size:
        file.seek(at)
        (count,) = form.count.unpack(file.read(form.count.size))
        after = at + form.count.size + form.entry.size * count
        if 0 < count <= _MOST_ENTRIES and after <= size:
            found = list(form.entry.iter_unpack(file.read(form.entry.size * count)))
            following = file.read(form.offset.size)
            entries = {number: Entry(_CODES[kind], n, field) for number, kind, n, field in found if kind in _CODES}
            # Some writers omit the pointer to the next directory at the end of the file.
            (then,) = form.offset.unpack(following) if len(following) == form.offset.size else (0,)
            return Directory(file, size, form, entries, then)
    raise InputError(f"it is cut short: its directory is not within its {size} bytes")
