"""Any array of codes, mosaic or linear colours, written as a DNG for raw programs or developed for viewing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from camsim.camera.frame import LARGEST_CODE, codes_of
from camsim.core.arrays import F64, U8, U16, is_masked
from camsim.core.calls import in_words
from camsim.core.number_kinds import array_of
from camsim.core.typed import FilePath, check, check_truths
from camsim.core.words import displayed
from camsim.errors import InvalidValueError, OutputError, did_you_mean
from camsim.files.atomic import replacing
from camsim.files.describe import canonical
from camsim.files.dng_image import Image, LosslessTiles, Strip
from camsim.files.dng_tags import CFA, D65, LINEAR_RAW, Colour, Metadata, odd_cfa
from camsim.files.preview import Balance, developed
from camsim.files.tiff_ifd import Tag, directories, refuse_over_4_gib, undefined
from camsim.sensor.cfa import BAYER, PATTERNS, Cfa
from camsim.sensor.colour_matrix import ColourFit, fit_white

_LARGEST_PERIOD = 16  # of black levels: limit of camsim's readers
_FAINTEST_NEUTRAL, _STRONGEST_NEUTRAL = 1e-3, 1e3
_LEAST_RANK = 1e-6

# IEC 61966-2-1: default camera for arrays without a matrix, with sRGB's primaries as channels.
_XYZ_TO_SRGB = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)

ArrayOfFilters = str | Cfa | Sequence[str]


@in_words
def write_dng(
    path: str | os.PathLike[str],
    mosaic: ArrayLike,
    cfa: ArrayOfFilters = "RGGB",
    *,
    black_level_dn: ArrayLike = 0,
    white_level_dn: int,
    colour_matrix: ArrayLike | None = None,
    as_shot_neutral: ArrayLike | None = None,
    camera_name: str = "array",
    allow_odd_cfa: bool = False,
    compress: bool = False,
) -> None:
    """Write an array of codes as a DNG that raw programs open in the right colours.

    mosaic          : (rows, cols) whole numbers 0 … 65535, one for each photosite; or (rows, cols, 3) of red, green
                      and blue at each pixel, linear and never demosaiced: a linear DNG, of which ``cfa`` is not asked
    cfa             : letters of (0,0) (0,1) (1,0) (1,1); "mono", "x-trans" and other names; rows such as ("RG", "GB");
                      or a ``Cfa``
    black_level_dn  : code of no light; or a small table of them that repeats from photosite (0, 0)
    white_level_dn  : code at which the signal clips, 4095 of 12 bits: it says how many bits there are
    colour_matrix   : (channels, 3) from XYZ under D65 to the camera, any scale, as in DNG's ColorMatrix; in
                      the order R, G, B, then others as they come. Left out: linear sRGB's
    as_shot_neutral : (channels,) what white gives each channel, any scale. Left out: what D65 gives by the matrix
    camera_name     : name that programs show
    allow_odd_cfa   : write even an array that raw programs misread;  compress: as lossless JPEG, with imagecodecs

    Equal arrays give equal bytes; the file is there whole or not at all. Raises InvalidValueError or OutputError in one
    sentence.

    >>> import tempfile
    >>> from pathlib import Path
    >>> codes = np.full((8, 8), 700, np.uint16)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_dng(Path(folder) / "mine.dng", codes, cfa="RGGB", black_level_dn=512, white_level_dn=4095)
    ...     (Path(folder) / "mine.dng").stat().st_size > codes.nbytes
    True
    """
    image: Any = mosaic if np.ma.isMaskedArray(mosaic) else array_of(mosaic, "mosaic")
    linear = image.ndim == 3
    if linear and cfa != "RGGB":
        raise InvalidValueError(f"{displayed(cfa)}, and each pixel has all colours; leave it out", key="cfa")
    codes = _side_by_side(image) if linear else image
    given = _Given.of(codes, cfa, black_level_dn, white_level_dn, colour_matrix, as_shot_neutral)
    if linear:
        given = replace(given, codes=given.codes.reshape(image.shape))
    check_truths(allow_odd_cfa=allow_odd_cfa, compress=compress)
    target = Path(check(path, FilePath, "path"))
    if target.suffix.lower() != ".dng":
        raise OutputError(f"cannot write {str(path)!r}: a DNG's name ends in .dng")
    why = odd_cfa(tuple(given.cfa.pattern))
    if why and not allow_odd_cfa:
        raise OutputError(f"{why}, or give allow_odd_cfa=True")
    refuse_over_4_gib(given.codes.nbytes)
    said = given.said(check(camera_name, str, "camera_name"))
    cols, mono = given.codes.shape[1], given.colour is None

    def all_tags(layout: tuple[Tag, ...], identity: bytes, at: int) -> tuple[bytes, int]:
        return directories((*layout, *said.tags(identity)), (undefined(36864, b"0230"),), at)  # ExifVersion

    with replacing(target) as temporary, temporary.open("wb") as file:
        image = Image(file, LosslessTiles(cols, components=1 if mono or linear else 2) if compress else Strip())
        image.take(given.codes)
        image.finish(given.text, all_tags)


@in_words
def develop(
    mosaic: ArrayLike,
    cfa: ArrayOfFilters = "RGGB",
    *,
    black_level_dn: ArrayLike = 0,
    white_level_dn: int,
    colour_matrix: ArrayLike | None = None,
    as_shot_neutral: ArrayLike | None = None,
) -> U8:
    """Develop an array of codes, to look at: (rows, cols, 3) 8-bit sRGB, (rows, cols) for mono.

    Arguments as of ``write_dng``. Black level, white balance, bilinear demosaicing, matrix, sRGB's curve. Of black
    levels that differ the largest tells where white is, for all photosites, as in a DNG: what clips there is white.

    >>> develop(np.full((4, 4), 1023), white_level_dn=1023)[0, 0].tolist()
    [255, 255, 255]
    """
    given = _Given.of(mosaic, cfa, black_level_dn, white_level_dn, colour_matrix, as_shot_neutral)
    colour = given.colour
    return developed(
        given.codes,
        given.cfa.channel_index(*given.codes.shape),
        len(given.cfa.channels),
        black_dn=given.black_dn,
        span_dn=given.white_dn - float(given.black_dn.max()),
        balance=None if colour is None else Balance(neutral=colour.neutral, forward=colour.fits[0][2]),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Given:
    """A mosaic and its metadata, validated."""

    codes: U16
    cfa: Cfa
    black_dn: F64
    white_dn: int
    colour: Colour | None

    @classmethod
    def of(
        cls,
        mosaic: ArrayLike,
        cfa: ArrayOfFilters,
        black_level_dn: ArrayLike,
        white_level_dn: int,
        colour_matrix: ArrayLike | None,
        as_shot_neutral: ArrayLike | None,
    ) -> _Given:
        codes, array = codes_of(mosaic), _filters(cfa)
        if not codes.size:
            message = f"must be (rows, cols), one code for each photosite, not an array of shape {codes.shape}"
            raise InvalidValueError(message, key="mosaic")
        white_dn = check(white_level_dn, int, "white_level_dn")
        if not 1 <= white_dn <= LARGEST_CODE:
            raise InvalidValueError(f"must be 1 to {LARGEST_CODE}, not {white_dn}", key="white_level_dn")
        black_dn = np.atleast_2d(_numbers(black_level_dn, "black_level_dn"))
        if black_dn.ndim != 2 or not 1 <= min(black_dn.shape) <= max(black_dn.shape) <= _LARGEST_PERIOD:
            raise InvalidValueError(
                f"must be a number or a table of at most {_LARGEST_PERIOD} × {_LARGEST_PERIOD}, not one of "
                f"{' × '.join(map(str, black_dn.shape))}",
                key="black_level_dn",
            )
        if not 0 <= black_dn.min() <= black_dn.max() < white_dn:
            worst = black_dn.min() if black_dn.min() < 0 else black_dn.max()
            raise InvalidValueError(
                f"must be from 0 to below white_level_dn={white_dn}, not {worst:g}", key="black_level_dn"
            )
        colour = None if len(array.channels) == 1 else _colour(array.channels, colour_matrix, as_shot_neutral)
        if colour is None and not (colour_matrix is None and as_shot_neutral is None):
            key = "as_shot_neutral" if colour_matrix is None else "colour_matrix"
            raise InvalidValueError(f"cfa {displayed(cfa)} has one channel, which has no colour; leave it out", key=key)
        return cls(codes=codes, cfa=array, black_dn=black_dn, white_dn=white_dn, colour=colour)

    def said(self, camera_name: str) -> Metadata:
        return Metadata(
            shape=(self.codes.shape[0], self.codes.shape[1]),
            photometric=CFA if self.colour is not None and self.codes.ndim == 2 else LINEAR_RAW,
            samples=self.codes[0, 0].size,
            cfa_pattern=tuple(self.cfa.pattern),
            channels=self.cfa.channels,
            black_dn=self.black_dn.tolist(),
            white_dn=self.white_dn,
            noise=None,
            colour=self.colour,
            camera_name=camera_name,
            serial=None,
            date=None,
            xmp=None,
        )

    @property
    def text(self) -> str:
        """Text that identifies the image together with its codes."""
        colour = self.colour
        return canonical(
            {
                "cfa": self.cfa.pattern,
                "black_dn": self.black_dn,
                "white_dn": self.white_dn,
                "colour": None if colour is None else [colour.fits[0][1], colour.neutral],
            }
        )


def _side_by_side(image: Any) -> Any:
    """Return (rows, cols, 3) as (rows, 3 · cols)."""
    if image.shape[2] != 3:
        message = (
            "must be (rows, cols), one code for each photosite, or (rows, cols, 3) of red, green and blue, not an "
            f"array of shape {image.shape}"
        )
        raise InvalidValueError(message, key="mosaic")
    return image.reshape(image.shape[0], 3 * image.shape[1])


def _filters(cfa: ArrayOfFilters) -> Cfa:
    if isinstance(cfa, Cfa):
        return cfa
    if not isinstance(cfa, str):
        return Cfa(cfa)
    if cfa in BAYER:
        return Cfa.bayer(cfa)
    if cfa in PATTERNS:
        return Cfa.named(cfa)
    raise InvalidValueError(
        f"unknown array {cfa!r}{did_you_mean(cfa, (*BAYER, *PATTERNS))}; or give its rows, such as ('RG', 'GB')",
        key="cfa",
    )


def _colour(channels: tuple[str, ...], colour_matrix: ArrayLike | None, as_shot_neutral: ArrayLike | None) -> Colour:
    count, names, white_xyz = len(channels), ", ".join(channels), fit_white("D65")
    if colour_matrix is None:
        if channels != ("R", "G", "B"):
            raise InvalidValueError(
                f"filters {names} are not sRGB's; give the matrix, {count} × 3", key="colour_matrix"
            )
        # That white, tabulated to more digits, gives equal channels.
        matrix = _XYZ_TO_SRGB / np.einsum("cx,x->c", _XYZ_TO_SRGB, white_xyz)[:, None]
    else:
        matrix = _numbers(colour_matrix, "colour_matrix")
    spread = np.linalg.svd(matrix, compute_uv=False) if matrix.shape == (count, 3) else np.zeros(1)
    if matrix.shape != (count, 3) or spread[-1] <= _LEAST_RANK * spread[0]:
        raise InvalidValueError(
            f"must be {count} × 3 numbers, a row for each of {names}, none of them a mixture of the others",
            key="colour_matrix",
        )
    in_daylight = np.einsum("cx,x->c", matrix, white_xyz)
    if not in_daylight.min() > 0:
        raise InvalidValueError(
            f"white under D65 gives {names} {displayed(in_daylight.tolist())}; a matrix from XYZ to the camera "
            "makes all "
            "of them positive: is it the inverse?",
            key="colour_matrix",
        )
    matrix = matrix / in_daylight.max()
    daylight = in_daylight / in_daylight.max()
    neutral = daylight if as_shot_neutral is None else _numbers(as_shot_neutral, "as_shot_neutral")
    if neutral.shape != (count,) or not _FAINTEST_NEUTRAL <= neutral.min() <= neutral.max() <= _STRONGEST_NEUTRAL:
        raise InvalidValueError(
            f"must be {count} numbers from {_FAINTEST_NEUTRAL:g} to {_STRONGEST_NEUTRAL:g}, one for each of {names}",
            key="as_shot_neutral",
        )
    fitted = ColourFit(
        neutral=daylight, white_xyz=white_xyz, camera_to_xyz=np.linalg.pinv(matrix), xyz_to_camera=matrix
    )
    return Colour(fits=[(D65, matrix, fitted.forward)], neutral=neutral / neutral.max())


def _numbers(values: Any, key: str) -> F64:
    given = array_of(values, key)
    if given.dtype.kind not in "fiu" or is_masked(values):
        raise InvalidValueError(f"must be numbers, not {displayed(values)}", key=key)
    numbers = given.astype(np.float64)
    if not np.isfinite(numbers).all():
        raise InvalidValueError("must be finite numbers", key=key)
    return numbers
