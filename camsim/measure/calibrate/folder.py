"""A folder of raw files: classification into flats and darks, and the settings of each."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np

from camsim.core.arrays import U8
from camsim.core.typed import FilePath, check
from camsim.errors import InputError
from camsim.measure.noise.shots import INDEX, Kind, codes_of, setting_of
from camsim.measure.noise.stack import Codes
from camsim.measure.picture import Picture
from camsim.measure.reading import RAW, read_picture

COLUMNS = ("file", "kind", "iso", "time_s", "exposure", "temperature_c", "read_out")
"""Columns of an index; only ``file`` is required."""

MOST_BYTES = 1 << 30
"""Most bytes of codes held at once: the window is smaller for many frames."""

_MOST_FRAMES = 10_000
_WORDS: dict[Kind, tuple[str, ...]] = {
    "dark": ("dark", "bias", "black", "offset"),
    "clipped": ("clipped", "saturated", "overexposed"),
    "flat": ("flat", "light", "grey", "gray"),
}
_READ_OUTS = {"low": r"(?<![a-z])(lcg|low[-_ ]?gain)", "high": r"(?<![a-z])(hcg|high[-_ ]?gain)"}
_ALIKE = 1.05
"""Ratio of means below which flats of one time count as taken in the same light."""
_UNLIT = 0.01
"""Fraction of the brightest frame's signal below which a frame is a dark."""
_CALLED_ISO = 100.0
_CONTENT = "content"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shot:
    """A frame and its settings.

    kind, told_by : kind of the frame, and what it was known by: index, folder, name, or content
    iso           : the setting; iso_said: whether it is stated
    exposure      : light in any unit, the same for all: from the index, or the mean of similar frames
    read_out      : "low" or "high": the gain of this image; "" if not stated
    codes         : codes of the window
    """

    file: str
    kind: Kind
    stated_by: str
    iso: float
    iso_stated: bool
    time_s: float | None
    exposure: float
    temperature_c: float | None
    read_out: str
    camera: str
    mean_dn: float
    codes: Codes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShotsOfCamera:
    """All frames of a folder.

    pattern       : rows of filter letters;  channels, channel_index: as measured, (rows, cols) of the window
    rows, cols    : size of the whole frame;  origin: (row, col) of the window in it
    white_dn, pitch_um : as stated in the files, if at all
    linear_dn     : data numbers of companded codes; empty: not companded
    exposures_said : whether the index states the light of every flat
    filters_said  : whether ``pattern`` is stated by the files or the user
    """

    name: str
    shots: tuple[Shot, ...]
    pattern: tuple[str, ...]
    channels: tuple[str, ...]
    channel_index: U8
    rows: int
    cols: int
    origin: tuple[int, int]
    white_dn: float | None
    pitch_um: float | None
    linear_dn: tuple[int, ...]
    filters_stated: bool
    exposures_stated: bool

    @property
    def period(self) -> tuple[int, int]:
        """Period of the filter array."""
        return len(self.pattern), len(self.pattern[0])

    @property
    def read_outs(self) -> tuple[ShotsOfCamera, ...]:
        """The low-gain and the high-gain images apart, if some ISO setting has both; else all shots together."""
        low, high = ([shot for shot in self.shots if shot.read_out == gain] for gain in _READ_OUTS)
        if not {shot.iso for shot in low} & {shot.iso for shot in high}:
            return (self,)
        if len(low) + len(high) < len(self.shots):
            name = next(shot.file for shot in self.shots if not shot.read_out)
            message = f"{self.name!r} has images of both gains, and {name!r} does not say of which it is; give it in "
            raise InputError(message + "index.csv, column read_out: low or high")
        return replace(self, shots=tuple(low)), replace(self, shots=tuple(high))


def read_folder(folder: str | Path, *, cfa: str | None = None, side: int = 1024) -> ShotsOfCamera:
    """Read a window of ``side`` squared photosites from the middle of every raw file of a folder, frame by frame.

    cfa : the colour filter array of files that do not state it, such as RGGB

    Kinds come from an ``index.csv`` (columns file, kind, iso, time_s, exposure, temperature_c; only ``file`` is
    required), from the names of sub-folders and files, or from the frames: brighter ones are flats.
    ISO and time come from the index, or from the files. Raises InputError in one sentence.
    """
    place = Path(check(folder, FilePath, "folder"))
    if not place.is_dir():
        raise InputError(f"{str(folder)!r} is no folder of flats and darks")
    lines = list(_listed(place))
    if not lines:
        raise InputError(f"{str(folder)!r} holds no raw file that can be read ({', '.join(RAW)})")
    if len(lines) > _MOST_FRAMES:
        raise InputError(f"{str(folder)!r} holds {len(lines)} frames; {_MOST_FRAMES} are the most")
    side = min(side, int(math.sqrt(MOST_BYTES / (2 * len(lines)))))
    shots: list[Shot] = []
    first: tuple[Picture, tuple[str, ...], U8, tuple[slice, slice]] | None = None
    for line in lines:
        path = place / line["file"]
        picture = read_picture(path, cfa=cfa, stored=True)
        channels, index, codes = codes_of(picture)
        if first is None:
            window = _window(codes.shape, _period(picture), side)
            first = picture, channels, index[window].copy(), window
        elif codes.shape != first[0].shape or channels != first[1]:
            was = first[0]
            raise InputError(
                f"{str(path)!r} has {codes.shape[0]} × {codes.shape[1]} photosites of {', '.join(channels)}, and "
                f"{shots[0].file!r} {was.shape[0]} × {was.shape[1]} of {', '.join(first[1])}: frames of two cameras; "
                "give a folder of one"
            )
        shots.append(_shot(line, path, picture, codes[first[3]].copy()))
    assert first is not None
    if len(cameras := {shot.camera for shot in shots if shot.camera}) > 1:
        raise InputError(
            f"{str(folder)!r} has frames of {' and of '.join(sorted(cameras))}; give a folder of one camera"
        )
    picture, channels, window_index, window = first
    return ShotsOfCamera(
        name=str(folder),
        shots=tuple(_clusters(list(_kinds(shots)))),
        pattern=_pattern(picture),
        channels=channels,
        channel_index=window_index,
        rows=picture.shape[0],
        cols=picture.shape[1],
        origin=(window[0].start, window[1].start),
        white_dn=picture.planes[0].white if _says_white(picture, shots[0].file) else None,
        pitch_um=picture.pitch_um,
        linear_dn=picture.noted.linear_dn if picture.noted is not None else (),
        exposures_stated=not any(math.isnan(shot.exposure) for shot in shots if shot.kind != "dark"),
        filters_stated=cfa is not None or _says_white(picture, shots[0].file),
    )


def _listed(place: Path) -> Iterator[dict[str, str]]:
    """Yield a record of every file: the lines of the index, or the files of the folder."""
    index = place / INDEX
    if not index.is_file():
        for path in sorted(place.rglob("*")):
            if path.is_file() and path.suffix.lower() in RAW and not path.name.startswith("."):
                yield {"file": path.relative_to(place).as_posix()}
        return
    lines = list(csv.DictReader(io.StringIO(index.read_text(encoding="utf-8", errors="replace"))))
    heads = set(lines[0]) if lines else set()
    if "file" not in heads:
        raise InputError(f"{str(index)!r} needs a column file; {', '.join(COLUMNS[1:])} may be there too")
    seen: set[str] = set()
    for number, line in enumerate(lines, start=2):
        where = f"{str(index)!r}, line {number}"
        stated = {key: (line.get(key) or "").strip() for key in COLUMNS}
        name = stated["file"]
        if not name or Path(name).is_absolute() or ".." in Path(name).parts:
            raise InputError(f"{where}: {name!r} must be a file in this folder")
        if name in seen:
            raise InputError(f"{where}: {name!r} is named before, and is one frame; name each once")
        seen.add(name)
        if stated["kind"] and stated["kind"] not in get_args(Kind):
            raise InputError(f"{where}: {stated['kind']!r} is no kind; give {', '.join(get_args(Kind))}")
        if stated["read_out"] and stated["read_out"] not in _READ_OUTS:
            raise InputError(f"{where}: {stated['read_out']!r} is no read_out; give {' or '.join(_READ_OUTS)}")
        for key in ("iso", "time_s", "exposure", "temperature_c"):
            least = {"iso": 1e-3, "time_s": 1e-9, "exposure": 0.0, "temperature_c": -273.15}[key]
            if stated[key] and not (_is_number(stated[key]) and float(stated[key]) >= least):
                raise InputError(f"{where}: {key} must be a number of {least:g} or more, not {stated[key]!r}")
        yield {key: value for key, value in stated.items() if value}


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _shot(line: dict[str, str], path: Path, picture: Picture, codes: Codes) -> Shot:
    """Return a frame; if unknown, its kind is that of a flat and its exposure NaN."""
    kind, stated_by = _kind_of(line)
    iso, time_s = setting_of(path, picture)

    def number(key: str, otherwise: float | None = None) -> float | None:
        return float(line[key]) if key in line else otherwise

    iso = number("iso", iso)
    exposure = (picture.description or {}).get("exposure")
    temperature = exposure.get("temperature_c") if isinstance(exposure, dict) else None
    return Shot(
        file=line["file"],
        kind=kind,
        stated_by=stated_by,
        iso=_CALLED_ISO if iso is None else iso,
        iso_stated=iso is not None,
        time_s=number("time_s", time_s),
        exposure=float(line.get("exposure", "nan")),
        temperature_c=number("temperature_c", temperature),
        read_out=line.get("read_out") or _read_out(line["file"], picture),
        camera=picture.noted.camera if picture.noted is not None else "",
        mean_dn=float(codes.mean(dtype=np.float64)),
        codes=codes,
    )


def _kind_of(line: dict[str, str]) -> tuple[Kind, str]:
    kinds: dict[str, Kind] = {kind: kind for kind in get_args(Kind)}
    if "kind" in line:
        return kinds[line["kind"]], "index"
    *folders, name = Path(line["file"]).parts
    for stated_by, texts in (("folder", reversed(folders)), ("name", [name])):
        for text in texts:
            for kind, words in _WORDS.items():
                if any(re.search(rf"(?<![a-z]){word}", text.lower()) for word in words):
                    return kind, stated_by
    return "flat", _CONTENT


def _read_out(file: str, picture: Picture) -> str:
    """Return the gain of an image by our record, or by words in the names of file and folders; "" if none says."""
    camera = (picture.description or {}).get("camera")
    dual = camera.get("dual_gain") if isinstance(camera, dict) else None
    if isinstance(dual, dict) and dual.get("read") in _READ_OUTS:
        return str(dual["read"])
    return next((gain for gain, words in _READ_OUTS.items() if re.search(words, file.lower())), "")


def _kinds(shots: Sequence[Shot]) -> Iterator[Shot]:
    """Yield the shots with kinds from their codes where not stated."""
    least = min(shot.mean_dn for shot in shots)
    most = max(shot.mean_dn for shot in shots)
    for shot in shots:
        dark = shot.mean_dn - least < max(_UNLIT * (most - least), 1.0)
        yield replace(shot, kind="dark") if shot.stated_by == _CONTENT and dark else shot


def _clusters(shots: Sequence[Shot]) -> Iterator[Shot]:
    """Yield the shots with an exposure: that of the index, or the mean of similar frames of one setting."""
    least: dict[tuple[float, str], float] = {}
    for shot in shots:
        key = shot.iso, shot.read_out
        least[key] = min(least.get(key, math.inf), shot.mean_dn)
    level, before = 0.0, None
    for shot in sorted(shots, key=lambda each: (each.iso, each.read_out, each.time_s or 0.0, each.mean_dn)):
        if shot.kind == "dark" or not math.isnan(shot.exposure):
            yield replace(shot, exposure=0.0) if shot.kind == "dark" else shot
            continue
        signal, setting = (
            max(shot.mean_dn - least[shot.iso, shot.read_out], 0.0),
            (shot.iso, shot.read_out, shot.time_s),
        )
        if before != setting or signal > _ALIKE * level:
            level, before = signal, setting
        yield replace(shot, exposure=level)


def _period(picture: Picture) -> tuple[int, int]:
    return max(plane.step[0] for plane in picture.planes), max(plane.step[1] for plane in picture.planes)


def _says_white(picture: Picture, file: str) -> bool:
    """Whether the white level is the camera's, and not just the largest number of the file's type."""
    return picture.noted is not None or picture.description is not None or file.lower().endswith(".dng")


def _pattern(picture: Picture) -> tuple[str, ...]:
    """Return rows of filter letters of the smallest tile."""
    rows, cols = _period(picture)
    letters = [["Y"] * cols for _ in range(rows)]
    for plane in picture.planes:
        for row in range(plane.first[0], rows, plane.step[0]):
            for col in range(plane.first[1], cols, plane.step[1]):
                letters[row][col] = plane.name[0]
    whole = ["".join(row) for row in letters]
    down = next(n for n in range(1, rows + 1) if whole == (whole[:n] * rows)[:rows])
    across = next(n for n in range(1, cols + 1) if all(row == (row[:n] * cols)[:cols] for row in whole))
    return tuple(row[:across] for row in whole[:down])


def _window(shape: tuple[int, ...], period: tuple[int, int], side: int) -> tuple[slice, slice]:
    """Return the middle of a frame, in whole periods."""
    found = []
    for size, step in zip(shape, period, strict=True):
        length = max(min(side, size) // step, 1) * step
        first = (size - length) // 2 // step * step
        found.append(slice(first, first + length))
    return found[0], found[1]
