"""Sensor files with other colours: the text of a file with some keys replaced and the rest unchanged."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camsim.api import load_camera
from camsim.camera.camera import Camera
from camsim.config.sensor_search import SensorSearch
from camsim.core.arrays import distinct
from camsim.errors import InvalidValueError
from camsim.files.atomic import replacing
from camsim.optics.no_lens import NO_LENS
from camsim.sensor.measured_matrix import MeasuredMatrix
from camsim.spectra.curve import Curve

_KEY = re.compile(r"([A-Za-z_]\w*)\s*:")
_FILE = re.compile(r"\bcsv\s*:")
_TYPICAL_PEAK = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    """A sensor whose colours are replaced.

    text, folder : the text of its file, and the folder that holds it
    camera       : the camera of the file; None for a skeleton
    """

    text: str
    folder: Path | None = None
    camera: Camera | None = None

    @classmethod
    def of(cls, name: str, sensors: Iterable[str] = ()) -> Base:
        """Return the base that is found by a sensor's name or path."""
        camera = load_camera(name, lens=NO_LENS, sensors=sensors)
        path = SensorSearch.of(sensors, Path()).locate_path_or_name(name).path
        return cls(text=path.read_text("utf-8"), folder=path.resolve().parent, camera=camera)

    @property
    def peak(self) -> float:
        """Electrons per photon at the maximum of the curves."""
        if self.camera is None:
            return _TYPICAL_PEAK
        efficiency = self.camera.quantum_efficiency
        nodes = distinct(np.concatenate([curve.wavelength_nm for _, curve in efficiency.curves]))
        return float(f"{efficiency.at(nodes).max():.4g}")

    @property
    def matrices(self) -> tuple[MeasuredMatrix, ...]:
        """The measured colour matrices of the sensor; none for a skeleton."""
        return () if self.camera is None else tuple(self.camera.colour_matrices)


def written(path: str, base: Base, parts: Mapping[str, str]) -> Camera:
    """Write a sensor file and return its camera; written only if camsim accepts it.

    parts : text of each key to replace or add; "" removes a key
    """
    text = exchanged(base.text, parts)
    if base.folder is not None and Path(path).resolve().parent != base.folder and _FILE.search(text):
        message = f"the sensor names CSV files beside it; write into its folder, {str(base.folder)!r}"
        raise InvalidValueError(message, key="--output")
    with replacing(Path(path)) as temporary:
        temporary.write_text(text, "utf-8")
        return load_camera(temporary, lens=NO_LENS)


def exchanged(text: str, parts: Mapping[str, str]) -> str:
    """Return a file's text with some keys replaced; missing ones are added after ``cfa``.

    >>> text = "camsim: sensor/1\\ncfa: {kind: mono}\\nfilters: [0.5]\\n"
    >>> print(exchanged(text, {"filters": "", "name": "name: A"}).strip())
    camsim: sensor/1
    cfa: {kind: mono}
    name: A
    """
    blocks: list[tuple[str, list[str]]] = []
    for line in text.splitlines():
        begins = _KEY.match(line)
        if begins:
            blocks.append((begins[1], [line]))
        elif blocks and (line[:1] in (" ", "\t", "-", "}", "]") and line.strip()):
            blocks[-1][1].append(line)
        else:
            blocks.append(("", [line]))
    there = {key for key, _ in blocks}
    out: list[str] = []
    for key, lines in blocks:
        if key not in parts:
            out += lines
        elif parts[key]:
            out.append(parts[key].rstrip("\n"))
        if key == "cfa":
            out += [part.rstrip("\n") for name, part in parts.items() if part and name not in there]
    return "\n".join(out) + "\n"


def efficiency_text(
    curves: Mapping[str, Curve], *, per: str, peak: float | None, source: str, comment: Sequence[str] = ()
) -> str:
    """Return the text of ``quantum_efficiency``, a table for each channel; peak None: the curves are absolute."""
    lines = ["quantum_efficiency:", *_remarks(comment), "  curves:"]
    for letter, curve in curves.items():
        lines.append(f"    {letter}:")
        lines.append(f"      wavelength_nm: [{_numbers(curve.wavelength_nm)}]")
        lines.append(f"      values: [{_numbers(curve.values, 4)}]")
        lines.append("      outside: zero")
    lines += [f"  per: {per}", f"  peak: {'as given' if peak is None else f'{peak:g}'}", f"  source: {_quoted(source)}"]
    return "\n".join(lines)


def matrices_text(matrices: Sequence[MeasuredMatrix], comments: Mapping[str, Sequence[str]]) -> str:
    """Return the text of ``colour_matrices``; comments: lines for the matrix of each light."""
    lines = ["colour_matrices:"]
    for matrix in matrices:
        rows = ", ".join(f"[{_numbers(row)}]" for row in matrix.camera_to_xyz)
        red, green, blue = matrix.neutral.tolist()
        lines += _remarks(comments.get(matrix.light, ()))
        lines += [
            f"  - light: {_quoted(matrix.light)}",
            f"    white_xyz: [{_numbers(matrix.white_xyz)}]",
            f"    camera_to_xyz: [{rows}]     # white: R/G {red / green:.4f}, B/G {blue / green:.4f}",
        ]
    return "\n".join(lines)


def skeleton(
    *, name: str, rows: int, cols: int, pitch_um: float | None, pattern: Sequence[str], black: float, white: float,
    iso: float | None,
) -> str:  # fmt: skip
    """Return a sensor file from a raw file's metadata; other values are typical, and marked so."""
    typical = "typical, not measured"
    pitch = 4.0 if pitch_um is None else pitch_um
    full_e = float(f"{min(2000.0 * pitch**2, 60_000.0):.2g}")
    bits = max(8, math.ceil(math.log2(white + 1.0)))
    return "\n".join(
        [
            "camsim: sensor/1",
            f"name: {_quoted(name)}",
            f"frame: {{rows: {rows}, cols: {cols}, pitch_um: {pitch:g}}}"
            + (f"     # the raw file's; pitch {typical}: say it by --pitch" if pitch_um is None else ""),
            _cfa_text(pattern),
            f"charge: {{full_well_e: {full_e:g}}}     # {typical}: camsim calibrate noise measures it",
            f"readout: {{bit_depth: {bits}, black_level_dn: {round(black)}, base_iso: {iso or 100:g}, "
            f"electrons_per_dn: {full_e / (0.98 * (white - black)):.4g}, read_noise_e: 3}}"
            f"     # codes: the raw file's; electrons {typical}",
            "",
        ]
    )


def _cfa_text(pattern: Sequence[str]) -> str:
    flat = "".join(pattern)
    if len(pattern) == 2 and flat in ("RGGB", "BGGR", "GRBG", "GBRG"):
        return f"cfa: {{kind: bayer, pattern: {flat}}}"
    return f"cfa: {{kind: letters, pattern: [{', '.join(pattern)}]}}"


def _remarks(texts: Sequence[str]) -> list[str]:
    return [
        line for text in texts for line in textwrap.wrap(text, 118, initial_indent="  # ", subsequent_indent="  # ")
    ]


def _numbers(values: Iterable[float], digits: int = 6) -> str:
    return ", ".join(f"{value:.{digits}g}" for value in values)


def _quoted(text: str) -> str:
    return '"' + re.sub(r"[^\x20-\x7e\xa0-\ud7ff]", "?", text).replace("\\", "\\\\").replace('"', '\\"') + '"'
