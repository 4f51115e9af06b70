"""Real darks, and maps of offsets, as the dark signal of a sensor."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camsim.core.arrays import F32
from camsim.errors import InputError
from camsim.files.picture_samples import read_samples
from camsim.files.reading import opened
from camsim.measure.noise.shots import codes_of
from camsim.measure.reading import RAW, read_picture
from camsim.sensor.stages.dark_frames import DarkFrames
from camsim.sensor.stages.offset_map import OffsetMap, OffsetUnit

_MOST_BYTES = 1 << 31


def read_darks(folder: Path, source: str) -> DarkFrames:
    """Read all raw files of a folder as darks, minus their overall mean.

    source : name of the folder in files

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


def read_offsets(path: Path, source: str, unit: OffsetUnit) -> OffsetMap:
    """Read a map of offsets: an array (rows, cols) from a file, or the mean of a folder of darks.

    source : name of the map in files

    The mean over the photosites is subtracted: it belongs to the black level. Raises InputError in one sentence.
    """
    if path.is_dir():
        map_dn = read_darks(path, source).codes_dn.mean(axis=0, dtype=np.float64)
    else:
        with opened(path) as (file, size):
            map_dn = read_samples(path, file, size).samples.astype(np.float64)
        if map_dn.ndim != 2 or not np.isfinite(map_dn).all():
            what = "numbers that are not finite" if map_dn.ndim == 2 else f"the shape {map_dn.shape}"
            raise InputError(f"{str(path)!r} has {what}; a map of offsets is (rows, cols) finite numbers")
    return OffsetMap(offsets=map_dn - map_dn.mean(), unit=unit, source=source)
