"""Pictures from files: interpretation of the values, converted to reflectances."""

from __future__ import annotations

import copy
import hashlib
import os
import weakref
from collections.abc import Mapping
from io import BufferedReader
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.core.calls import in_words
from camsim.core.typed import FilePath, NonNegative, Number, Place, Positive, Several, check, validate
from camsim.errors import CamsimError, InputError, InvalidValueError
from camsim.files.envi_reader import SUFFIXES as ENVI_SUFFIXES
from camsim.files.picture_samples import Read, read_samples
from camsim.files.reading import opened
from camsim.scene import Picture
from camsim.scene.raster import Interpolation
from camsim.spectra.light import Light
from camsim.spectra.rgb import Encoding, linear_colours

TOLERANCE = 1e-4

_ALIVE: weakref.WeakValueDictionary[str, Picture] = weakref.WeakValueDictionary()
"""Pictures in use by their file's content and how it was read: captures of a study share the samples of theirs."""


@in_words
def read_picture(
    path: str | os.PathLike[str],
    *,
    encoding: Encoding | float | None = None,
    scale: Number = 1.0,
    light: Light | None = None,
    wavelength_nm: Several[Number] | None = None,
    tolerance: Number = TOLERANCE,
    layer: str | None = None,
    width_um: Number | None = None,
    sample_um: Number | None = None,
    centre_um: Place = (0.0, 0.0),
    rotate_deg: Number = 0.0,
    interpolation: Interpolation = "squares",
) -> Picture:
    """Read a picture: PNG, JPEG, TIFF, EXR, NPY, NPZ, ENVI or MATLAB; colours or spectra.

    Photographs come upright (the orientation of EXIF and TIFF). Colours in whole numbers are uint8 or uint16.

    encoding      : of colours: "srgb" (whole numbers, where the file says nothing else), "linear" (all others, but of
                    divided codes it must be said), or an exponent such as 2.2
    scale         : factor on every number; colours in whole numbers are first divided by the largest possible one
    light         : of a cube of radiances in W·m⁻²·sr⁻¹·nm⁻¹: a diffuser's in it is a reflectance of 1
    wavelength_nm : wavelengths of a cube's bands, if its file does not state them
    tolerance     : how far a cube's planes may lie from it, see ``Picture.of_cube``
    layer         : an image of an EXR with several ("": channels without a layer), or an array of NPZ or MATLAB

    sample_um     : in place of ``width_um``: the side of one sample

    The rest is as of ``Picture``.
    Raises InputError or InvalidValueError in one sentence.

    >>> import tempfile
    >>> from pathlib import Path
    >>> import numpy as np
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.save(Path(folder) / "photo.npy", np.full((4, 6, 3), 0.5))
    ...     picture = read_picture(Path(folder) / "photo.npy", width_um=60.0)
    >>> picture.width_um, picture.planes.shape[:2]
    (60.0, (1, 4))
    """
    path = check(path, FilePath, "path")
    factor: float = check(scale, Positive, "scale")
    allowed: float = check(tolerance, NonNegative, "tolerance")
    check(layer, str | None, "layer")
    bands: list[float] | None = None if wavelength_nm is None else np.asarray(wavelength_nm, np.float64).tolist()
    how: dict[str, Any] = {"encoding": encoding, "scale": factor, "wavelength_nm": bands, "tolerance": allowed}
    how |= {} if layer is None else {"layer": layer}
    if (width_um is None) == (sample_um is None):
        which = "missing" if width_um is None else "given together with sample_um"
        message = f"{which}; give the width of all of it, or sample_um, the side of one of its samples"
        raise InvalidValueError(message, key="width_um", stage="read_picture")
    with opened(path) as (file, size):
        placed: dict[str, Any] = {
            "centre_um": centre_um,
            "rotate_deg": rotate_deg,
            "interpolation": interpolation,
            "source": Path(path).name,
            "read": None if light is not None else how,
        }
        try:
            each_um = None if sample_um is None else check(sample_um, Positive, "sample_um")
            kind, key = Path(path).suffix.lower(), ""
            if light is None and kind not in ENVI_SUFFIXES:  # whose samples are in another file
                key = f"{kind} {how} {hashlib.file_digest(cast(BufferedReader, file), 'sha256').hexdigest()}"
                file.seek(0)
            if known := _ALIVE.get(key):
                placed["width_um"] = width_um if each_um is None else each_um * known.shape[1]
                picture = _placed_again(known, placed)
            else:
                read = read_samples(Path(path), file, size, layer)
                placed["width_um"] = width_um if each_um is None else each_um * read.samples.shape[1]
                if read.wavelength_nm is not None or bands is not None:
                    picture = _cube(read, bands, factor, light, allowed, placed)
                else:
                    picture = _colours(read, encoding, factor, placed)
            if key:
                _ALIVE[key] = picture
            return picture
        except InputError:
            raise
        except CamsimError as error:
            raise InvalidValueError(str(error), stage=repr(str(path))) from None


def _placed_again(picture: Picture, placed: Mapping[str, Any]) -> Picture:
    """Return the same samples elsewhere, without checking and hashing them again."""
    another = copy.copy(picture)
    for name, value in placed.items():
        object.__setattr__(another, name, value)
    validate(another)
    return another


def _colours(read: Read, encoding: Encoding | float | None, scale: float, placed: dict[str, Any]) -> Picture:
    samples = read.samples
    if samples.ndim == 3 and samples.shape[2] != 3:
        raise InputError(
            f"it has {samples.shape[2]} bands and says no wavelengths; give wavelength_nm, one for each band, "
            "or a picture of 3 colours"
        )
    whole = samples.dtype.kind in "ui"
    if encoding is None and read.profile and "srgb" not in read.profile.lower():
        raise InputError(
            f"its colours are those of the profile {read.profile[:60]!r}; convert it to sRGB, or give encoding: "
            f"{'srgb' if whole else 'linear'} to take its numbers for sRGB's"
        )
    if not whole:
        _refuse_strange(samples)
    largest = None if read.bits is None else (1 << read.bits) - 1
    encoding = "linear" if read.linear and encoding is None and not whole else encoding
    light = linear_colours(samples, encoding, of_codes=read.gamma or "srgb", largest=largest)
    return Picture.of_rgb(_fractions(np.asarray(light, np.float64) * scale), encoding="linear", **placed)


def _cube(
    read: Read,
    wavelength_nm: list[float] | None,
    scale: float,
    light: Light | None,
    tolerance: float,
    placed: dict[str, Any],
) -> Picture:
    nodes = np.asarray(read.wavelength_nm if wavelength_nm is None else wavelength_nm, np.float64)
    samples = read.samples if read.samples.ndim == 3 else read.samples[..., None]
    if nodes.shape != (samples.shape[2],):
        raise InputError(f"it has {samples.shape[2]} bands, and {nodes.size} wavelengths are given")
    values = np.asarray(samples, np.float64) * scale
    _refuse_strange(values)
    if light is not None:
        radiance = light.irradiance_at(nodes) / np.pi
        if not (radiance > 0).all():
            dark = float(nodes[np.argmin(radiance)])
            raise InvalidValueError(f"has nothing at {dark:g} nm, where the cube has a band", key="light")
        values = values / radiance
    elif read.emissive and scale == 1.0:
        raise InputError(
            "its bands are radiances; give the light that fell on the scene, to make reflectances of them, or scale"
        )
    return Picture.of_cube(_fractions(values), nodes.tolist(), tolerance=tolerance, **placed)


def _refuse_strange(values: npt.NDArray[Any]) -> None:
    if not np.isfinite(values).all():
        row, col, *_ = np.argwhere(~np.isfinite(values))[0].tolist()
        raise InputError(f"its sample [{row}, {col}] is not a finite number")


def _fractions(values: F64) -> F64:
    low, high = float(values.min()), float(values.max())
    if low < -1e-6 or high > 1.0 + 1e-6:
        way_out = "no reflectance is below 0"
        if low >= -1e-6:
            way_out = f"a reflectance is 0 to 1; give the white's, or {float(f'{0.99 / high:.2g}'):g} for the brightest"
        raise InvalidValueError(f"makes samples from {low:g} to {high:g}, and {way_out}", key="scale")
    return np.clip(values, 0.0, 1.0, out=values)
