"""Measured cameras in files of other projects: rawtoaces, the 28 cameras of Jiang et al., ISETCam, tables in CSV."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.errors import CamsimError, InputError, UnknownNameError, in_brief
from camsim.spectra.csv_table import MAX_BYTES, columns, read_points
from camsim.spectra.curve import Curve

_JIANG_NM = np.arange(400.0, 721.0, 10.0)
"""Jiang et al., "What is the space of spectral sensitivity functions for digital color cameras?" (WACV 2013).

A line with a camera's name, then a line each of 33 numbers for red, green and blue.
"""

_LETTERS = {
    "red": "R", "r": "R", "green": "G", "g": "G", "blue": "B", "b": "B", "gr": "Gr", "greenr": "Gr", "gb": "Gb",
    "greenb": "Gb", "g1": "Gr", "green1": "Gr", "g2": "Gb", "green2": "Gb", "cyan": "C", "c": "C", "yellow": "Y",
    "y": "Y", "magenta": "M", "m": "M", "white": "W", "w": "W", "clear": "W", "mono": "Y", "monochrome": "Y",
}  # fmt: skip
_UNIT = re.compile(r"[\[(].*?[\])]")
_BETWEEN = re.compile(r"[\W_]+")
_PER_WATT = re.compile(r"a\s*/\s*w\b|\bper\s+watt", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraCurves:
    """The sensitivities of one camera.

    curves   : curve of each channel by its letter, in the file's order
    per      : whether the curves are responses per photon or per energy
    absolute : whether they are electrons per photon, or A/W if per energy; otherwise their scale is free
    whole    : whether they include the camera's filters, as when a camera was measured; those of a bare chip do not
    """

    name: str
    curves: Mapping[str, Curve]
    per: Literal["energy", "photon"]
    absolute: bool = False
    whole: bool = True
    source: str = ""


def read_cameras(path: Path) -> tuple[CameraCurves, ...]:
    """Read the cameras of a file: .json of rawtoaces, .txt of 28 cameras, .mat of ISETCam, .csv of EMVA 1288.

    Raises InputError in one sentence.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{str(path)!r}: not a file of sensitivities; give {', '.join(_READERS)}")
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(f"{str(path)!r}: {(error.strerror or str(error)).lower()}") from None
    if size > MAX_BYTES:
        raise InputError(f"{str(path)!r}: larger than {MAX_BYTES // 2**20} MB, the most that is read")
    try:
        return tuple(reader(path))
    except InputError as error:
        raise InputError(error.message if str(path) in error.message else f"{str(path)!r}: {error.message}") from None
    except CamsimError as error:
        raise InputError(f"{str(path)!r}: {error.message}") from None


def camera_of(path: Path, name: str | None) -> CameraCurves:
    """Return the camera of a file, or of several the one named; raises UnknownNameError with the names available."""
    cameras = {camera.name: camera for camera in read_cameras(path)}
    if name is None and len(cameras) > 1:
        displayed = ", ".join(sorted(cameras))
        raise InputError(f"{str(path)!r} has {len(cameras)} cameras; say which by --camera: {displayed}")
    if name is not None and name not in cameras:
        raise UnknownNameError("camera", name, sorted(cameras), key="--camera")
    return cameras[name or next(iter(cameras))]


def _rawtoaces(path: Path) -> Sequence[CameraCurves]:
    try:
        tree = json.loads(path.read_bytes())
        header, spectra = tree.get("header", {}), tree["spectral_data"]
        letters = [str(letter) for letter in spectra["index"]["main"]]
        rows = sorted((float(nm), np.array(values, np.float64)) for nm, values in spectra["data"]["main"].items())
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
        why = f"{in_brief(error)}" if isinstance(error, ValueError) else "it lacks spectral_data with index and data"
        raise InputError(f"no camera as rawtoaces writes it: {why}") from None
    if any(values.shape != (len(letters),) for _, values in rows):
        raise InputError(f"each wavelength has {len(letters)} numbers, for {', '.join(letters)}, and some have others")
    name = " ".join(str(header.get(key) or "") for key in ("manufacturer", "model")).strip() or path.stem
    nodes_nm, values = np.array([nm for nm, _ in rows]), np.array([row for _, row in rows])
    return [
        CameraCurves(
            name=name, curves=_curves(nodes_nm, values, letters), per="energy", source=f"rawtoaces, {path.name}"
        )
    ]


def _jiang(path: Path) -> Sequence[CameraCurves]:
    lines = [line.strip() for line in path.read_text("utf-8", "replace").splitlines() if line.strip()]
    cameras, name, rows = [], "", list[F64]()
    for number, line in enumerate(lines, 1):
        if re.match(r"[+-]?\.?\d", line):
            try:
                row = np.array([float(word) for word in re.split(r"[\s,;]+", line)])
            except ValueError:
                raise InputError(f"line {number} begins with a number and holds other words") from None
            if row.size != _JIANG_NM.size:
                raise InputError(f"line {number} has {row.size} numbers; 33 are wanted, from 400 to 720 nm every 10")
            rows.append(row)
        elif name and len(rows) != 3:
            raise InputError(f"{name!r} has {len(rows)} lines of numbers; 3 are wanted, of red, green and blue")
        else:
            name, rows = line, []
        if len(rows) == 3:
            curves = _curves(_JIANG_NM, np.array(rows).T, ["R", "G", "B"])
            source = f"Jiang et al. 2013, {path.name}"
            cameras.append(CameraCurves(name=name, curves=curves, per="energy", source=source))
    if not cameras or not name or len(rows) != 3:
        raise InputError("no cameras in it: a line with a name, then three lines of 33 numbers, and so on")
    return cameras


def _isetcam(path: Path) -> Sequence[CameraCurves]:
    try:
        held: dict[str, Any] = scipy.io.loadmat(str(path), squeeze_me=True)
    except Exception as error:  # any error of SciPy for damaged files
        raise InputError(f"no MATLAB file of versions 4 to 7 ({in_brief(error)}); save it with -v7") from None
    if not {"wavelength", "data", "filterNames"} <= set(held):
        raise InputError("no colour filters as ISETCam saves them: wavelength, data and filterNames")
    if any(held[key].dtype.kind not in "fiu" for key in ("wavelength", "data")):
        raise InputError("its data are no plain numbers; save them as double")
    nodes_nm, values = np.atleast_1d(held["wavelength"].astype(np.float64)), held["data"].astype(np.float64)
    names = [str(name) for name in np.atleast_1d(held["filterNames"])]
    values = values[:, None] if values.ndim == 1 else values
    if values.shape != (nodes_nm.size, len(names)):
        raise InputError(f"{values.shape} numbers for {nodes_nm.size} wavelengths and {len(names)} filters")
    # The first letter of a filter's name is its colour, as ISETCam draws it.
    letters = [name[:1].upper() for name in names]
    curves = _curves(nodes_nm, values, letters)
    return [CameraCurves(name=path.stem, curves=curves, per="photon", whole=False, source=f"ISETCam, {path.name}")]


def _table(path: Path) -> Sequence[CameraCurves]:
    names = columns(path)
    letters = ["Y"] if len(names) == 1 else [_letter(name) for _, name in names]
    if unknown := [name for (_, name), letter in zip(names, letters, strict=True) if not letter]:
        raise InputError(f"column {unknown[0]!r} names no channel; call it R, G, B, Gr, Gb, Y, or leave it out")
    points = [read_points(path, number) for number, _ in names]
    highest = max(max(values) for _, values in points)
    watts = any(_PER_WATT.search(name) for _, name in names)
    if highest > 1.0:
        raise InputError(f"it reaches {highest:g}, and a quantum efficiency is 1 at most; of per cent write % above it")
    curves = {
        letter: Curve(nodes_nm, values, outside="zero")
        for letter, (nodes_nm, values) in zip(letters, points, strict=True)
    }
    if len(curves) < len(letters):
        raise InputError(f"two columns are of one channel: {', '.join(letters)}")
    per: Literal["energy", "photon"] = "energy" if watts else "photon"
    return [CameraCurves(name=path.stem, curves=curves, per=per, absolute=True, whole=False, source=path.name)]


def _letter(name: str) -> str:
    """Return the channel that a column's name denotes; "" if none or ambiguous."""
    words = [word.lower() for word in _BETWEEN.split(_UNIT.sub(" ", name))]
    found = {_LETTERS[word] for word in words if word in _LETTERS}
    return found.pop() if len(found) == 1 else ""


def _curves(nodes_nm: F64, values: F64, letters: Sequence[str]) -> dict[str, Curve]:
    if len(set(letters)) < len(letters):
        raise InputError(f"two of its channels are called alike: {', '.join(letters)}")
    if not np.isfinite(values).all() or not np.isfinite(nodes_nm).all():
        raise InputError("it holds numbers that are none, or are infinite")
    if any(after <= before for before, after in pairwise(nodes_nm.tolist())):
        raise InputError("its wavelengths do not increase")
    return {
        # Measured sensitivities are slightly negative where the response is 0.
        letter: Curve(nodes_nm.tolist(), np.maximum(values[:, k], 0.0).tolist(), outside="zero")
        for k, letter in enumerate(letters)
    }


_READERS: Mapping[str, Callable[[Path], Sequence[CameraCurves]]] = {
    ".json": _rawtoaces,
    ".txt": _jiang,
    ".mat": _isetcam,
    ".csv": _table,
}
