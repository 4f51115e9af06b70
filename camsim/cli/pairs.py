"""``camsim capture --pairs``: clean and noisy mosaics with their truth, in every phase, to test demosaicing on."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camsim.camera.capture import Capture, Progress
from camsim.camera.frame import Frame
from camsim.camera.optical_image import OpticalImage
from camsim.camera.window import Region
from camsim.cli.pairs_readme import readme
from camsim.core.typed import LARGEST_SEED, LONGEST_S, SHORTEST_S
from camsim.errors import CamsimError, InvalidValueError, OutputError
from camsim.files import save
from camsim.files.atomic import replacing, write_chunks
from camsim.files.describe import record
from camsim.files.dng_tags import odd_cfa
from camsim.sensor.cfa import Cfa
from camsim.sensor.colour_matrix import as_shot_neutral
from camsim.study.work import Shared

USUAL_LEVELS = (1.0, 0.25, 0.0625)
"""Light relative to the scene's exposure: unchanged, and two and four stops less."""

_MOST_LETTERS = 16
_PHASES = ("RGGB", "GRBG", "GBRG", "BGGR")
_OFFSETS = ((0, 1), (1, 0), (1, 1))


@dataclass(frozen=True, slots=True)
class _Variant:
    """One placement of the colour filters over the scene.

    name : the phase in letters, such as GRBG, and the shift of the window, if any
    """

    name: str
    capture: Capture
    origin: tuple[int, int]


@dataclass(frozen=True, slots=True)
class Pair:
    """A pair to take with noise and without it: one variant of the filter array at one level of light."""

    variant: _Variant
    level: float
    noisy: Capture


def parse_levels(text: str | None) -> tuple[float, ...]:
    """Return the levels of ``1,0.25``.

    >>> parse_levels("1, 0.5"), parse_levels(None)
    ((1.0, 0.5), (1.0, 0.25, 0.0625))
    """
    if text is None:
        return USUAL_LEVELS
    try:
        levels = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise InvalidValueError(f"{text!r}; give numbers such as 1,0.25,0.0625", key="--levels") from None
    if not all(0.0 < level < float("inf") for level in levels) or len(set(levels)) < len(levels):
        raise InvalidValueError(f"{text!r}; give different numbers above 0, such as 1,0.25,0.0625", key="--levels")
    return levels


def check_folder(path: str, *, force: bool) -> Path:
    """Make the folder; raises OutputError if the path is no folder, or if the folder is not empty."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()) and not force:
            raise OutputError(f"{path!r} is not empty; overwrite with --force, or name another folder")
    except OSError as error:
        raise OutputError(f"cannot write into {path!r}: {error.strerror}") from error
    return folder


def plan_pairs(capture: Capture, levels: Sequence[float]) -> list[Pair]:
    """Return all pairs; raises InvalidValueError in advance if one of them cannot be taken."""
    wanted = [(variant, level) for variant in _variants(capture) for level in levels]
    if capture.seed + len(wanted) - 1 > LARGEST_SEED:
        message = (
            f"each of {len(wanted)} pairs has a different seed, from {capture.seed} on, and 2^63 − 1 is the largest"
        )
        raise InvalidValueError(f"{message}; begin at a smaller one", key="--pairs")
    return [
        Pair(variant, level, _at_level(variant.capture, level, seed=capture.seed + number))
        for number, (variant, level) in enumerate(wanted)
    ]


def _at_level(capture: Capture, level: float, *, seed: int) -> Capture:
    time_s = capture.time_s * level
    if not SHORTEST_S <= time_s <= LONGEST_S:
        message = f"{level:g} of {capture.time_s:g} s is {time_s:g} s, outside {SHORTEST_S:g} … {LONGEST_S:g}"
        raise InvalidValueError(f"{message}; give another level, or another exposure.time_s", key="--levels")
    exposure = dataclasses.replace(capture.exposure, time_s=time_s)
    return dataclasses.replace(capture, exposure=exposure, noise=True, seed=seed)


def write_pairs(
    capture: Capture, pairs: Sequence[Pair], folder: Path, *, compress: bool, quiet: bool, progress: Progress
) -> None:
    """Write noisy and clean mosaics (.dng) and the truth (.exr) of every pair, an index and a page."""
    rows: list[dict[str, Any]] = []
    shared = Shared()  # shared by all levels of a variant, unless points of light depend on the level
    for pair in pairs:
        progress("pairs", len(rows) / len(pairs))
        seen = shared.of(pair.noisy, frozenset({"mosaic", "truth"}))
        rows.append(_write_pair(pair, seen, folder, number=len(rows), compress=compress))
        if not quiet:
            print(f"{rows[-1]['noisy']}, {rows[-1]['clean']}, {rows[-1]['truth']}", file=sys.stderr)
    table = io.StringIO(newline="")
    writer = csv.DictWriter(table, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    texts = {
        "index.csv": table.getvalue(),
        "index.json": json.dumps(rows, indent=1) + "\n",
        "README.md": readme(capture, rows[0]),
    }
    for name, text in texts.items():
        with replacing(folder / name) as temporary:
            write_chunks(temporary, (text.encode(),))


def _variants(capture: Capture) -> Iterator[_Variant]:
    """Yield the four phases over the same window, then the sensor's array from windows shifted by one."""
    camera = capture.camera
    period = camera.cfa.period
    region = capture.region or Region(rows=camera.rows - 1, cols=camera.cols - 1, origin=(0, 0))
    row, col = region.origin or tuple(
        (whole - size) // 2 // step * step
        for whole, size, step in zip((camera.rows, camera.cols), (region.rows, region.cols), period, strict=True)
    )
    # Room for the shift by one.
    size = min(region.rows, camera.rows - row - 1), min(region.cols, camera.cols - col - 1)
    if min(size) < 1:
        raise InvalidValueError(
            "the window fills the frame; make the region smaller by one row and column", key="--pairs"
        )

    def windowed(cfa: Cfa, origin: tuple[int, int]) -> Capture:
        window = Region(rows=size[0], cols=size[1], origin=origin)
        return dataclasses.replace(capture, camera=camera.replace(cfa=cfa), region=window)

    if "".join(camera.cfa.pattern) in _PHASES and period == (2, 2):
        arrays = tuple(Cfa.bayer(phase) for phase in _PHASES)
    else:
        arrays = (camera.cfa,)
    for cfa in arrays:  # named after its phase in the window
        yield _Variant(_letters(cfa, (row, col)), windowed(cfa, (row, col)), (row, col))
    for down, right in _OFFSETS:
        origin = row + down, col + right
        shift = "-".join(("from", *(("row1",) if down else ()), *(("col1",) if right else ())))
        yield _Variant(f"{_letters(camera.cfa, origin)}-{shift}", windowed(camera.cfa, origin), origin)


def _letters(cfa: Cfa, origin: tuple[int, int]) -> str:
    """Return the filters from an origin, row by row as GRBG; for an array with a long period its size, as cfa-6x6."""
    rows = cfa.window_pattern(origin)
    letters = "".join(rows)
    return letters if len(letters) <= _MOST_LETTERS else f"cfa-{len(rows)}x{len(rows[0])}"


def _write_pair(pair: Pair, seen: OpticalImage, folder: Path, *, number: int, compress: bool) -> dict[str, Any]:
    noisy = pair.noisy
    frame = next(noisy.frames(optical_image=seen))
    stem = f"{number:03d}-{pair.variant.name}-x{pair.level:g}"
    clean = next(dataclasses.replace(noisy, noise=False).frames(products=("mosaic", "truth"), optical_image=seen))
    # Arrays that raw developers misread are written as plain TIFF.
    suffix = ".tiff" if odd_cfa(frame.cfa_pattern) else ".dng"
    names = {"noisy": f"{stem}-noisy{suffix}", "clean": f"{stem}-clean{suffix}", "truth": f"{stem}-truth.exr"}
    save(frame, folder / names["noisy"], force=True, compress=compress)
    save(clean, folder / names["clean"], force=True, compress=compress)
    save(clean, folder / names["truth"], product="truth", force=True)
    return {**names, **_figures(pair, frame)}


def _figures(pair: Pair, frame: Frame) -> dict[str, Any]:
    said = record(frame, "mosaic")
    return {
        "cfa": "/".join(frame.cfa_pattern),
        "origin_row": pair.variant.origin[0],
        "origin_col": pair.variant.origin[1],
        "rows": frame.shape[0],
        "cols": frame.shape[1],
        "level": pair.level,
        "time_s": frame.time_s,
        "iso": frame.iso,
        "seed": frame.seed,
        "black_level_dn": frame.black_level_dn,
        "black_offsets_dn": [list(row) for row in frame.black_offsets_dn],
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": frame.electrons_per_dn,
        "clips_at_e": frame.clips_at_e,
        **_neutral(frame),
        "description_sha256": said["description_sha256"],
    }


def _neutral(frame: Frame) -> dict[str, float]:
    """Return the white balance: responses to a perfect diffuser, the largest 1."""
    try:
        neutral = as_shot_neutral(frame.colour)
    except CamsimError:
        return {}
    return {f"neutral_{name}": round(float(value), 9) for name, value in zip(frame.channels, neutral, strict=True)}
