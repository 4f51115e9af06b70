"""Groups of flats and darks, from a folder with an index or from a camera."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np

from camsim.camera.frame import Frame
from camsim.core.arrays import U8
from camsim.core.typed import FilePath, check
from camsim.core.words import percent
from camsim.errors import InputError, OutputError, UnsupportedError
from camsim.files import save
from camsim.files.atomic import made_together, write_whole
from camsim.files.exif import setting_noted
from camsim.files.reading import opened
from camsim.files.tiff_reader import read_directory
from camsim.measure.noise.estimate import SURE
from camsim.measure.noise.stack import Codes
from camsim.measure.picture import Picture
from camsim.measure.reading import read_picture

Kind: TypeAlias = Literal["flat", "dark", "clipped"]

INDEX = "index.csv"
HEADS = ("file", "kind", "exposure", "time_s")
_SUMMED = "summed"
_CONVERTERS_BYTES = 2
"""Largest width of a camera's converter: wider codes may be sums of frames."""
_MOST_FRAMES = 10_000
_NOMINAL = 1.2
"""Tolerance of stated times: cameras write 1/15 s for 1/16 and 30 s for 32."""
_PERIODS = {2: "second", 3: "third", 4: "fourth"}
_FILTERED = 0.05
"""Relative difference of lattices above which there are colour filters."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Group:
    """Frames taken alike.

    kind     : "flat"; "dark": without light; "clipped": every photosite is full
    exposure : light per photosite in any unit, the same for all; 0 for darks
    time_s   : exposure time
    codes    : (rows, cols) of each frame
    """

    kind: Kind
    exposure: float
    time_s: float
    codes: Sequence[Codes]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shots:
    """All that a measurement of noise needs.

    channel_index : (rows, cols) index into ``channels``
    summed        : number of frames summed into each; None if unknown
    """

    name: str
    channels: tuple[str, ...]
    channel_index: U8
    groups: tuple[Group, ...]
    summed: int | None = 1

    def of(self, kind: Kind) -> tuple[Group, ...]:
        """Return the groups of a kind, by increasing exposure and time."""
        found = [group for group in self.groups if group.kind == kind]
        return tuple(sorted(found, key=lambda group: (group.exposure, group.time_s)))


def read_shots(folder: str | Path, *, cfa: str | None = None) -> Shots:
    """Read a folder of raw frames whose ``index.csv`` says what each is: file, kind, exposure, time_s.

    cfa : the colour filter array of files that do not state it, such as RGGB; mono if there is none

    Raises InputError for missing or inconsistent files.
    """
    place = Path(check(folder, FilePath, "folder"))
    if not place.is_dir():
        raise InputError(f"{str(folder)!r} is no folder of flats and darks")
    rows = list(_index(place / INDEX))
    keys = dict.fromkeys((kind, exposure, time_s) for _, kind, exposure, time_s, _ in rows)
    numbers = {summed for *_, summed in rows}
    if len(numbers) > 1:
        raise InputError(f"{str(place / INDEX)!r} has frames of several numbers that were summed; give folders of each")
    found: dict[tuple[Kind, float, float], list[Codes]] = {key: [] for key in keys}
    first: tuple[tuple[str, ...], U8] | None = None
    settings: dict[float, str] = {}
    for name, kind, exposure, time_s, _ in rows:
        picture = read_picture(place / name, cfa=cfa, stored=True)
        channels, index, codes = codes_of(picture)
        iso, noted_s = setting_of(place / name, picture)
        if iso is not None:
            settings.setdefault(iso, name)
        if noted_s and not 1.0 / _NOMINAL < time_s / noted_s < _NOMINAL:
            raise InputError(
                f"{str(place / INDEX)!r} has {time_s:g} s for {name!r}, which says that it was exposed for "
                f"{noted_s:g} s; give seconds, or a file that notes none (.npy) of a sum of frames"
            )
        if first is None:
            first = channels, index
        if index.shape != first[1].shape or channels != first[0] or not np.array_equal(index, first[1]):
            raise InputError(
                f"{str(place / name)!r} has {index.shape[0]} × {index.shape[1]} photosites of {', '.join(channels)}, "
                f"others have {first[1].shape[0]} × {first[1].shape[1]} of {', '.join(first[0])}, or another array"
            )
        found[kind, exposure, time_s].append(codes)
    if len(settings) > 1:
        (one, its), (other, others), *_ = settings.items()
        raise InputError(
            f"{str(place / its)!r} was taken at ISO {one:g} and {others!r} at ISO {other:g}: one sensor at two gains; "
            "measure each setting from a separate folder"
        )
    assert first is not None
    wide = any(codes.itemsize > _CONVERTERS_BYTES for group in found.values() for codes in group)
    shots = Shots(
        summed=numbers.pop() or (None if wide else 1),
        name=str(folder),
        channels=first[0],
        channel_index=first[1],
        groups=tuple(Group(kind=k, exposure=e, time_s=t, codes=codes) for (k, e, t), codes in found.items()),
    )
    if cfa is None and len(shots.channels) == 1:
        refuse_filters(shots)
    return shots


def setting_of(path: Path, picture: Picture) -> tuple[float | None, float | None]:
    """Return the ISO setting and the exposure time, s, stated by a frame; None if not stated."""
    described = (picture.description or {}).get("exposure")
    if isinstance(described, Mapping):
        iso, time_s = (described.get(name) for name in ("iso", "time_s"))
        return _number(iso), _number(time_s)
    if picture.noted is not None:
        return picture.noted.iso, picture.noted.time_s
    if path.suffix.lower() not in (".dng", ".tif", ".tiff"):
        return None, None
    with opened(path) as (file, size):
        return setting_noted(read_directory(file, size))


def _number(said: object) -> float | None:
    return float(said) if isinstance(said, int | float) else None


def refuse_filters(shots: Shots) -> None:
    """Raise for frames with unstated colour filters: differences of channels would count as PRNU."""
    flats, darks = shots.of("flat"), shots.of("dark")
    if not flats or not darks:
        return  # reported by the measurement
    signal = np.mean(flats[len(flats) // 2].codes, axis=0) - np.mean(darks[0].codes, axis=0)
    for period, ordinal in _PERIODS.items():
        lattices = [signal[row::period, col::period] for row, col in np.ndindex(period, period)]
        if min(lattice.size for lattice in lattices) < 2:
            continue
        means = [float(lattice.mean()) for lattice in lattices]
        chance = max(float(lattice.std()) / math.sqrt(lattice.size) for lattice in lattices)
        apart = max(means) - min(means)
        if apart > _FILTERED * abs(float(np.mean(means))) + 2.0 * SURE * chance:
            raise InputError(
                f"{shots.name!r} has flats in which every {ordinal} photosite is another by up to "
                f"{percent(apart / max(means))}, as behind colour filters, and the files name none; give the array: "
                "--cfa RGGB, in Python cfa='RGGB' (or x-trans …; mono if there is none)"
            )


def write_shots(folder: str | Path, frames: Mapping[tuple[Kind, float, float], Sequence[Frame]]) -> None:
    """Write frames and their index: as DNG, or as TIFF if raw programs cannot read DNGs of the filter array."""
    from camsim.files.dng_tags import odd_cfa

    place = Path(check(folder, FilePath, "folder"))
    check(frames, Mapping, "frames")
    try:
        place.mkdir(parents=True, exist_ok=True)
        if any(place.iterdir()):
            raise OutputError(f"{str(folder)!r} is not empty; name another folder")
    except OSError as error:
        raise OutputError(f"cannot write into {str(folder)!r}: {error.strerror}") from error
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADS)
    with made_together(place):
        for number, ((kind, exposure, time_s), group) in enumerate(frames.items()):
            for k, frame in enumerate(group):
                suffix = ".tiff" if odd_cfa(frame.cfa_pattern) else ".dng"
                name = f"{number:03d}-{kind}-{k:02d}{suffix}"
                save(frame, place / name, product="mosaic")
                writer.writerow((name, kind, repr(exposure), repr(time_s)))
        write_whole(place / INDEX, text.getvalue().encode())


def _index(path: Path) -> Iterator[tuple[str, Kind, float, float, int]]:
    """Yield file, kind, exposure, time and the number of summed frames (0: not stated) of every line."""
    if not path.is_file():
        raise InputError(
            f"{str(path)!r} is missing; it says what each frame is, in the columns {', '.join(HEADS)} "
            "(kind: flat, dark or clipped; exposure: light in any unit, 0 of darks)"
        )
    lines = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8", errors="replace"))))
    if not lines or set(HEADS) - set(lines[0]):
        raise InputError(f"{str(path)!r} needs the columns {', '.join(HEADS)}")
    if len(lines) > _MOST_FRAMES:
        raise InputError(f"{str(path)!r} names {len(lines)} frames; {_MOST_FRAMES} are the most")
    kinds: dict[str, Kind] = {kind: kind for kind in get_args(Kind)}
    named: dict[Path, int] = {}
    for number, line in enumerate(lines, start=2):
        place = f"{str(path)!r}, line {number}"
        kind = kinds.get((line["kind"] or "").strip())
        if kind is None:
            raise InputError(f"{place}: {line['kind']!r} is no kind; give {', '.join(kinds)}")
        try:
            exposure, time_s = float(line["exposure"]), float(line["time_s"])
        except (TypeError, ValueError):
            raise InputError(f"{place}: exposure and time_s must be numbers") from None
        if not (math.isfinite(exposure) and exposure >= 0.0 and math.isfinite(time_s) and time_s > 0.0):
            raise InputError(f"{place}: exposure must be 0 or more, and time_s above 0")
        name = (line["file"] or "").strip()
        if not name or Path(name).is_absolute() or ".." in Path(name).parts:
            raise InputError(f"{place}: {name!r} must be a file in this folder")
        if (first := named.setdefault(Path(name), number)) < number:
            raise InputError(f"{place}: {name!r} is named in line {first} already, and is one frame; name each once")
        said = (line.get(_SUMMED) or "0").strip()
        if not said.isdecimal():
            raise InputError(f"{place}: {_SUMMED} must be how many frames were added up, 1 or more")
        yield name, kind, exposure, time_s, int(said)


def codes_of(picture: Picture) -> tuple[tuple[str, ...], U8, Codes]:
    """Return the channels of a mosaic, the index (rows, cols) of each photosite's channel, and the codes."""
    channels = tuple(dict.fromkeys(plane.name for plane in picture.planes))
    # In the width of the file: programs that sum frames write 32 bits.
    wide = np.result_type(*(plane.samples.dtype for plane in picture.planes))
    if wide.kind == "f":  # whole numbers, as MATLAB keeps codes
        low, high = (np.array([limit(plane.samples) for plane in picture.planes]) for limit in (np.min, np.max))
        whole = all((plane.samples == np.rint(plane.samples)).all() for plane in picture.planes)
        if not whole or not np.abs([low, high]).max() < 2**31:
            message = "holds no codes but fractions, and noise is measured in the converter's codes; save those"
            raise UnsupportedError(message, stage=picture.name)
        wide = np.dtype(np.uint16 if low.min() >= 0 and high.max() < 2**16 else np.int32)
    index, codes = np.zeros(picture.shape, np.uint8), np.zeros(picture.shape, wide)
    covered = 0
    for plane in picture.planes:
        where = slice(plane.first[0], None, plane.step[0]), slice(plane.first[1], None, plane.step[1])
        index[where], codes[where] = channels.index(plane.name), plane.samples
        covered += plane.samples.size
    if covered != index.size:
        raise UnsupportedError("is no mosaic: each photosite has one code", stage=picture.name)
    return channels, index, codes
