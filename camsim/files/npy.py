"""NPY: one array as numpy loads it, the numbers themselves and nothing else."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.files.atomic import write_chunks
from camsim.frame import Frame


def write_mosaic(frame: Frame, path: Path) -> None:
    """Write the codes: (rows, cols) uint16."""
    write_array(frame.mosaic, path)


def write_electrons(frame: Frame, path: Path) -> None:
    """Write the electrons after noise: (rows, cols) float64."""
    write_array(frame.electrons, path)


def write_truth(frame: Frame, path: Path) -> None:
    """Write the mean electrons of every channel: (rows, cols, channels) float32."""
    assert frame.truth is not None
    write_array(frame.truth, path)


def write_array(array: npt.NDArray[Any], path: Path) -> None:
    """Write the array in C order, numpy's format 1.0."""
    array = np.ascontiguousarray(array)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, np.lib.format.header_data_from_array_1_0(array))
    # Not numpy.save: its errors do not say whether the disk is full.
    write_chunks(path, (header.getvalue(), array.data.cast("B")))
