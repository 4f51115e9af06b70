"""Linear planes from measurements, as EXR or NPY."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from camsim.core.arrays import F32
from camsim.errors import OutputError
from camsim.files.atomic import replacing
from camsim.files.exr_stream import write_exr
from camsim.files.npy import write_array

SUFFIXES = (".exr", ".npy")


def check_planes_file(file: str, *, force: bool) -> None:
    """Raise early for a file that cannot be written."""
    path = Path(file)
    if path.suffix.lower() not in SUFFIXES:
        raise OutputError(f"cannot write {file!r}: linear planes go into {' or '.join(SUFFIXES)}")
    if not path.resolve().parent.is_dir():
        raise OutputError(f"cannot write {file!r}: its folder does not exist; make it first")
    if path.exists() and not force:
        raise OutputError(f"{file!r} exists; overwrite it with --force, or write elsewhere with -o")


def write_planes(file: str, image: F32, channels: Sequence[str], attributes: Mapping[str, str | float]) -> None:
    """Write (rows, cols, channels) 32-bit numbers; a NPY holds the array alone, an EXR ``attributes`` too."""
    path = Path(file)
    with replacing(path) as temporary:
        if path.suffix.lower() == ".npy":
            write_array(image, temporary)
            return
        order = sorted(range(len(channels)), key=lambda k: channels[k])

        def block(first: int, height: int) -> F32:
            return np.ascontiguousarray(np.moveaxis(image[first : first + height][:, :, order], 2, 0), dtype="<f4")

        write_exr(
            temporary,
            rows=image.shape[0],
            cols=image.shape[1],
            channels=[channels[k] for k in order],
            attributes=attributes,
            block=block,
        )
