"""Pictures from Frames and from files of any program: linear numbers, with their black and clipping levels.

Read are DNG, raw files of camera makers (NEF, CR3, ARW …, by LibRaw), TIFF, PNG, PGM, EXR, NPY, NPZ and MATLAB's.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.camera.frame import Frame
from camsim.core.arrays import F64
from camsim.core.typed import FilePath, check
from camsim.errors import InputError, InvalidValueError
from camsim.files import exr_reader, jpeg_reader, npy_reader, npz_reader, pgm_reader, png_reader
from camsim.files.exif import setting_noted
from camsim.files.full_scale import largest_sample, opaque, refuse_transparent
from camsim.files.matlab_reader import read_variables
from camsim.files.reading import opened, read_record
from camsim.files.record import LONGEST_RECORD, Record
from camsim.files.tiff_image import bits_per_sample, read_image
from camsim.files.tiff_reader import DNG_VERSION, read_directory, read_image_directory
from camsim.files.which_image import image_array, image_layer
from camsim.measure import libraw
from camsim.measure.dng import read_colours, read_raw
from camsim.measure.filters import filter_rows, mosaic_of
from camsim.measure.given import check_given
from camsim.measure.picture import Picture, Plane, mosaic_planes
from camsim.sensor.companding import data_numbers
from camsim.spectra.rgb import linear_of_srgb

_NAMES = {1: ("Y",), 3: ("R", "G", "B")}
_CFA_TAG, _COLOUR_PROFILE_TAG = 33422, 34675

_MOST_PLANES = 64

_LAYERED, _LINEAR = (
    (".exr", ".npz", ".mat"),
    (".dng", ".exr", ".npz", *libraw.SUFFIXES),
)  # files that have layers, and whose numbers are linear

Gamma = float | str | None


def picture_of_frame(frame: Frame, product: str = "mosaic") -> Picture:
    """Return a product of a frame as a picture to measure.

    product : "mosaic", "electrons" (with noise), "mean_electrons" (without) or "truth"

    >>> import camsim
    >>> frame = camsim.capture("flat-field", overrides=["region={rows: 4, cols: 4}"])
    >>> [plane.name for plane in picture_of_frame(frame).planes]
    ['R', 'G1', 'G2', 'B']
    """
    check_given(frame=frame)
    if product == "truth":
        if frame.truth is None:
            raise InvalidValueError("holds no truth; ask for products=('truth',) when exposing", key="frame")
        planes = _planes(frame.truth, frame.channels)
    elif product == "mosaic":
        planes = mosaic_planes(
            frame.linear_dn,
            frame.cfa_pattern,
            black=np.asarray(frame.black_levels_dn, np.float64),
            white=frame.white_levels_dn,
            lowest=0.0,
            holds_dark=True,
        )
    elif product in ("electrons", "mean_electrons"):
        planes = mosaic_planes(getattr(frame, product), frame.cfa_pattern, holds_dark=product == "electrons")
    else:
        raise InvalidValueError(f"{product!r}; give mosaic, electrons, mean_electrons or truth", key="product")
    return Picture(
        name=frame.report.scene,
        shape=(frame.mosaic.shape[0], frame.mosaic.shape[1]),
        planes=planes,
        pitch_um=frame.pitch_um,
        description=frame.description,
    )


def read_picture(
    path: str | os.PathLike[str],
    *,
    gamma: Gamma = None,
    cfa: str | None = None,
    layer: str | None = None,
    stored: bool = False,
) -> Picture:
    """Read an image file.

    gamma : encoding to undo: an exponent such as 2.2, or "srgb"; 1 declares the numbers linear
    cfa   : the colour filter array of a file that does not state it, such as RGGB
    layer : which image of an EXR, NPZ or MATLAB file that holds several, such as mean or noisy
    stored : codes as stored, to measure noise: those of 8 bits too; a DNG's opcode lists are not applied, and its black
             levels by row and column are subtracted as integers. Otherwise opcode lists are applied, or raise by name

    Four planes of a filter array, (4, rows, cols) or (rows, cols, 4), become its mosaic if ``cfa`` declares it: the
    planes are the positions (0, 0), (0, 1), (1, 0), (1, 1).

    Raises InputError for unreadable files, InvalidValueError for data that is not linear.

    >>> import tempfile
    >>> import numpy as np
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.save(Path(folder) / "mine.npy", np.full((8, 8), 900, np.uint16))
    ...     picture = read_picture(Path(folder) / "mine.npy", cfa="RGGB")
    >>> [plane.name for plane in picture.planes]
    ['R', 'G1', 'G2', 'B']
    """
    path = check(path, FilePath, "path")
    check(gamma, Gamma, "gamma")
    check(cfa, str | None, "cfa")
    check(layer, str | None, "layer")
    check(stored, bool, "stored")
    displayed = repr(str(path))
    suffix = Path(path).suffix
    with opened(path) as (file, size):
        reader = _READERS.get(suffix.lower())
        if reader is None:
            kinds = ", ".join(kind for kind in _READERS if kind not in libraw.SUFFIXES)
            raise InputError(
                f"a file of the kind {suffix or '(no suffix)'} cannot be measured; give {kinds} or a maker's raw file "
                f"({', '.join(libraw.SUFFIXES)})"
            )
        kind = suffix.lower()
        if layer is not None and kind not in _LAYERED:
            raise InvalidValueError(f"a {kind} has none; leave it out", key="layer", stage=displayed)
        if gamma not in (None, 1.0) and kind in _LINEAR:
            raise InvalidValueError(f"a {kind} is linear; leave it out", key="gamma", stage=displayed)
        record = None if kind in libraw.SUFFIXES else read_record(file, size)
        if record is not None and record.product == "preview" and gamma is None:
            raise InvalidValueError(
                "is a developed preview (tone curve, white balance, demosaiced), and linear data is needed; "
                "measure the capture's mosaic instead (.dng, .tiff or FILE.png:mosaic)",
                stage=displayed,
            )
        source = _Source(Path(path), file, size, record, gamma, cfa, layer, stored)
        try:
            return reader(source)
        except InvalidValueError as error:
            raise InvalidValueError(f"{error}", stage=displayed) from None


@dataclass(frozen=True, slots=True)
class _Source:
    """An open file, with its metadata and the user's declarations."""

    path: Path
    file: BinaryIO
    size: int
    record: Record | None
    gamma: Gamma
    cfa: str | None
    layer: str | None
    stored: bool

    @property
    def product(self) -> str | None:
        """The product in a file of camsim; None for other files."""
        return None if self.record is None else self.record.product


def _picture(source: _Source, planes: Sequence[Plane], shape: Sequence[int]) -> Picture:
    if source.record is not None:
        source.record.check_size(shape[0], shape[1])
    description = None if source.record is None else source.record.description
    camera = {} if description is None else description.get("camera")
    pitch_um = camera.get("pitch_um") if isinstance(camera, dict) else None
    known = isinstance(pitch_um, int | float) and pitch_um > 0
    return Picture(
        name=source.path.name,
        shape=(shape[0], shape[1]),
        planes=tuple(planes),
        pitch_um=float(pitch_um) if known and pitch_um is not None else None,
        description=description,
    )


def _pattern(source: _Source, said: tuple[str, ...] | None = None) -> tuple[str, ...]:
    """Return the rows of a colour filter array: from the file or its record, else from the user."""
    if said is None and source.record is not None:
        said = source.record.cfa_pattern
    if source.cfa is None:
        return said or ("Y",)
    given = filter_rows(source.cfa)
    if said is not None and given != said:
        raise InvalidValueError(f"{source.cfa!r}, and the file says {'/'.join(said)}; leave it out", key="cfa")
    return given


def _planes(image: npt.NDArray[Any], names: Sequence[str] | None, **levels: Any) -> tuple[Plane, ...]:
    """Return planes of (rows, cols) or (rows, cols, n)."""
    if image.ndim == 2:
        image = image[:, :, None]
    if image.ndim != 3 or not image.size or image.shape[2] > _MOST_PLANES:
        raise InvalidValueError(
            f"an array of shape {image.shape} is no image; give (rows, cols) or (rows, cols, channels)", key="image"
        )
    names = names or _NAMES.get(image.shape[2]) or tuple(f"C{k + 1}" for k in range(image.shape[2]))
    if len(names) != image.shape[2]:
        raise InputError(f"its record names {len(names)} channels and its image has {image.shape[2]}")
    return tuple(Plane(name=name, samples=image[:, :, k], **levels) for k, name in enumerate(names))


def _grey_or_planes(image: npt.NDArray[Any], source: _Source, product: str | None, **levels: Any) -> tuple[Plane, ...]:
    if image.ndim == 2 and product != "truth":
        if product == "mosaic" and source.record is not None:
            image = data_numbers(source.record.companding, image)
        return mosaic_planes(image, _pattern(source), **levels)
    names = source.record.channels if source.record is not None and product == "truth" else None
    return _unfiltered(_planes(image, names, **levels), source)


def _unfiltered(planes: tuple[Plane, ...], source: _Source) -> tuple[Plane, ...]:
    """Raise if a filter array is declared for an image with a plane per channel."""
    if source.cfa is not None and len(planes) > 1:
        raise InvalidValueError("it has a plane for each channel, and no filter array; leave it out", key="cfa")
    return planes


def _displayed(image: npt.NDArray[Any], source: _Source, largest: float) -> npt.NDArray[Any]:
    """Return the image without an opaque alpha channel; camsim's files have none."""
    return opaque(image, largest) if source.record is None else image


def _levels(image: npt.NDArray[Any], source: _Source, product: str | None, largest: float) -> dict[str, Any]:
    """Return black, white, the lowest code and whether dark charge is included; electrons have no levels."""
    record = source.record
    if record is not None and product == "mosaic":
        black = record.black_level_dn + np.asarray(record.black_offsets_dn, np.float64)
        return {"black": black, "white": record.white_levels_dn, "lowest": 0.0, "holds_dark": True}
    if np.issubdtype(image.dtype, np.integer):
        return {"white": largest, "lowest": float(np.iinfo(image.dtype).min), "holds_dark": record is None}
    return {"holds_dark": product == "electrons"}


def _linear(
    image: npt.NDArray[Any], gamma: Gamma, largest: float, *, encoded: bool, why: str
) -> tuple[npt.NDArray[Any], bool]:
    """Undo an encoding; raise for probably encoded data without a declaration. Also return whether it was changed."""
    if gamma is None:
        if encoded:
            raise InvalidValueError(
                f"{why}, so its numbers are probably gamma-encoded and linear data is needed; measure the raw "
                "file, or undo the encoding with --gamma srgb or --gamma 2.2 (--gamma 1 if the numbers are linear)"
            )
        return image, False
    if gamma == 1.0:
        return image, False
    return decode(image.astype(np.float64) / largest, gamma), True


def decode(encoded: F64, gamma: float | str) -> F64:
    """Undo a gamma encoding of values in 0..1.

    >>> decode(np.array([0.5]), "srgb").round(4), decode(np.array([0.5]), 2.0)
    (array([0.214]), array([0.25]))
    """
    if isinstance(gamma, str):
        if gamma.lower() != "srgb":
            raise InvalidValueError(f"{gamma!r}; give srgb or an exponent such as 2.2", key="gamma")
        return linear_of_srgb(encoded)
    if not 0.1 <= gamma <= 10.0:
        raise InvalidValueError(f"{gamma:g}; give srgb or an exponent between 0.1 and 10, such as 2.2", key="gamma")
    power: F64 = np.sign(encoded) * np.abs(encoded) ** gamma
    return power


def _after(levels: dict[str, Any], changed: bool) -> dict[str, Any]:
    """Return the levels of decoded values, which are in 0..1."""
    return {"white": 1.0} if changed else levels


def _of_stored(
    source: _Source, stored: npt.NDArray[Any], product: str | None, *, largest: float, encoded: bool, why: str
) -> Picture:
    """Return the linear picture of samples as stored, (rows, cols) or (rows, cols, n)."""
    image, encoded = _displayed(stored, source, largest), encoded and not (source.stored and stored.ndim == 2)
    image, changed = _linear(image, source.gamma, largest, encoded=encoded, why=why)
    planes = _grey_or_planes(image, source, product, **_after(_levels(image, source, product, largest), changed))
    return _picture(source, planes, image.shape)


def _read_tiff(source: _Source) -> Picture:
    first = read_directory(source.file, source.size)
    if DNG_VERSION in first.entries:
        return _read_dng(source)
    if _CFA_TAG in first.entries and source.path.suffix.lower() == ".dng":
        raise InputError("it is not a DNG; convert it to uncompressed DNG")
    directory = read_image_directory(source.file, source.size)
    bits = bits_per_sample(directory)
    stored = read_image(directory)
    return _of_stored(
        source,
        stored,
        source.product,
        largest=largest_sample(stored.dtype, bits),
        encoded=source.record is None and (bits == 8 or _COLOUR_PROFILE_TAG in directory.entries),
        why="it has 8 bits" if bits == 8 else "it has a colour profile",
    )


def _read_dng(source: _Source) -> Picture:
    """Read the main image of a DNG: its mosaic, or linear planes."""
    raw = read_raw(source.path, source.file, source.size, stored=source.stored)
    holds_dark = source.product != "truth"
    noted = libraw.NOTHING
    with contextlib.suppress(InputError):  # camsim's reader may read what LibRaw does not
        noted = libraw.read_noted(source.path)
    white_balance, to_camera = read_colours(source.file, source.size)
    iso, time_s = setting_noted(read_directory(source.file, source.size))  # LibRaw knows no ISO above 65535
    noted = replace(noted, iso=iso or noted.iso, time_s=time_s or noted.time_s, operations=raw.operations)
    noted = replace(noted, white_balance=white_balance, xyz_to_camera=to_camera, linear_dn=raw.linear_dn)
    if raw.image.ndim == 3:
        levels = zip(raw.black.flat, raw.white, strict=True)
        planes = tuple(
            replace(plane, black=float(black), white=white, lowest=raw.lowest, holds_dark=holds_dark)
            for plane, (black, white) in zip(_planes(raw.image, None), levels, strict=True)
        )
        return replace(_picture(source, _unfiltered(planes, source), raw.image.shape), noted=noted)
    pattern = _pattern(replace(source, record=None), raw.pattern)
    planes = mosaic_planes(
        raw.image, pattern, black=raw.black, white=raw.white[0], lowest=raw.lowest, holds_dark=holds_dark
    )
    return replace(_picture(source, planes, raw.image.shape), noted=noted)


def _read_maker(source: _Source) -> Picture:
    raw = libraw.read_unpacked(source.path)
    levels: dict[str, Any] = {"white": raw.white, "lowest": 0.0, "holds_dark": True}
    if raw.pattern is None:
        planes: tuple[Plane, ...] = tuple(
            replace(plane, black=float(black))
            for plane, black in zip(_unfiltered(_planes(raw.image, None, **levels), source), raw.black, strict=True)
        )
    else:
        planes = mosaic_planes(raw.image, _pattern(source, raw.pattern), black=raw.black, **levels)
    return replace(_picture(source, planes, raw.image.shape), noted=raw.noted)


def _read_pgm(source: _Source) -> Picture:
    stored, largest = pgm_reader.read_pixels(source.file, source.size)
    return _of_stored(source, stored, None, largest=largest, encoded=largest <= 255, why="it has 8 bits")


def _read_mat(source: _Source) -> Picture:
    source.file.seek(0)
    stored = next(iter(read_variables(source.path, source.file.read(520), source.size, source.layer).values()))
    return _of_array(source, stored)


def _packed(image: npt.NDArray[Any], source: _Source) -> npt.NDArray[Any]:
    """Return the mosaic of planes of a declared filter array, or of one plane; any other image unchanged."""
    if source.record is not None:
        return image
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    elif image.ndim == 3 and image.shape[0] == 1 and image.shape[2] > _MOST_PLANES:
        image = image[0]
    if source.cfa is not None:
        return mosaic_of(image, filter_rows(source.cfa))
    four = image.ndim == 3 and 4 in (image.shape[0], image.shape[2]) and image.dtype.kind in "ui"
    if four and image.dtype.itemsize > 1 and image[..., -1].max(initial=0) < largest_sample(image.dtype):
        raise InputError(
            f"its array of shape {image.shape} holds four planes, as of a filter array; say which, in their order: "
            "--cfa RGGB, in Python cfa='RGGB'"
        )
    return image


def _of_array(source: _Source, stored: npt.NDArray[Any]) -> Picture:
    """Return the picture of a plain array; 8 bits are probably encoded."""
    stored, eight, largest = _packed(_light(stored), source), stored.dtype == np.uint8, largest_sample(stored.dtype)
    return _of_stored(source, stored, None, largest=largest, encoded=eight, why="it has 8 bits")


def _read_png(source: _Source) -> Picture:
    header = png_reader.read_header(source.file, source.size, LONGEST_RECORD)
    stored = png_reader.read_pixels(source.file, source.size, header)
    few = header.bits <= 8
    return _of_stored(
        source,
        stored,
        source.product,
        largest=largest_sample(stored.dtype),
        encoded=source.product != "mosaic" and (few or abs(header.gamma - 1.0) > 0.01 or header.coloured),
        why=f"it has {header.bits} bits a sample" if few else "it names a colour space",
    )


def _read_exr(source: _Source) -> Picture:
    layers = exr_reader.read_layers(source.path, source.file, source.size)
    one = "noisy" if source.product == "electrons" else None
    chosen = image_layer(layers, one if source.layer is None else source.layer)
    here = layers[chosen]
    if alpha := {"A"}.intersection(here if source.record is None else ()):  # in camsim's files it is a filter
        refuse_transparent(here["A"], 1.0)
    names = [n for n in "RGB" if n in here] + [n for n in here if n not in {"R", "G", "B", *alpha}]
    if source.product == "electrons" or (len(names) == 1 and source.cfa is not None):
        dark = source.product == "electrons" and chosen == "noisy"
        planes = mosaic_planes(here[names[0]], _pattern(source), holds_dark=dark)
    else:
        planes = _unfiltered(tuple(Plane(name=name, samples=here[name]) for name in names), source)
    return _picture(source, planes, here[names[0]].shape)


def _read_npy(source: _Source) -> Picture:
    return _of_array(source, npy_reader.read_array(source.file, source.size))


def _light(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Raise for values that cannot be light."""
    if image.dtype == np.bool_:
        raise InputError("its array holds true and false, and no light")
    return image


def _read_npz(source: _Source) -> Picture:
    with npz_reader.opened(source.file, source.size) as archive:
        names = archive.arrays
        if not names:
            raise InputError("it holds no array")
        one = "mosaic" if "mosaic" in names else None
        chosen = image_array({name: archive.header(name).shape for name in names}, source.layer or one)
        stored = _packed(_light(archive.array(chosen)), source)
    largest = largest_sample(stored.dtype)
    image = _displayed(stored, source, largest)
    planes = _grey_or_planes(image, source, chosen, **_levels(image, source, chosen, largest))
    return _picture(source, planes, image.shape)


def _read_jpeg(source: _Source) -> Picture:
    stored = jpeg_reader.read_pixels(source.file, source.size)
    largest = largest_sample(stored.dtype)
    image, changed = _linear(stored, source.gamma, largest, encoded=True, why="it is a JPEG")
    return _picture(source, _planes(image, None, **_after(_levels(image, source, None, largest), changed)), image.shape)


_READERS = {
    ".dng": _read_tiff,
    ".tiff": _read_tiff,
    ".tif": _read_tiff,
    ".png": _read_png,
    ".exr": _read_exr,
    ".npy": _read_npy,
    ".npz": _read_npz,
    ".mat": _read_mat,
    ".pgm": _read_pgm,
    ".jpg": _read_jpeg,
    ".jpeg": _read_jpeg,
    **dict.fromkeys(libraw.SUFFIXES, _read_maker),
}

RAW = tuple(suffix for suffix in _READERS if suffix not in (".png", ".exr", ".jpg", ".jpeg"))
"""Suffixes of raw frames in a folder; other files there are previews and plots."""
