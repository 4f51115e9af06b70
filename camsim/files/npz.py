"""NPZ: all arrays of a frame under their names, and the record as JSON, in one archive that numpy opens."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.camera.frame import Frame
from camsim.files.describe import record_json
from camsim.files.npy import in_steps

RECORD_NAME = "record.json"

_EARLIEST = (1980, 1, 1, 0, 0, 0)
"""The first date of the format, so that equal frames give equal bytes at any time."""


def write_frame(frame: Frame, path: Path) -> None:
    """Write mosaic, electrons, mean_electrons, channel_index and truth (if captured), uncompressed."""
    arrays: dict[str, npt.NDArray[Any]] = {
        "mosaic": frame.mosaic,
        "electrons": in_steps(frame, frame.electrons),
        "mean_electrons": in_steps(frame, frame.mean_electrons),
        "channel_index": frame.channel_index,
        **({} if frame.truth is None else {"truth": frame.truth}),
    }
    with path.open("wb") as file, zipfile.ZipFile(file, "w") as archive:
        archive.writestr(zipfile.ZipInfo(RECORD_NAME, _EARLIEST), record_json(frame, "frame"))
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy", _EARLIEST)
            with archive.open(info, "w", force_zip64=array.nbytes >= 1 << 31) as member:
                np.lib.format.write_array(member, np.ascontiguousarray(array), allow_pickle=False)
