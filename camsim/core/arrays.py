"""The array types that stages pass to one another."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

F64: TypeAlias = npt.NDArray[np.float64]
F32: TypeAlias = npt.NDArray[np.float32]
U16: TypeAlias = npt.NDArray[np.uint16]
U8: TypeAlias = npt.NDArray[np.uint8]
I64: TypeAlias = npt.NDArray[np.int64]
C128: TypeAlias = npt.NDArray[np.complex128]
Floats: TypeAlias = npt.NDArray[np.float32 | np.float64]
Complex: TypeAlias = npt.NDArray[np.complex64 | np.complex128]
Scalar = TypeVar("Scalar", bound=np.generic)
Columns = TypeVar("Columns", bound=NamedTuple)


def picked(columns: Columns, which: Any) -> Columns:
    """Return the selected rows of all columns of a named tuple.

    >>> class Arcs(NamedTuple):
    ...     owner: I64
    ...     turn_rad: F64
    >>> picked(Arcs(np.array([4, 7]), np.array([0.1, 0.2])), [1])
    Arcs(owner=array([7]), turn_rad=array([0.2]))
    """
    return columns._make(column[which] for column in columns)


def distinct(values: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    """Return the different values in increasing order.

    For this, np.unique would import numpy.ma, which takes as long as rendering a small window.

    >>> distinct(np.array([[3.0, 1.0], [1.0, 2.0]]))
    array([1., 2., 3.])
    """
    ordered = np.sort(values, axis=None)
    return ordered[np.append(True, ordered[1:] != ordered[:-1])] if ordered.size else ordered


def is_masked(values: object) -> bool:
    """Return whether any value of an array is masked; False for all but masked arrays, which import numpy.ma."""
    return hasattr(values, "mask") and bool(np.ma.is_masked(values))


def read_only(*arrays: npt.NDArray[Any] | None) -> None:
    """Make shared arrays read-only.

    >>> light = np.ones(3)
    >>> read_only(light)
    >>> light *= 2.0
    Traceback (most recent call last):
    ValueError: output array is read-only
    """
    for array in arrays:
        if array is not None:
            array.flags.writeable = False


def same_rows(array: F64) -> tuple[I64, I64]:
    """Return the index of the first of each distinct row, and the kind of every row (n, m); compared bit by bit.

    np.unique would be slow for many columns, since it treats a row as a structure of m fields.

    >>> first, kind = same_rows(np.array([[1.0, 2.0], [3.0, 4.0], [1.0, 2.0]]))
    >>> bool(kind[0] == kind[2] != kind[1]), sorted(first.tolist())
    (True, [0, 1])
    """
    rows = np.ascontiguousarray(array).view(np.dtype((np.void, array.itemsize * array.shape[1]))).ravel()
    order = np.argsort(rows, kind="stable")
    new, kind = _kinds(rows, order)
    return order[new], kind


def kinds_of(values: npt.NDArray[Scalar]) -> tuple[npt.NDArray[Scalar], I64]:
    """Return the sorted distinct values, and the index of each value among them; faster than np.unique for few.

    >>> kinds_of(np.array([3.0, 1.0, 3.0]))
    (array([1., 3.]), array([1, 0, 1]))
    """
    order = np.argsort(values)
    new, kind = _kinds(values, order)
    return values[order[new]], kind


def _kinds(values: npt.NDArray[Any], order: I64) -> tuple[npt.NDArray[np.bool_], I64]:
    """Return a mask of where a new value begins in sorted order, and the index of each value's kind."""
    rising, new, kind = values[order], np.ones(len(order), np.bool_), np.empty(len(order), np.int64)
    new[1:] = rising[1:] != rising[:-1]
    kind[order] = new.cumsum() - 1
    return new, kind
