"""Forecast of the cost of a study or a data set, and of what exists already."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

from camsim.api import Exposed
from camsim.camera.frame import Product
from camsim.camera.shot import Shot
from camsim.core import memory
from camsim.rendering.running import to_nobody
from camsim.study.captures import Progress, captures_of
from camsim.study.dataset import shards_of
from camsim.study.manifest import Journal
from camsim.study.samples import products_of
from camsim.study.study import StudyOrFile, read_dataset, read_study
from camsim.study.sweep import items_of

_SAMPLED = 24
_PHOTOSITE_S = 3e-7
"""Seconds of one core for a photosite's noise, code and share of a file."""

_CAPTURE_S = 0.01
"""Fixed seconds of a capture: reading and validation, setup of noise and files."""

_TRUTH = 2.5
"""Cost of rendering all channels relative to the mosaic."""

_BYTES = {".dng": 2, ".tiff": 2, ".tif": 2, ".npy": 8, ".exr": 12, ".png": 2, ".npz": 24}
_PART_BYTES = {"noisy": 2, "clean": 4, "truth": 4}


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """The work to do: captures, files (samples of a data set), distinct optical images, disk.

    found        : captures that exist already, not counted in the others
    seconds      : time on one idle core, without measurements and the start of workers (a few seconds each)
    memory_bytes : memory of a worker during its largest capture, including the program
    """

    captures: int
    found: int
    files: int
    optical_images: int
    seconds: float
    disk_bytes: float
    memory_bytes: float


def forecast(
    study: StudyOrFile, progress: Progress | None = None, *, folder: str | os.PathLike[str] | None = None
) -> Forecast:
    """Return the forecast of a sweep; ``folder``: with existing results."""
    items = items_of(*read_study(study), progress or to_nobody)
    there = Journal(Path(folder)).finished({item.identity for item in items}) if folder is not None else {}
    left = [item for item in items if item.identity not in there]
    disk = sum(
        item.capture.grid.rows * item.capture.grid.cols * _BYTES.get(Path(name).suffix.lower(), 8)
        for item in left
        for names in item.files
        for name, _ in names
    )
    products = {product for files in items[0].files for _, product in files}
    return _forecast(
        [item.capture for item in left],
        tuple(products),
        found=len(items) - len(left),
        files=sum(len(names) for item in left for names in item.files),
        frames=len(items[0].files),
        disk_bytes=disk,
    )


def forecast_dataset(
    dataset: StudyOrFile, progress: Progress | None = None, *, folder: str | os.PathLike[str] | None = None
) -> Forecast:
    """Return the forecast of a data set; ``folder``: with existing shards."""
    read = read_dataset(dataset)
    products = products_of(tuple(read.model.hold))
    shards = shards_of(read, captures_of(read, products, progress or to_nobody))
    there = Journal(Path(folder)).finished({shard.identity for shard in shards}) if folder is not None else {}
    every = {source.identity: source for shard in shards for source in shard.sources}
    left = {s.identity: s for shard in shards if shard.identity not in there for s in shard.sources}
    files, crops = sum(len(source.crops) for source in left.values()), read.model.crops
    channels = max(len(source.capture.camera.cfa.channels) for source in every.values())
    each = sum(_PART_BYTES[part] * (channels if part == "truth" else 1) for part in set(read.model.hold))
    return _forecast(
        [source.capture for source in left.values()],
        products,
        found=len(every) - len(left),
        files=files,
        frames=1,
        disk_bytes=files * crops.rows * crops.cols * each,
    )


def _forecast(
    captures: Sequence[Exposed],
    products: tuple[Product, ...],
    *,
    found: int,
    files: int,
    frames: int,
    disk_bytes: float,
) -> Forecast:
    first = {capture.optical_key: capture for capture in reversed(captures) if not isinstance(capture, Shot)}
    some = list(first.values())[:: max(1, len(first) // _SAMPLED)]
    planned_s = sum(capture.plan().cost.seconds for capture in some) / max(len(some), 1) * len(first)
    photosites = [capture.grid.rows * capture.grid.cols for capture in captures]
    needed = 0
    if captures:
        largest = captures[max(range(len(captures)), key=photosites.__getitem__)]
        grid, channels = largest.grid, len(largest.camera.cfa.channels)
        needed = memory.needed_bytes(grid.rows, grid.cols, channels, products, held=True)
    return Forecast(
        captures=len(captures),
        found=found,
        files=files,
        optical_images=len(first),
        seconds=planned_s * (_TRUTH if "truth" in products else 1.0)
        + frames * (_PHOTOSITE_S * sum(photosites) + _CAPTURE_S * len(captures)),
        disk_bytes=disk_bytes,
        # The program's memory is known here: it has loaded the same modules as a worker.
        memory_bytes=needed + psutil.Process().memory_info().rss,
    )
