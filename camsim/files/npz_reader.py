"""Untrusted archives of arrays (NPZ): directory and members are checked before they are read."""

from __future__ import annotations

import contextlib
import os
import struct
import zipfile
import zlib
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, did_you_mean, in_brief
from camsim.files.limits import refuse_bomb
from camsim.files.npy_reader import Header, read_header

MAGIC = b"PK\x03\x04"

_END = struct.Struct("<4s4H2IH")
_END_64 = struct.Struct("<4sQ2H2I4Q")
_LOCATOR = struct.Struct("<4sIQI")
_LONGEST_DIRECTORY = 1 << 16
"""Bytes, for a thousand arrays. The directory is read before anything else is known."""


class Archive:
    """The arrays of an open NPZ by name, and its texts."""

    def __init__(self, archive: zipfile.ZipFile, size: int) -> None:
        self._archive, self._size = archive, size
        self._members = {member.filename: member for member in archive.infolist()}

    @property
    def arrays(self) -> tuple[str, ...]:
        """Names of the arrays, as numpy gives them."""
        return tuple(name.removesuffix(".npy") for name in self._members if name.endswith(".npy"))

    def text(self, name: str, most: int) -> str | None:
        """Return a member as text; None if there is none of that name."""
        if name not in self._members:
            return None
        with self._opened(name) as member:
            words: bytes = member.read(most + 1)
        return words.decode("ascii", "replace")

    def header(self, name: str) -> Header:
        """Return the header of an array, consistent with the archive's size of the member."""
        with self._opened(f"{name}.npy") as member:
            return self._header(name, member)

    def array(self, name: str) -> npt.NDArray[Any]:
        """Return an array after verifying its checksum."""
        with self._opened(f"{name}.npy") as member:
            header = self._header(name, member)
            refuse_bomb(header.nbytes, self._size)
            numbers = np.empty(header.nbytes, np.uint8)
            filled = 0
            while filled < header.nbytes and (some := member.read(min(1 << 20, header.nbytes - filled))):
                numbers[filled : filled + len(some)] = np.frombuffer(some, np.uint8)
                filled += len(some)
            # The checksum is verified at the end of the member.
            if filled < header.nbytes or member.read(1):
                raise InputError(f"it is cut short or damaged: its array {name!r} is not whole")
        return header.shaped(numbers.view(header.dtype))

    def _header(self, name: str, member: Any) -> Header:
        header = read_header(member)
        if header.bytes_before + header.nbytes != self._members[f"{name}.npy"].file_size:
            raise InputError(f"its array {name!r} says {header.nbytes} bytes and does not hold as many")
        return header

    @contextlib.contextmanager
    def _opened(self, name: str) -> Iterator[Any]:
        if name not in self._members:
            raise InputError(f"it holds no {name!r}{did_you_mean(name, self._members)}")
        member = self._members[name]
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise InputError(f"its {name!r} is packed as numpy never does (method {member.compress_type})")
        with self._archive.open(member) as opened:
            yield opened


@contextlib.contextmanager
def opened(file: BinaryIO, size: int) -> Iterator[Archive]:
    """Open an archive; faults, now or on reading, are raised as InputError."""
    _refuse_long_directory(file, size)
    try:
        with zipfile.ZipFile(file) as archive:
            yield Archive(archive, size)
    except (
        zipfile.BadZipFile,
        zlib.error,
        EOFError,
        NotImplementedError,  # a version or method that zipfile does not support
        RuntimeError,  # encrypted
        struct.error,
        UnicodeDecodeError,
    ) as error:
        raise InputError(f"it is cut short or damaged ({in_brief(error)})") from None


def _refuse_long_directory(file: BinaryIO, size: int) -> None:
    """Raise InputError if the archive does not end like numpy's, or its directory is too long."""
    file.seek(max(0, size - _END.size))
    end = file.read(_END.size)
    if len(end) < _END.size or not end.startswith(b"PK\5\6") or not end.endswith(b"\0\0"):
        raise InputError("it is cut short or damaged: it does not end as an archive of arrays does")
    length = _END.unpack(end)[5]
    if size >= _END.size + _LOCATOR.size + _END_64.size:
        file.seek(size - _END.size - _LOCATOR.size - _END_64.size)
        end_64 = file.read(_END_64.size)
        if file.read(4) == b"PK\6\7":
            length = max(length if length != 0xFFFFFFFF else 0, _END_64.unpack(end_64)[8])
    file.seek(0, os.SEEK_SET)
    if length > _LONGEST_DIRECTORY:
        raise InputError(f"its directory has {length} bytes, and {_LONGEST_DIRECTORY} list a thousand arrays")
