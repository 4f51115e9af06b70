"""The container of a TIFF or DNG: classic, little-endian, with one IFD, its Exif IFD and the strips of one image.

Tag types and layout as in TIFF 6.0: the image first, so that it can be written while it is computed, then the
directories; entries ascending, values of more than four bytes after them at even offsets.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from camsim.errors import OutputError

_BYTE, _ASCII, _SHORT, _LONG, _RATIONAL, _UNDEFINED, _SRATIONAL, _DOUBLE = 1, 2, 3, 4, 5, 7, 10, 12

_EXIF_IFD = 34665
HEADER_BYTES = 8
_LARGEST_FILE = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Tag:
    """One entry of a directory: ``count`` values of TIFF type ``kind``, encoded."""

    number: int
    kind: int
    count: int
    payload: bytes


def byte(number: int, values: bytes | Sequence[int]) -> Tag:
    """Return a tag of 8-bit numbers."""
    return Tag(number, _BYTE, len(values), bytes(values))


def undefined(number: int, values: bytes) -> Tag:
    """Return a tag of TIFF type UNDEFINED: raw bytes, whose meaning depends on the tag's number."""
    return Tag(number, _UNDEFINED, len(values), values)


def ascii_string(number: int, text: str) -> Tag:
    """Return a tag of ASCII text; the terminating zero is added."""
    payload = text.encode("ascii") + b"\0"
    return Tag(number, _ASCII, len(payload), payload)


def short(number: int, *values: int) -> Tag:
    """Return a tag of 16-bit numbers."""
    _refuse_beyond(values, 2**16 - 1)
    return Tag(number, _SHORT, len(values), struct.pack(f"<{len(values)}H", *values))


def long(number: int, *values: int) -> Tag:
    """Return a tag of 32-bit numbers."""
    _refuse_beyond(values, 2**32 - 1)
    return Tag(number, _LONG, len(values), struct.pack(f"<{len(values)}I", *values))


def rational(number: int, *values: float) -> Tag:
    """Return a tag of non-negative fractions, each the nearest with 32-bit parts."""
    parts = [part for value in values for part in fraction(value, 2**32 - 1)]
    return Tag(number, _RATIONAL, len(values), struct.pack(f"<{len(parts)}I", *parts))


def srational(number: int, *values: float) -> Tag:
    """Return a tag of signed fractions, each the nearest with 32-bit parts."""
    parts = [part for value in values for part in fraction(value, 2**31 - 1)]
    return Tag(number, _SRATIONAL, len(values), struct.pack(f"<{len(parts)}i", *parts))


def double(number: int, *values: float) -> Tag:
    """Return a tag of 64-bit floating-point numbers."""
    return Tag(number, _DOUBLE, len(values), struct.pack(f"<{len(values)}d", *values))


def _refuse_beyond(values: Iterable[int], largest: int) -> None:
    for value in values:
        if not 0 <= value <= largest:
            raise OutputError(f"{value:g} does not fit into a TIFF file, whose tag for it holds 0 to {largest}")


def fraction(value: float, largest: int) -> tuple[int, int]:
    """Return the simplest fraction within 1e-9 or so of ``value``, neither part above ``largest``.

    >>> fraction(0.01, 2**32 - 1), fraction(5.6, 2**32 - 1), fraction(86400.0, 2**32 - 1)
    ((1, 100), (28, 5), (86400, 1))
    """
    whole = abs(value)
    if whole > largest:
        raise OutputError(f"{value:g} is too large for a TIFF file, which holds fractions up to {largest}")
    nearest = Fraction(value).limit_denominator(min(10**9, max(1, int(largest / max(whole, 1.0)))))
    return nearest.numerator, nearest.denominator


def refuse_over_4_gib(size_bytes: int) -> None:
    """Raise OutputError for sizes beyond 32-bit offsets."""
    if size_bytes > _LARGEST_FILE:
        raise OutputError(
            f"the image needs {size_bytes / 2**30:.1f} GiB and a TIFF or DNG file holds 4 GiB at most; "
            "write .npy, or capture a smaller region"
        )


def header(directory_at: int) -> bytes:
    """Return the header of a file with directories at ``directory_at``, an even offset."""
    refuse_over_4_gib(directory_at)
    return struct.pack("<2sHI", b"II", 42, directory_at)


def directories(tags: Iterable[Tag], exif: Iterable[Tag], at: int) -> tuple[bytes, int]:
    """Return both directories with their values, for file offset ``at``, and the offset of the main one.

    Exif's comes first, so that the main one ends the file and reveals truncation; the tag that points
    to Exif's is added.
    """
    below = _ifd(exif, at)
    main_at = at + len(below)
    main = _ifd((*tags, long(_EXIF_IFD, at)), main_at)
    refuse_over_4_gib(main_at + len(main))
    return below + main, main_at


def _ifd(tags: Iterable[Tag], at: int) -> bytes:
    """Return one directory at file offset ``at``, followed by its values."""
    ordered = sorted(tags, key=lambda tag: tag.number)
    values_at = at + 2 + 12 * len(ordered) + 4
    entries, values = [struct.pack("<H", len(ordered))], bytearray()
    for tag in ordered:
        if len(tag.payload) <= 4:
            field = tag.payload.ljust(4, b"\0")
        else:
            field = struct.pack("<I", values_at + len(values))
            values += tag.payload + b"\0" * (len(tag.payload) % 2)
        entries.append(struct.pack("<HHI", tag.number, tag.kind, tag.count) + field)
    # The next-directory pointer is zero: there is one image.
    return b"".join(entries) + struct.pack("<I", 0) + bytes(values)
