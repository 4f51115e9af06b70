"""Given light from a file: its samples, and their unit if the format states it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, get_args

import numpy as np

from camsim.camera.given_light import RELATIVE, GivenLight, Unit
from camsim.core.calls import in_words
from camsim.core.typed import FilePath, Number, Several, Whole, check
from camsim.core.words import either
from camsim.errors import CamsimError, InputError, InvalidValueError
from camsim.files.picture_samples import Read, read_samples
from camsim.files.reading import opened


@in_words
def read_light(
    path: str | os.PathLike[str],
    *,
    unit: Unit | None = None,
    wavelength_nm: Several[Number] | None = None,
    per_photosite: Whole = 1,
    layer: str | None = None,
) -> GivenLight:
    """Read light for a sensor: NPY, NPZ, EXR, TIFF, PNG, JPEG, ENVI or MATLAB.

    unit          : unit of the numbers, see ``GivenLight``. None: "srgb" for whole numbers in PNG, JPEG and TIFF,
                    "reflectance" of an EXR's colours and of bands; required for others
    wavelength_nm : wavelengths of bands, if the file does not state them
    per_photosite : samples along the side of a photosite
    layer         : which image of an EXR that holds several, or which array of NPZ or MATLAB

    Nothing is scaled, clipped or resampled. Raises InputError or InvalidValueError in one sentence.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.save(Path(folder) / "mean.npy", np.full((4, 6), 250.0))
    ...     light = read_light(Path(folder) / "mean.npy", unit="electrons")
    >>> light.samples.shape, Path(light.source).name
    ((4, 6), 'mean.npy')
    """
    path = check(path, FilePath, "path")
    check(layer, str | None, "layer")
    with opened(path) as (file, size):
        try:
            read = read_samples(Path(path), file, size, layer)
            known = _unit(Path(path), read) if unit is None else unit
            given = read.wavelength_nm if wavelength_nm is None else wavelength_nm
            coloured = given is not None and known != "electrons"
            return GivenLight(
                samples=_samples(read, known),
                unit=known,
                wavelength_nm=tuple(np.asarray(given, float).tolist()) if coloured else None,
                per_photosite=per_photosite,
                source=Path(path).as_posix(),
                read={} if layer is None else {"layer": layer},
            )
        except InputError:
            raise
        except CamsimError as error:
            raise InvalidValueError(str(error), stage=repr(str(path))) from None


def _unit(path: Path, read: Read) -> Unit:
    """Return the unit stated by a file; raises InputError if none or unsupported."""
    whole = read.samples.dtype.kind in "ui"
    if read.emissive:
        raise InputError("its bands are radiances of no sensor's; give unit (--as): irradiance on it, or reflectance")
    if read.wavelength_nm is not None:
        return "reflectance"
    if read.profile and "srgb" not in read.profile.lower():
        way_out = f"convert it to sRGB, or give unit (--as) {'srgb' if whole else 'reflectance'} to take it for sRGB"
        raise InputError(f"its colours are those of the profile {read.profile[:60]!r}; {way_out}")
    if read.gamma is not None:
        says = f"its numbers have the exponent {read.gamma:g}"
        raise InputError(f"{says}; give unit (--as): reflectance to take them as linear, or srgb")
    if read.linear and not whole:
        return "reflectance"
    if whole and path.suffix.lower() in (".png", ".jpg", ".jpeg", ".tif", ".tiff"):
        return "srgb"
    raise InputError(f"its numbers may be anything; give unit (--as): {either(get_args(Unit))}")


def _samples(read: Read, unit: Unit) -> Any:
    """Return the samples; integers with fewer bits than their type as fractions of their largest."""
    if read.bits is None or unit not in RELATIVE or read.samples.dtype.kind not in "ui":
        return read.samples
    largest = (1 << read.bits) - 1
    return read.samples if largest == np.iinfo(read.samples.dtype).max else read.samples / np.float32(largest)
