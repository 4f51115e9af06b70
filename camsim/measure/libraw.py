"""Raw files of camera makers, by LibRaw: the mosaic as stored, its levels, and the camera's metadata."""

from __future__ import annotations

import contextlib
import math
import os
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, in_brief
from camsim.files.exif import in_exif
from camsim.files.limits import refuse_bomb
from camsim.files.reading import opened
from camsim.files.tiff_reader import MAGICS, MAKERS_MAGICS, Directory, read_directory

SUFFIXES = (
    ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".erf", ".fff", ".iiq", ".k25", ".kdc", ".mef", ".mos", ".mrw",
    ".nef", ".nrw", ".orf", ".pef", ".raf", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f",
)  # fmt: skip

CHANGED = (
    "codes are as LibRaw unpacks them: a maker's curve of compression is undone; black and white are LibRaw's, of the "
    "file where it says them and of its tables where not; nothing is scaled, mended or cropped but the border"
)

_MAKE, _MODEL = 271, 272
_TURNED_DEG = {0: 0, 3: 180, 5: 270, 6: 90}
_PERIODS = (1, 2, 3, 4, 6, 8, 12, 16)
_LOOKED_AT = 96
_HEAD = 1 << 16
_CORRUPTED = "data corrupted"
_ONE_AT_A_TIME = threading.Lock()


@dataclass(frozen=True, slots=True, kw_only=True)
class Noted:
    """Metadata that a camera wrote for a photograph; None or empty if absent, or not found by LibRaw.

    camera          : maker and model of the camera;  lens: those of the lens
    turned_deg      : clockwise rotation that makes the picture upright
    white_balance   : factors of red, green, blue (and a fourth), as shot;  daylight: LibRaw's for daylight
    xyz_to_camera   : rows of a DNG's matrix, or of LibRaw's, from XYZ under D65, one for each channel
    operations      : operations of a DNG's opcode lists, and whether they were applied
    linear_dn       : data numbers of a DNG's codes 0, 1, …, already applied; empty: not companded
    """

    camera: str = ""
    lens: str = ""
    iso: float | None = None
    time_s: float | None = None
    f_number: float | None = None
    focal_length_mm: float | None = None
    turned_deg: int = 0
    white_balance: tuple[float, ...] = ()
    daylight: tuple[float, ...] = ()
    xyz_to_camera: tuple[tuple[float, ...], ...] = ()
    operations: tuple[str, ...] = ()
    linear_dn: tuple[int, ...] = ()


NOTHING = Noted()
"""Metadata of a file without any."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Unpacked:
    """The active area: (rows, cols), or (rows, cols, samples) for sensors without a mosaic.

    pattern : letters of its filters, one string per row; None if each photosite has all samples
    black   : a tile of levels, or one for each sample;  white: the clipping level
    """

    image: npt.NDArray[np.uint16]
    pattern: tuple[str, ...] | None
    black: npt.NDArray[np.float64]
    white: float
    noted: Noted


def read_unpacked(path: Path) -> Unpacked:
    """Read a raw file of any maker; raises InputError in one sentence."""
    with _unpacked(path) as raw:
        noted = _noted(path, raw)
        image, levels = np.array(raw.raw_image_visible), np.asarray(raw.black_level_per_channel, np.float64)
        white = float(raw.white_level)
        if image.ndim == 3:
            count = raw.num_colors
            return Unpacked(image=image[:, :, :count], pattern=None, black=levels[:count], white=white, noted=noted)
        if raw.num_colors == 1:
            return Unpacked(image=image, pattern=("Y",), black=levels[:1, None], white=white, noted=noted)
        cell = _tiled(raw.raw_colors_visible)
        letters = raw.color_desc.decode("ascii", "replace")
    return Unpacked(
        image=image,
        pattern=tuple("".join(letters[color] for color in row) for row in cell.tolist()),
        black=levels[cell],
        white=white,
        noted=noted,
    )


def read_whole(path: Path) -> npt.NDArray[np.uint16]:
    """Return the stored image with its border, after its linearisation table."""
    with _unpacked(path) as raw:
        return np.array(raw.raw_image)


def read_noted(path: Path) -> Noted:
    """Return the metadata of a raw file without reading its codes; raises InputError."""
    with _opened(path, unpack=False) as raw:
        return _noted(path, raw)


def _unpacked(path: Path) -> contextlib.AbstractContextManager[Any]:
    return _opened(path, unpack=True)


@contextlib.contextmanager
def _opened(path: Path, *, unpack: bool) -> Iterator[Any]:
    import rawpy

    raw = rawpy.RawPy()
    try:
        with _counted() as lines:
            raw.open_file(str(path))
            sizes = raw.sizes
            refuse_bomb(2 * sizes.raw_height * sizes.raw_width, path.stat().st_size)
            if unpack:
                raw.unpack()
        if any(_CORRUPTED in line for line in lines):
            raise InputError("LibRaw finds its codes corrupted: it is damaged, or cut short")
        yield raw
    except (rawpy.LibRawError, rawpy.NotSupportedError, NotImplementedError) as error:
        why = error.args[0].decode() if error.args and isinstance(error.args[0], bytes) else in_brief(error)
        raise InputError(
            f"LibRaw does not read it ({why}): it is damaged, cut short, or of a camera that is not known; convert it "
            "to DNG (dnglab or Adobe's converter does)"
        ) from None
    finally:
        raw.close()


@contextlib.contextmanager
def _counted() -> Iterator[list[str]]:
    """Capture LibRaw's output on stderr, the only place where it reports damaged codes that it continues past."""
    lines: list[str] = []
    with _ONE_AT_A_TIME, tempfile.TemporaryFile() as said:
        try:
            saved = os.dup(2)
        except OSError:  # a program without stderr has nothing to capture
            yield lines
            return
        os.dup2(said.fileno(), 2)
        try:
            yield lines
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            said.seek(0)
            lines += said.read().decode("utf-8", "replace").splitlines()


def _tiled(colors: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the smallest tile of filters of a mosaic."""
    looked = colors[:_LOOKED_AT, :_LOOKED_AT]
    rows = next((p for p in _PERIODS if np.array_equal(looked[p:], looked[:-p])), 0)
    cols = next((p for p in _PERIODS if np.array_equal(looked[:, p:], looked[:, :-p])), 0)
    if not rows or not cols:
        raise InputError("its filters are no rectangle of 16 photosites or fewer that is repeated")
    return colors[:rows, :cols]


def _noted(path: Path, raw: Any) -> Noted:
    other, lens = raw.other, raw.lens
    return Noted(
        camera=_camera(path),
        lens=" ".join(filter(None, (lens.make.strip(), lens.model.strip()))),
        iso=_above_0(other.iso_speed),
        time_s=_above_0(other.shutter_speed),
        f_number=_above_0(other.aperture),
        focal_length_mm=_above_0(other.focal_length),
        turned_deg=_TURNED_DEG.get(raw.sizes.flip, 0),
        white_balance=_factors(raw.camera_whitebalance),
        daylight=_factors(raw.daylight_whitebalance),
        xyz_to_camera=tuple(tuple(float(f"{n:.7g}") for n in row) for row in raw.rgb_xyz_matrix if np.any(row)),
    )


def _above_0(value: float) -> float | None:
    return float(f"{value:.7g}") if math.isfinite(value) and value > 0.0 else None


def _factors(values: Any) -> tuple[float, ...]:
    """Return factors of channels, empty if red or blue has none; a second green of 0 equals the first."""
    rounded = tuple(float(f"{value:.7g}") for value in values)
    return () if min(rounded[:3]) <= 0.0 else rounded if rounded[3] > 0.0 else rounded[:3]


def _camera(path: Path) -> str:
    """Return maker and model, which rawpy does not provide; empty if not found."""
    with opened(path) as (file, size):
        head = file.read(_HEAD)
        if head[:4] in MAGICS + MAKERS_MAGICS:
            try:
                return _maker_and_model(read_directory(file, size))
            except InputError:
                return ""
    return in_exif(_exif_in(head), _maker_and_model, "")


def _maker_and_model(directory: Directory) -> str:
    maker, model = (directory.bytes_of(tag, 256).rstrip(b" \0").decode("ascii", "replace") for tag in (_MAKE, _MODEL))
    return model if model.startswith(maker) else f"{maker} {model}".strip()


def _exif_in(head: bytes) -> bytes:
    """Return the EXIF data of a file that is not TIFF: Fuji's begin with a JPEG, Canon's newest use boxes."""
    if head[:8] == b"FUJIFILM" and (begin := head.find(b"Exif\0\0")) > 0:
        return head[begin:]
    if head[4:8] == b"ftyp" and (begin := head.find(b"CMT1")) > 0:
        return head[begin + 4 :]
    return b""
