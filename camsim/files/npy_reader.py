"""Untrusted arrays in numpy's format: plain numbers only, never objects."""

from __future__ import annotations

import math
import re
import struct
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError

MAGIC = b"\x93NUMPY"

_LONGEST_HEADER = 4096
_MOST_DIMENSIONS = 8
_DESCR = re.compile(r"'descr':\s*'([<>|=]?[biuf][1248])'")
_ORDER = re.compile(r"'fortran_order':\s*(True|False)")
_SHAPE = re.compile(r"'shape':\s*\(([0-9 ,]*)\)")
_KEYS = re.compile(r"'\w+'\s*:")


@dataclass(frozen=True, slots=True)
class Header:
    """Shape and type of an array, and the size of its header."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran_order: bool
    bytes_before: int

    @property
    def nbytes(self) -> int:
        """Bytes of the numbers."""
        return math.prod(self.shape) * self.dtype.itemsize

    def shaped(self, data: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return flat data in the array's shape."""
        return data.reshape(self.shape, order="F" if self.fortran_order else "C")


def read_header(file: Any) -> Header:
    """Read the header of an array at the current position; raises InputError unless it is an array of numbers."""
    begin = file.read(8)
    if begin[:6] != MAGIC or len(begin) < 8:
        raise InputError("it is no array of numpy's")
    wide = begin[6] != 1
    (length,) = struct.unpack("<I" if wide else "<H", file.read(4 if wide else 2).ljust(4 if wide else 2, b"\0"))
    if begin[6] not in (1, 2, 3) or length > _LONGEST_HEADER:
        raise InputError(f"the header of its array has version {begin[6]} and {length} bytes, which numpy never writes")
    text = file.read(length).decode("latin-1")
    if len(text) < length:
        raise InputError("it is cut short: it ends within the header of its array")
    # Parsed as a literal, never evaluated.
    said = [pattern.findall(text) for pattern in (_DESCR, _ORDER, _SHAPE)]
    if any(len(found) != 1 for found in said) or len(_KEYS.findall(text)) != 3:
        raise InputError("its array holds no plain numbers (objects, tables and texts are not read)")
    (descr,), (order,), (sizes,) = said
    shape = tuple(int(size) for size in sizes.replace(" ", "").split(",") if size and len(size) < 20)
    try:
        dtype = np.dtype(descr)
    except TypeError:
        raise InputError(f"its array holds numbers of the kind {descr!r}, which there is not") from None
    if len(shape) > _MOST_DIMENSIONS or len(shape) != len([size for size in sizes.split(",") if size.strip()]):
        raise InputError("its array has more dimensions, or longer ones, than an image")
    return Header(dtype, shape, order == "True", len(begin) + (4 if wide else 2) + length)


def read_array(file: BinaryIO, size: int) -> npt.NDArray[Any]:
    """Return the array of a file, memory-mapped."""
    file.seek(0)
    header = read_header(file)
    if header.bytes_before + header.nbytes > size:
        raise InputError(
            f"it is cut short: it has {size} bytes and its array of {header.shape} needs "
            f"{header.bytes_before + header.nbytes}"
        )
    if not header.nbytes:
        raise InputError(f"its array of {header.shape} is empty")
    return header.shaped(np.memmap(file, header.dtype, "r", header.bytes_before, math.prod(header.shape)))
