"""NPY: one array as numpy loads it, without metadata."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.camera.frame import Frame
from camsim.core.arrays import F64
from camsim.files.atomic import write_chunks


def write_mosaic(frame: Frame, path: Path) -> None:
    """Write the codes: (rows, cols) uint16."""
    write_array(frame.mosaic, path)


def write_electrons(frame: Frame, path: Path) -> None:
    """Write the electrons after noise: (rows, cols) float64."""
    write_array(in_steps(frame, frame.electrons), path)


def write_truth(frame: Frame, path: Path) -> None:
    """Write the mean electrons of every channel: (rows, cols, channels) float32."""
    assert frame.truth is not None
    write_array(frame.truth, path)


def in_steps(frame: Frame, electrons: F64) -> F64:
    """Return electrons (rows, cols) rounded to digits that are equal on every processor, see ``Frame.steps_e``."""
    if not frame.steps_e:
        return electrons
    step_e = np.array(frame.steps_e)[frame.channel_index]
    rounded: F64 = step_e * np.rint(electrons / step_e)
    return rounded


def write_array(array: npt.NDArray[Any], path: Path) -> None:
    """Write the array in C order, numpy's format 1.0."""
    array = np.ascontiguousarray(array)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, np.lib.format.header_data_from_array_1_0(array))
    # Not numpy.save: its errors do not reveal a full disk.
    write_chunks(path, (header.getvalue(), array.data.cast("B")))
