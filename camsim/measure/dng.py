"""The raw image of any DNG: samples, filters and levels from its tags."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.errors import InputError
from camsim.files.full_scale import largest_sample
from camsim.files.tiff_image import LINEAR_RAW, MOSAIC, NotReadError, bits_per_sample, photometric, read_image
from camsim.files.tiff_reader import (
    IMAGE_LENGTH,
    IMAGE_WIDTH,
    SUBFILE_TYPE,
    Directory,
    read_directories,
    read_directory,
)
from camsim.measure.dng_opcodes import Operations
from camsim.measure.libraw import read_whole
from camsim.sensor.colour_matrix import adaptation, fit_white

_SAMPLES, _SAMPLE_FORMAT = 277, 339
_CFA_REPEAT, _CFA_PATTERN = 33421, 33422
_LAYOUT, _LINEARIZATION, _WHITE, _ACTIVE_AREA = 50711, 50712, 50717, 50829
_BLACK_REPEAT, _BLACK, _BLACK_OF_COLS, _BLACK_OF_ROWS = 50713, 50714, 50715, 50716
_ROW_INTERLEAVE, _COLUMN_INTERLEAVE, _BLOCK = 50975, 52547, 50974
_ILLUMINANTS = {1: "D55", 3: "A", 17: "A", 20: "D55", 21: "D65", 22: "D75", 23: "D50"}
"""EXIF codes of illuminants: daylight, tungsten, CIE."""
_COLOUR_MATRICES = ((50722, 50779), (50721, 50778))
"""Tags of a matrix and its illuminant; of two, the daylight one comes first."""
_NEUTRAL, _WHITE_XY, _ANALOG_BALANCE = 50728, 50729, 50727
_RECTANGULAR = 1
"""Rectangular CFALayout; the others shift every second row or column by half a photosite."""

_LETTERS = "RGBCMYW"
_LARGEST_REPEAT = 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Raw:
    """The active area: (rows, cols) or (rows, cols, samples).

    pattern : letters of its filters, one string per row; None for linear raw
    black   : a tile of levels, or one for each sample
    white   : clipping level for each sample;  lowest: the smallest number that can be stored
    operations : operations of its opcode lists, and whether they were applied
    linear_dn : data numbers of its codes, already applied to the image; empty: the image has the codes
    """

    image: npt.NDArray[Any]
    pattern: tuple[str, ...] | None
    black: F64
    white: tuple[float, ...]
    lowest: float
    operations: tuple[str, ...] = ()
    linear_dn: tuple[int, ...] = ()


def read_colours(file: BinaryIO, size: int) -> tuple[tuple[float, ...], tuple[tuple[float, ...], ...]]:
    """Return as-shot white-balance factors of channels, and rows of XYZ under D65 to camera; empty if not stated."""
    stated = read_directory(file, size)
    balance = np.array(stated.values(_ANALOG_BALANCE) or (1.0,))
    for matrix, light in _COLOUR_MATRICES:
        numbers = stated.values(matrix)
        if len(numbers) >= 9 and len(numbers) % 3 == 0 and len(balance) in (1, len(numbers) // 3):
            to_camera = balance[:, None] * np.array(numbers).reshape(-1, 3)
            white = fit_white(_ILLUMINANTS.get(stated.number(light, 21), "D65"))
            break
    else:
        return (), ()
    neutral = np.array(stated.values(_NEUTRAL))
    if (xy := stated.values(_WHITE_XY)) and not neutral.size and len(xy) == 2 and xy[1] > 0.0:
        neutral = to_camera @ np.array([xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]])
    of_d65 = to_camera @ adaptation(fit_white("D65"), white)
    known = neutral.size == len(to_camera) and np.isfinite(neutral).all() and neutral.min() > 0.0
    return tuple((1.0 / neutral).tolist()) if known else (), tuple(map(tuple, of_d65.tolist()))


def read_raw(path: Path, file: BinaryIO, size: int, *, stored: bool = False) -> Raw:
    """Return the main image of a DNG: its mosaic, or linear planes; raises InputError.

    stored : the codes as stored, without opcode lists, and with integer black levels by row and column
    """
    here = next(
        (
            directory
            for directory in read_directories(file, size)
            if directory.number(SUBFILE_TYPE, 0) == 0 and photometric(directory) in (MOSAIC, LINEAR_RAW)
        ),
        None,
    )
    if here is None:
        raise InputError("this DNG holds no mosaic and no linear raw image")
    operations = Operations.of(here)
    if stored:
        operations.refuse_curves()
    try:
        image = _linearised(_in_turn(read_image(here), here), here.numbers(_LINEARIZATION))
    except NotReadError as why:
        image = _by_libraw(path, here, why)
    if image.ndim == 3 and photometric(here) == MOSAIC:
        raise InputError(
            f"it has {image.shape[2]} samples of each photosite of its mosaic (as of large and small photosites, or "
            "two exposures), and one is measured; write each as a separate DNG"
        )
    pattern = _pattern(here) if photometric(here) == MOSAIC else None
    period = (1, 1) if pattern is None else (len(pattern), len(pattern[0]))
    if not stored:
        image = operations.on_stored(image, period)
    area = here.numbers(_ACTIVE_AREA) or (0, 0, *image.shape[:2])
    if len(area) != 4 or not (area[0] < area[2] <= image.shape[0] and area[1] < area[3] <= image.shape[1]):
        raise InputError(f"its active area {area[:4]} does not lie within its image of {image.shape[:2]} pixels")
    image = image[area[0] : area[2], area[1] : area[3]]
    samples = image.shape[2] if image.ndim == 3 else 1
    white, black, offsets = _white(here, image.dtype, samples), _black(here, samples), _offsets(here, image.shape)
    if image.ndim == 3:
        offsets, black = offsets + _tiled(black - black[0, 0], image.shape), black[:1, :1]
    image, white, lowest = _without(np.rint(offsets) if stored else offsets, image, white)
    black = black[:, :, 0] if image.ndim == 2 else black[0, 0]
    if operations.on_light and not stored:
        image, black, white, lowest = _operated(operations, image, black, white, lowest, period)
    return Raw(
        image=image, pattern=pattern, black=black, white=white, lowest=lowest, operations=operations.stated(),
        linear_dn=here.numbers(_LINEARIZATION),
    )  # fmt: skip


def _operated(
    operations: Operations,
    image: npt.NDArray[Any],
    black: F64,
    white: tuple[float, ...],
    lowest: float,
    period: tuple[int, int],
) -> tuple[npt.NDArray[Any], F64, tuple[float, ...], float]:
    """Return an image after its second opcode list, with levels and lowest number: black is 0 and white 1."""
    level = _tiled(black[:, :, None], image.shape)[:, :, 0] if image.ndim == 2 else black
    span = np.array(white) - level if image.ndim == 3 else white[0] - level
    light = operations.on_linear((image - level) / span, period)
    least = float(np.max((lowest - level) / span))
    return np.where(image <= lowest, least, light), np.zeros_like(black), (1.0,) * len(white), least


def _by_libraw(path: Path, directory: Directory, why: NotReadError) -> npt.NDArray[Any]:
    """Return an image read by LibRaw, for storage formats that only it supports; linearisation table applied."""
    image = read_whole(path)
    size, samples = (directory.number(IMAGE_LENGTH), directory.number(IMAGE_WIDTH)), directory.number(_SAMPLES, 1)
    turned = any(directory.number(tag, 1) != 1 for tag in (_ROW_INTERLEAVE, _COLUMN_INTERLEAVE))
    if image.shape[:2] != size or turned or 3 in directory.numbers(_SAMPLE_FORMAT):
        raise why  # LibRaw selects another image of the file, or rounds its numbers
    return image[:, :, :samples] if image.ndim == 3 else image


def _in_turn(image: npt.NDArray[Any], directory: Directory) -> npt.NDArray[Any]:
    """Return the image of rows and columns stored as several fields, one below or next to the other."""
    if set(directory.numbers(_BLOCK)) - {1}:
        raise InputError("its tiles are stored in separate blocks (SubTileBlockSize), which is not read")
    for axis, number in enumerate((_ROW_INTERLEAVE, _COLUMN_INTERLEAVE)):
        fields, size = directory.number(number, 1), image.shape[axis]
        if not 1 <= fields <= size:
            raise InputError(f"it says that {size} rows or columns are stored as {fields} fields")
        if fields > 1:
            stored = np.concatenate([np.arange(size)[field::fields] for field in range(fields)])
            image = np.take(image, np.argsort(stored), axis=axis)
    return image


def _linearised(image: npt.NDArray[Any], table: tuple[int, ...]) -> npt.NDArray[Any]:
    if not table:
        return image
    if image.dtype.kind != "u":
        raise InputError("it has a linearisation table, and its samples are no whole numbers")
    light: npt.NDArray[Any] = np.asarray(table, np.uint32)[np.minimum(image, len(table) - 1)]
    return light


def _white(directory: Directory, dtype: np.dtype[Any], samples: int) -> tuple[float, ...]:
    """Return the clipping level of each sample."""
    said = directory.values(_WHITE) or (largest_sample(dtype, bits_per_sample(directory)),)
    levels = said[:1] * samples if samples == 1 or len(said) == 1 else said
    if len(levels) != samples:
        raise InputError(f"it has {len(levels)} white levels for {samples} samples")
    return levels


def _offsets(directory: Directory, shape: tuple[int, ...]) -> F64:
    """Return black offsets of columns and rows relative to the black level, broadcastable to an image."""
    offsets = np.zeros((1,) * len(shape))
    for number, axis, what in ((_BLACK_OF_COLS, 1, "columns"), (_BLACK_OF_ROWS, 0, "rows")):
        each = directory.values(number)
        if len(each) not in (0, shape[axis]):
            raise InputError(f"it has black levels of {len(each)} {what}, and its active area has {shape[axis]}")
        if each:
            offsets = offsets + np.expand_dims(each, tuple(k for k in range(len(shape)) if k != axis))
    return offsets


def _tiled(levels: F64, shape: tuple[int, ...]) -> F64:
    """Return levels (rows, cols, samples) tiled over an image."""
    rows, cols = (np.arange(size) % period for size, period in zip(shape[:2], levels.shape[:2], strict=True))
    tiled: F64 = levels[rows[:, None], cols]
    return tiled


def _without(
    offsets: F64, image: npt.NDArray[Any], white: tuple[float, ...]
) -> tuple[npt.NDArray[Any], tuple[float, ...], float]:
    """Return an image with uniform black, its clipping levels, and its lowest number.

    Clipped samples are set to common levels, so that one level identifies them in all columns and rows.
    """
    if not offsets.any():
        return image, white, 0.0
    full, most, least = np.array(white), np.array(white) - offsets.min(), -float(offsets.max())
    level = np.where(image >= full, most, np.where(image <= 0, least, image - offsets))
    if image.dtype.kind in "ui" and image.dtype.itemsize <= 2 and not np.mod([*white, *offsets.flat], 1.0).any():
        level = level.astype(np.int32)  # still integer codes
    return level, tuple(most.tolist()), least


def _pattern(directory: Directory) -> tuple[str, ...]:
    layout = directory.number(_LAYOUT, _RECTANGULAR)
    if layout != _RECTANGULAR:
        raise InputError(
            f"every second row or column of its photosites is shifted by half of one (CFALayout {layout}), and only "
            "rectangular arrays are measured"
        )
    rows, cols = _repeat(directory, _CFA_REPEAT, (2, 2))
    codes = directory.bytes_of(_CFA_PATTERN, _LARGEST_REPEAT**2) or bytes((0, 1, 1, 2))
    if len(codes) != rows * cols or max(codes) >= len(_LETTERS):
        raise InputError(
            f"its filters in {rows} × {cols} places are {list(codes[:8])}; give {len(_LETTERS) - 1} at most"
        )
    return tuple("".join(_LETTERS[code] for code in codes[r * cols : (r + 1) * cols]) for r in range(rows))


def _black(directory: Directory, samples: int) -> F64:
    """Return the black levels (rows, cols, samples), a tile from the active area's corner."""
    rows, cols = _repeat(directory, _BLACK_REPEAT, (1, 1))
    levels = directory.values(_BLACK) or (0.0,) * (rows * cols * samples)
    if len(levels) != rows * cols * samples:
        raise InputError(f"it has {len(levels)} black levels for {rows} × {cols} places of {samples} samples")
    black: F64 = np.array(levels, np.float64).reshape(rows, cols, samples)
    return black


def _repeat(directory: Directory, number: int, default: tuple[int, int]) -> tuple[int, int]:
    """Return the repeat period (rows, cols) of a tag."""
    found = directory.numbers(number) or default
    if len(found) != 2 or not all(1 <= size <= _LARGEST_REPEAT for size in found):
        raise InputError(f"its tag {number} says {found[:2]}; two numbers from 1 to {_LARGEST_REPEAT} belong there")
    return found[0], found[1]
