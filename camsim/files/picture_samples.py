"""Samples of a picture from a file of any supported format: colours, or spectra with wavelengths."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.errors import InputError, InvalidValueError
from camsim.files import exr_reader, jpeg_reader, npy_reader, npz_reader, png_reader
from camsim.files.envi_reader import SUFFIXES as ENVI_SUFFIXES
from camsim.files.envi_reader import read_cube
from camsim.files.exif import colours_noted, in_exif
from camsim.files.full_scale import largest_sample, opaque, refuse_transparent
from camsim.files.icc import profile_name
from camsim.files.limits import refuse_many
from camsim.files.matlab_reader import read_variables
from camsim.files.orientation import orientation_in, orientation_in_exif, upright
from camsim.files.primaries import other_than_srgb
from camsim.files.tiff_image import bits_per_sample, read_image
from camsim.files.tiff_reader import read_image_directory
from camsim.files.which_image import has_grey, image_array, image_layer, nanometres

_COLOUR_PROFILE_TAG, _WHITE_POINT_TAG, _PRIMARIES_TAG = 34675, 318, 319
_LAYERED = (".exr", ".npz", ".mat")
_WAVELENGTHS = ("wavelength_nm", "wavelengths", "wavelength", "wavelengths_nm", "bands", "lambda", "wl", "wave")
_NO_RANK = 2 * len(_WAVELENGTHS)


@dataclass(frozen=True, slots=True)
class Read:
    """Content of a file.

    samples       : (rows, cols), or (rows, cols, n) colours or bands, upright; integers as stored
    wavelength_nm : wavelengths of bands; None for colours, or if not stated
    gamma         : an exponent stated by the file;  bits: those of integers, if fewer than their type has
    profile       : name of the colour profile, empty for none
    emissive      : whether bands are radiances;  linear: whether the format is one of light
    """

    samples: npt.NDArray[Any]
    wavelength_nm: F64 | None = None
    gamma: float | None = None
    bits: int | None = None
    profile: str = ""
    emissive: bool = False
    linear: bool = False


def read_samples(path: Path, file: BinaryIO, size: int, layer: str | None = None) -> Read:
    """Read the samples of an open file's image, or of the layer that is named; raises CamsimError in one sentence.

    layer : a layer of an EXR, or an array of NPZ or MATLAB
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(
            f"a file of the kind {path.suffix or '(no suffix)'} is no picture that is read; give {', '.join(READERS)}"
        )
    if layer is not None and path.suffix.lower() not in _LAYERED:
        raise InvalidValueError(f"a {path.suffix.lower()} has none; leave it out", key="layer")
    read = reader(path, file, size, layer)
    if read.samples.dtype.kind not in "uif":
        raise InputError(f"its samples are {read.samples.dtype}, and real numbers are needed")
    if read.samples.ndim not in (2, 3) or not read.samples.size:
        raise InputError(f"its array has the shape {read.samples.shape}; (rows, cols) or (rows, cols, bands) is needed")
    refuse_many(read.samples.size)
    return read


def _png(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    header = png_reader.read_header(file, size, 1 << 24)
    stored = png_reader.read_pixels(file, size, header)
    image = opaque(stored, largest_sample(stored.dtype))
    named = None if header.coloured or abs(header.gamma - 1.0) < 1e-4 else 1.0 / header.gamma
    # Writers of sRGB also state 0.45455.
    gamma = None if named is None or abs(named - 2.2) < 0.01 else named
    noted = "" if header.coloured else in_exif(header.exif, colours_noted, "")
    profile = profile_name(header.profile) or ((header.space or noted) if image.ndim == 3 else "")
    return Read(upright(image, orientation_in_exif(header.exif)), gamma=gamma, profile=profile)


def _jpeg(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    pixels = jpeg_reader.read_pixels(file, size)
    file.seek(0)
    data = file.read(size)
    exif = jpeg_reader.exif(data)
    profile = profile_name(jpeg_reader.profile(data)) or (in_exif(exif, colours_noted, "") if pixels.ndim == 3 else "")
    return Read(upright(pixels, orientation_in_exif(exif)), profile=profile)


def _tiff(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    directory = read_image_directory(file, size)
    bits = bits_per_sample(directory)
    stored = read_image(directory)
    image = opaque(stored, largest_sample(stored.dtype, bits))
    noted = directory.bytes_of(_COLOUR_PROFILE_TAG, 1 << 24) if _COLOUR_PROFILE_TAG in directory.entries else b""
    x_y = (*directory.values(_PRIMARIES_TAG), *directory.values(_WHITE_POINT_TAG))
    profile = profile_name(noted)
    if image.ndim == 3 and not profile:
        space = other_than_srgb(x_y, "PrimaryChromaticities") if len(x_y) == 8 else ""
        profile = space or colours_noted(directory)
    return Read(upright(image, orientation_in(directory)), bits=bits, profile=profile)


def _exr(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    header = exr_reader.read_header(file, size, 1 << 24)
    layers = exr_reader.read_layers(path, file, size)
    channels = layers[image_layer(layers, layer)]
    bands = sorted((nm, name) for name in channels if (nm := nanometres(name)) is not None)
    if bands:
        samples = np.stack([channels[name] for _, name in bands], axis=2)
        emissive = header.text("emissiveUnits") is not None
        return Read(samples, np.array([nm for nm, _ in bands]), emissive=emissive)
    if "A" in channels:
        refuse_transparent(channels["A"], 1.0)
    if all(colour in channels for colour in "RGB"):
        space = other_than_srgb(header.primaries(), "chromaticities")
        return Read(np.stack([channels[colour] for colour in "RGB"], axis=2), profile=space, linear=True)
    named = [name for name in channels if name != "A"]
    if has_grey(channels) or len(named) == 1:
        return Read(channels["Y" if "Y" in channels else named[0]], linear=True)
    raise InputError(f"its channels are {', '.join(named[:8])}; R, G, B, or Y, or names in nm are needed")


def _npy(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    return Read(npy_reader.read_array(file, size))


def _npz(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    with npz_reader.opened(file, size) as archive:
        shapes = {name: archive.header(name).shape for name in archive.arrays}
        chosen = image_array(shapes, layer)
        refuse_many(math.prod(shapes[chosen]))
        arrays = {name: archive.array(name) for name in shapes if name == chosen or math.prod(shapes[name]) <= 4096}
    return Read(arrays[chosen], _wavelengths_in(arrays, chosen))


def _envi(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    cube = read_cube(path)
    return Read(cube.samples, cube.wavelength_nm)


def _matlab(path: Path, file: BinaryIO, size: int, layer: str | None) -> Read:
    file.seek(0)
    arrays = read_variables(path, file.read(520), size, layer)
    chosen = next(iter(arrays))
    return Read(arrays[chosen], _wavelengths_in(arrays, chosen))


def _wavelengths_in(arrays: Mapping[str, npt.NDArray[Any]], cube: str) -> F64 | None:
    """Return the array with one number per band whose name denotes wavelengths."""
    if arrays[cube].ndim != 3:
        return None
    bands = arrays[cube].shape[2]
    for name in sorted(arrays, key=_rank):
        array = arrays[name]
        if name != cube and _rank(name) < _NO_RANK and array.size == bands and max(array.shape) == bands:
            values = np.asarray(array, np.float64).ravel()
            return values if values.max() > 30.0 else values * 1e3  # given in µm
    return None


def _rank(name: str) -> int:
    """Return the rank of a name as wavelengths, the best lowest: a word for them, then names that contain one."""
    lowered = name.lower()
    words = [*(lowered == word for word in _WAVELENGTHS), *(word in lowered for word in _WAVELENGTHS)]
    return words.index(True) if True in words else _NO_RANK


READERS: Mapping[str, Callable[[Path, BinaryIO, int, str | None], Read]] = {
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
