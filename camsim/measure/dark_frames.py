"""Darks of a folder as the dark signal of a sensor."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camsim.arrays import F32
from camsim.errors import InputError
from camsim.measure.noise.shots import codes_of
from camsim.measure.reading import RAW, read_picture
from camsim.sensor.stages.dark_frames import DarkFrames

_MOST_BYTES = 1 << 31


def read_darks(folder: Path, source: str) -> DarkFrames:
    """Read all raw files of a folder as darks; the mean of all of them is taken off.

    source : what files call the folder

    Raises InputError in one sentence.
    """
    if not folder.is_dir():
        raise InputError(f"{str(folder)!r} is no folder of darks")
    files = sorted(path for path in folder.glob("[!.]*") if path.is_file() and path.suffix.lower() in RAW)
    if not files:
        raise InputError(f"{str(folder)!r} holds no raw file that can be read ({', '.join(RAW)})")
    darks: list[F32] = []
    for path in files:
        _, _, codes = codes_of(read_picture(path, stored=True))
        if darks and codes.shape != darks[0].shape:
            rows, cols = darks[0].shape
            raise InputError(
                f"{str(path)!r} has {codes.shape[0]} × {codes.shape[1]} photosites, and {str(files[0])!r} "
                f"{rows} × {cols}; give darks of one camera"
            )
        if 4 * codes.size * len(files) > _MOST_BYTES:
            raise InputError(
                f"{str(folder)!r} holds {len(files)} darks, more than 2 GiB; give fewer, or a part of each"
            )
        darks.append(codes.astype(np.float32))
    mean = np.float32(np.mean([dark.mean(dtype=np.float64) for dark in darks]))
    return DarkFrames(codes_dn=np.stack(darks) - mean, source=source)
