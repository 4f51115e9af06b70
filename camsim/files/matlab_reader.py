"""MATLAB's files of versions 5 to 7 (by SciPy) and 7.3 (HDF5, by h5py): a cube of numbers and its wavelengths."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from camsim.errors import InputError, in_brief
from camsim.files.limits import refuse_bomb, refuse_many
from camsim.files.which_image import image_array

HDF5 = b"\x89HDF\r\n\x1a\n"
_MOST_VARIABLES = 1000
_BYTES = {"double": 8, "single": 4, "int64": 8, "uint64": 8, "int32": 4, "uint32": 4, "int16": 2, "uint16": 2}

Variables = Mapping[str, tuple[tuple[int, ...], Callable[[], npt.NDArray[Any]]]]
"""By name: shape, and function that reads the values."""


def read_variables(path: Path, begin: bytes, size: int, asked: str | None = None) -> dict[str, npt.NDArray[Any]]:
    """Return a file's largest array of three dimensions (or two), and all one-dimensional ones.

    begin : the file's first 520 bytes;  asked: the array to return in place of the largest
    """
    # MATLAB puts a header of 512 bytes before HDF5.
    try:
        found = _hdf5(path) if HDF5 in (begin[:8], begin[512:520]) else _version_5(path)
    except InputError:
        raise
    except Exception as error:  # any error of SciPy and h5py for damaged files
        raise InputError(f"it is cut short or damaged ({in_brief(error)})") from None
    # In MATLAB everything is a matrix: a single row or column is a list.
    images = {name: shape for name, (shape, _) in found.items() if len(shape) != 2 or min(shape) > 1}
    chosen = image_array(images, asked)
    wanted = [chosen, *(name for name, (shape, _) in found.items() if math.prod(shape) in range(1, 4097))]
    refuse_bomb(8 * math.prod(found[chosen][0]), size)
    refuse_many(math.prod(found[chosen][0]))
    try:
        return {name: found[name][1]() for name in dict.fromkeys(wanted)}
    except Exception as error:
        raise InputError(f"it is cut short or damaged ({in_brief(error)})") from None


def _version_5(path: Path) -> Variables:

    listed = scipy.io.whosmat(str(path))[:_MOST_VARIABLES]

    def reading(name: str) -> Callable[[], npt.NDArray[Any]]:
        # mat_dtype: MATLAB stores integral doubles as bytes, but they are still doubles.
        return lambda: np.asarray(scipy.io.loadmat(str(path), variable_names=[name], mat_dtype=True)[name])

    return {name: (tuple(shape), reading(name)) for name, shape, kind in listed if kind in _BYTES or kind[-1:] == "8"}


def _hdf5(path: Path) -> Variables:
    try:
        import h5py
    except ImportError:
        raise InputError(
            "it is MATLAB's of version 7.3, which needs the package h5py: "
            "python -m pip install 'camsim-spectral[matlab]'"
        ) from None

    with h5py.File(path, "r") as file:
        shapes = {
            name: file[name].shape[::-1]
            for name in list(file)[:_MOST_VARIABLES]
            if isinstance(file.get(name), h5py.Dataset) and file[name].dtype.kind in "uif"
        }

    def reading(name: str) -> Callable[[], npt.NDArray[Any]]:
        def read() -> npt.NDArray[Any]:
            with h5py.File(path, "r") as file:
                # MATLAB is column-major, HDF5 row-major.
                return np.asarray(file[name][()]).T

        return read

    return {name: (shape, reading(name)) for name, shape in shapes.items() if shape}
