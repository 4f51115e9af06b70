"""Grey pictures of Netpbm (PGM), binary and plain: a format of mosaics of scientific cameras and raw converters."""

from __future__ import annotations

import re
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError
from camsim.files.limits import refuse_bomb

_HEADER = re.compile(rb"(P[25])" + 3 * rb"(?:\s|#[^\n]*\n)+(\d{1,9})" + rb"(?:#[^\n]*\n|\s)")
_LONGEST_HEADER = 1 << 16


def read_pixels(file: BinaryIO, size: int) -> tuple[npt.NDArray[Any], float]:
    """Return the samples (rows, cols) and the declared largest value; raises InputError."""
    file.seek(0)
    found = _HEADER.match(file.read(_LONGEST_HEADER))
    if found is None:
        raise InputError("it is no PGM: P5 (or P2), columns, rows and the largest sample belong at its beginning")
    cols, rows, largest = (int(found[k]) for k in (2, 3, 4))
    if not cols or not rows or not 1 <= largest <= 65535:
        raise InputError(f"it says {rows} × {cols} samples of 0 to {largest}")
    dtype = np.dtype("u1" if largest < 256 else ">u2")
    refuse_bomb(rows * cols * dtype.itemsize, size)
    file.seek(found.end())
    if found[1] == b"P5":
        data = file.read(rows * cols * dtype.itemsize)
        if len(data) < rows * cols * dtype.itemsize:
            raise InputError(f"it is cut short: {rows} × {cols} samples need {rows * cols * dtype.itemsize} bytes")
        values: npt.NDArray[Any] = np.frombuffer(data, dtype)
    else:
        words = file.read().split()
        if len(words) < rows * cols or not all(word.isdigit() and len(word) < 6 for word in words[: rows * cols]):
            raise InputError(f"it holds no {rows} × {cols} whole numbers")
        values = np.array(words[: rows * cols]).astype(np.int64)
    if values.max() > largest:
        raise InputError(f"it holds {values.max()}, and says that its largest sample is {largest}")
    return values.astype(dtype.newbyteorder("=")).reshape(rows, cols), float(largest)
