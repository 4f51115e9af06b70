"""The array types that stages pass to one another."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

F64: TypeAlias = npt.NDArray[np.float64]
F32: TypeAlias = npt.NDArray[np.float32]
U16: TypeAlias = npt.NDArray[np.uint16]
U8: TypeAlias = npt.NDArray[np.uint8]
I64: TypeAlias = npt.NDArray[np.int64]
C128: TypeAlias = npt.NDArray[np.complex128]


def same_rows(array: F64) -> tuple[I64, I64]:
    """Return the first row of each kind, and the kind of every row (n, m): rows are the same by all their bits.

    np.unique makes a type of m fields of a row, which takes longer than all else where m are a light's wavelengths.

    >>> first, kind = same_rows(np.array([[1.0, 2.0], [3.0, 4.0], [1.0, 2.0]]))
    >>> bool(kind[0] == kind[2] != kind[1]), sorted(first.tolist())
    (True, [0, 1])
    """
    rows = np.ascontiguousarray(array).view(np.dtype((np.void, array.itemsize * array.shape[1]))).ravel()
    _, first, kind = np.unique(rows, return_index=True, return_inverse=True)
    return first, kind
