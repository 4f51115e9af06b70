"""ENVI cubes: a text header and a file of numbers, in three interleaves and either byte order."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.errors import InputError
from camsim.files.limits import refuse_many

SUFFIXES = (".hdr", ".img", ".dat", ".raw", ".bsq", ".bil", ".bip", "")
_LONGEST_HEADER = 4 << 20
_TYPES = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4", 14: "i8", 15: "u8"}
_ORDERS = {"bsq": (1, 2, 0), "bil": (0, 2, 1), "bip": (0, 1, 2)}
"""Permutations of the file's axes to rows, columns, bands."""
_NM = {"nanometers": 1.0, "nanometres": 1.0, "nm": 1.0, "micrometers": 1e3, "micrometres": 1e3, "um": 1e3, "µm": 1e3}


@dataclass(frozen=True, slots=True)
class Cube:
    """Samples (rows, cols, bands), and the wavelengths of the bands if stated in the file."""

    samples: npt.NDArray[Any]
    wavelength_nm: F64 | None


def read_cube(path: Path) -> Cube:
    """Return the numbers of a pair of files, of which ``path`` is either; memory-mapped until needed."""
    header, data = _pair(path)
    if header.stat().st_size > _LONGEST_HEADER:
        raise InputError(f"its header {header.name} has {header.stat().st_size} bytes, more than any")
    text = header.read_text(encoding="utf-8", errors="replace")
    if not text.lstrip("\ufeff").startswith("ENVI"):
        raise InputError(f"its header {header.name} does not begin with ENVI")
    said = {
        key.strip().lower(): value.strip()
        for key, value in re.findall(r"^([^=\n{}]+)=\s*(\{[^}]*\}|[^\n]*)", text, re.MULTILINE)
    }
    rows, cols, bands = (_whole(said, key) for key in ("lines", "samples", "bands"))
    dtype = _TYPES.get(_whole(said, "data type"))
    if dtype is None:
        raise InputError(f"its numbers are of ENVI's type {said['data type']}; real ones are read, types {_known()}")
    interleave = said.get("interleave", "bsq").lower()
    if interleave not in _ORDERS:
        raise InputError(f"its interleave is {interleave[:20]!r}; bsq, bil or bip is needed")
    order = ">" if _whole(said, "byte order", 0) == 1 else "<"
    before = _whole(said, "header offset", 0)
    shape = {"bsq": (bands, rows, cols), "bil": (rows, bands, cols), "bip": (rows, cols, bands)}[interleave]
    kind = np.dtype(f"{order}{dtype}")
    needed, size = before + math.prod(shape) * kind.itemsize, data.stat().st_size
    if min(shape) < 1 or needed > size:
        raise InputError(
            f"it is cut short: its header says {rows} × {cols} × {bands} numbers, {needed} bytes, and {data.name} has "
            f"{size}"
        )
    refuse_many(math.prod(shape))
    numbers = np.memmap(data, kind, "r", before, shape).transpose(_ORDERS[interleave])
    return Cube(_scaled(numbers, said), _wavelengths(said, bands))


def _pair(path: Path) -> tuple[Path, Path]:
    """Return header and data."""
    if path.suffix.lower() == ".hdr":
        stem = path.with_suffix("")
        for suffix in ("", ".img", ".dat", ".raw", ".bsq", ".bil", ".bip"):
            if (data := stem.with_name(stem.name + suffix)).is_file():
                return path, data
        raise InputError(f"there are no numbers beside it: no {stem.name} and no {stem.name}.img, .dat or .raw")
    for header in (path.with_suffix(".hdr"), path.with_name(path.name + ".hdr")):
        if header.is_file():
            return header, path
    raise InputError(f"there is no ENVI header beside it: no {path.with_suffix('.hdr').name}")


def _whole(said: dict[str, str], key: str, default: int | None = None) -> int:
    text = said.get(key)
    if text is None and default is not None:
        return default
    if text is None or not re.fullmatch(r"\d{1,12}", text):
        raise InputError(f"its header says no whole number for {key!r}")
    return int(text)


def _scaled(numbers: npt.NDArray[Any], said: dict[str, str]) -> npt.NDArray[Any]:
    """Return reflectances, if the header states the scale."""
    try:
        whole = float(said.get("reflectance scale factor", "1"))
    except ValueError:
        raise InputError("its reflectance scale factor is no number") from None
    if not (math.isfinite(whole) and whole > 0):
        raise InputError(f"its reflectance scale factor is {whole:g}")
    return numbers if whole == 1.0 else numbers / np.float64(whole)


def _wavelengths(said: dict[str, str], bands: int) -> F64 | None:
    if "wavelength" not in said:
        return None
    words = said["wavelength"].strip("{} \n").replace(",", " ").split()
    try:
        wavelength = np.array([float(word) for word in words])
    except ValueError:
        raise InputError("its wavelengths are no numbers") from None
    unit = said.get("wavelength units", "").lower()
    if unit not in _NM and unit not in ("", "unknown"):
        raise InputError(f"its wavelengths are in {unit[:20]!r}; nanometers or micrometers are read")
    # Without a unit: no camera responds to 30 nm, and no table has 30 µm.
    scale = _NM.get(unit, 1.0 if wavelength.size and wavelength.max() > 30.0 else 1e3)
    if wavelength.size != bands:
        raise InputError(f"it has {bands} bands and {wavelength.size} wavelengths")
    return wavelength * scale


def _known() -> str:
    return ", ".join(map(str, _TYPES))
