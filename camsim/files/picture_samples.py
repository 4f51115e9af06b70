"""Samples of a picture from a file of any format that is read: linear light in colours, or spectra with wavelengths."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64
from camsim.errors import InputError
from camsim.files import exr_reader, jpeg_reader, npy_reader, npz_reader, png_reader
from camsim.files.envi_reader import SUFFIXES as ENVI_SUFFIXES
from camsim.files.envi_reader import read_cube
from camsim.files.icc import profile_name
from camsim.files.limits import refuse_many
from camsim.files.matlab_reader import read_variables
from camsim.files.orientation import orientation_in, orientation_in_exif, upright
from camsim.files.tiff_image import bits_per_sample, read_image
from camsim.files.tiff_reader import read_directory

_COLOUR_PROFILE_TAG = 34675
_SPECTRAL = re.compile(r"^(?:.*\.)?(?:w|S0\.|T\.)?(\d+(?:[.,]\d+)?) ?nm$")
"""Channels of Fichet's layout (S0.550,000000nm, T.550,000000nm) and others such as w550nm and 550nm."""
_POLARISED = re.compile(r"^(?:.*\.)?S[1-3]\.")
_WAVELENGTHS = ("wavelength_nm", "wavelengths", "wavelength", "wavelengths_nm", "bands", "lambda", "wl", "wave")


@dataclass(frozen=True, slots=True)
class Read:
    """What a file holds.

    samples       : (rows, cols), or (rows, cols, n) colours or bands, upright; whole numbers as they are stored
    wavelength_nm : of bands; None for colours, or where the file does not say
    gamma         : an exponent that the file names;  bits: of whole numbers, where they are fewer than their type's
    profile       : name of the colour profile, empty for none
    emissive      : whether bands are radiances
    """

    samples: npt.NDArray[Any]
    wavelength_nm: F64 | None = None
    gamma: float | None = None
    bits: int | None = None
    profile: str = ""
    emissive: bool = False


def read_samples(path: Path, file: BinaryIO, size: int) -> Read:
    """Read the samples of an open file; raises InputError in one sentence."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(
            f"a file of the kind {path.suffix or '(no suffix)'} is no picture that is read; give {', '.join(READERS)}"
        )
    read = reader(path, file, size)
    if read.samples.dtype.kind not in "uif":
        raise InputError(f"its samples are {read.samples.dtype}, and real numbers are needed")
    if read.samples.ndim not in (2, 3) or not read.samples.size:
        raise InputError(f"its array has the shape {read.samples.shape}; (rows, cols) or (rows, cols, bands) is needed")
    refuse_many(read.samples.size)
    return read


def _opaque(image: npt.NDArray[Any], colours: int) -> npt.NDArray[Any]:
    """Return the image without an alpha channel that hides nothing."""
    if image.ndim == 2 or image.shape[2] == colours:
        return image
    alpha = image[..., colours]
    top = np.iinfo(image.dtype).max if image.dtype.kind in "ui" else 1.0
    if image.shape[2] != colours + 1 or (alpha < top).any():
        raise InputError("it is transparent in places (alpha), and nobody knows what lies behind; flatten it first")
    return image[..., :colours] if colours > 1 else image[..., 0]


def _png(path: Path, file: BinaryIO, size: int) -> Read:
    header = png_reader.read_header(file, size, 1 << 24)
    colours = 3 if header.colour in (2, 6) else 1
    if header.see_through:
        raise InputError("one of its colours is transparent (tRNS), and nobody knows what is behind; flatten it first")
    if header.bits == 16 and colours == 3:
        image = png_reader.read_deep_colours(file, size, header)
    else:
        image = png_reader.read_pixels(file, size, header)
    if image.dtype == np.bool_:
        image = image.astype(np.uint8) * np.uint8(255)
    named = None if header.coloured or abs(header.gamma - 1.0) < 1e-4 else 1.0 / header.gamma
    # 0.45455 is what writers of sRGB give besides.
    gamma = None if named is None or abs(named - 2.2) < 0.01 else named
    profile = profile_name(header.profile) or (header.space if colours == 3 else "")
    return Read(upright(_opaque(image, colours), orientation_in_exif(header.exif)), gamma=gamma, profile=profile)


def _jpeg(path: Path, file: BinaryIO, size: int) -> Read:
    file.seek(0)
    data = file.read(size)
    components = jpeg_reader.frame_header(data).components
    if components not in (1, 3):
        raise InputError(f"it has {components} colours (CMYK, for printing); convert it to sRGB first")
    image = upright(jpeg_reader.read_pixels(file, size), orientation_in_exif(jpeg_reader.exif(data)))
    return Read(image, profile=profile_name(jpeg_reader.profile(data)))


def _tiff(path: Path, file: BinaryIO, size: int) -> Read:
    directory = read_directory(file, size)
    image = read_image(directory)
    if image.ndim == 3 and image.shape[2] in (2, 4):
        image = _opaque(image, image.shape[2] - 1)
    profile = directory.bytes_of(_COLOUR_PROFILE_TAG, 1 << 24) if _COLOUR_PROFILE_TAG in directory.entries else b""
    bits = bits_per_sample(directory)
    return Read(upright(image, orientation_in(directory)), bits=bits, profile=profile_name(profile))


def _exr(path: Path, file: BinaryIO, size: int) -> Read:
    header = exr_reader.read_header(file, size, 1 << 24)
    channels = exr_reader.read_pixels(path, file, size)
    bands = {name: m for name in channels if not _POLARISED.match(name) and (m := _SPECTRAL.match(name))}
    if bands:
        order = sorted(bands, key=lambda name: float(bands[name][1].replace(",", ".")))
        wavelength_nm = np.array([float(bands[name][1].replace(",", ".")) for name in order])
        emissive = header.text("emissiveUnits") is not None
        return Read(np.stack([channels[name] for name in order], axis=2), wavelength_nm, emissive=emissive)
    alpha = next((image for name, image in channels.items() if name.split(".")[-1] == "A"), None)
    if alpha is not None and (np.asarray(alpha) < 1.0).any():
        raise InputError("it is transparent in places (alpha), and nobody knows what lies behind; flatten it first")
    by_colour = {name.split(".")[-1]: image for name, image in channels.items()}
    if all(colour in by_colour for colour in "RGB"):
        return Read(np.stack([by_colour[colour] for colour in "RGB"], axis=2))
    if "Y" in by_colour or len(by_colour) == 1:
        return Read(by_colour.get("Y", next(iter(by_colour.values()))))
    raise InputError(f"its channels are {', '.join(list(channels)[:8])}; R, G, B, or Y, or names in nm are needed")


def _npy(path: Path, file: BinaryIO, size: int) -> Read:
    return Read(npy_reader.read_array(file, size))


def _npz(path: Path, file: BinaryIO, size: int) -> Read:
    with npz_reader.opened(file, size) as archive:
        shapes = {name: archive.header(name).shape for name in archive.arrays}
        deep = [name for name, shape in shapes.items() if len(shape) == 3]
        deep = deep or [name for name, shape in shapes.items() if len(shape) == 2]
        if not deep:
            raise InputError("it holds no array of (rows, cols, bands)")
        largest = max(deep, key=lambda name: math.prod(shapes[name]))
        refuse_many(math.prod(shapes[largest]))
        arrays = {name: archive.array(name) for name in shapes if name == largest or math.prod(shapes[name]) <= 4096}
    return Read(arrays[largest], _wavelengths_in(arrays, largest))


def _envi(path: Path, file: BinaryIO, size: int) -> Read:
    cube = read_cube(path)
    return Read(cube.samples, cube.wavelength_nm)


def _matlab(path: Path, file: BinaryIO, size: int) -> Read:
    file.seek(0)
    arrays = read_variables(path, file.read(520), size)
    largest = next(iter(arrays))
    return Read(arrays[largest], _wavelengths_in(arrays, largest))


def _wavelengths_in(arrays: Mapping[str, npt.NDArray[Any]], cube: str) -> F64 | None:
    """Return the list of as many numbers as there are bands whose name says that it is of wavelengths."""
    if arrays[cube].ndim != 3:
        return None
    bands = arrays[cube].shape[2]
    for name in sorted(arrays, key=lambda name: _rank(name)):
        array = arrays[name]
        if name != cube and _rank(name) < len(_WAVELENGTHS) and array.size == bands and max(array.shape) == bands:
            values = np.asarray(array, np.float64).ravel()
            return values if values.max() > 30.0 else values * 1e3  # given in µm
    return None


def _rank(name: str) -> int:
    lowered = name.lower()
    return next((k for k, word in enumerate(_WAVELENGTHS) if lowered == word or word in lowered), len(_WAVELENGTHS))


READERS: Mapping[str, Callable[[Path, BinaryIO, int], Read]] = {
    ".png": _png,
    ".tif": _tiff,
    ".tiff": _tiff,
    ".jpg": _jpeg,
    ".jpeg": _jpeg,
    ".exr": _exr,
    ".npy": _npy,
    ".npz": _npz,
    ".mat": _matlab,
    **{suffix: _envi for suffix in ENVI_SUFFIXES if suffix},
}
