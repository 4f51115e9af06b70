"""Data sets: crops of many captures, noisy with their truth, split by scene and packed in shards."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Le

from camsim.api import Exposed
from camsim.camera.shot import Shot
from camsim.config.schema.study import LIGHT_FILE, DatasetFile
from camsim.core.arrays import F32
from camsim.core.calls import in_words
from camsim.core.note import Note
from camsim.core.typed import FilePath, check
from camsim.errors import InputError, InvalidValueError
from camsim.rendering.running import to_nobody
from camsim.scene.raster import Raster
from camsim.study import engines
from camsim.study.captures import Progress, captures_of, checksum, identity_of, validate_values
from camsim.study.card import write_card
from camsim.study.folder import alone, completed
from camsim.study.manifest import HIDDEN, PARQUET, Journal, Row
from camsim.study.samples import Crop, Source, products_of
from camsim.study.shards import CAPTURES, SPLITS, Shard, read_sample, remove_others
from camsim.study.shards import made as shards_made
from camsim.study.study import Point, Study, StudyOrFile, read_dataset

_INDEX = Annotated[int, Ge(0), Le(2**63 - 1)]
"""Index of a sample, within the range of a table's column."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """Result for a data set: rows of its index, one for each sample; numbers of shards made, found and failed.

    notes : remarks that are not errors
    """

    folder: Path
    rows: tuple[Row, ...]
    made: int
    found: int
    failed: int
    seconds: float
    notes: tuple[Note, ...] = ()


@in_words
def dataset(
    study: StudyOrFile,
    folder: str | os.PathLike[str],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Made:
    """Make the samples of a data set that are not there yet, its index and its card.

    study   : the file of a data set, or its keys as a mapping
    workers, scheduler, progress : see ``camsim.sweep``

    A sample's key, shard, place and split are functions of the file alone. Raises ConfigError for what is wrong with
    it, before anything is made.

    >>> import tempfile
    >>> import camsim
    >>> made_of = {
    ...     "scene": ["flat-field", "grey-steps", "slanted-edge"],
    ...     "set": {"region": {"rows": 4, "cols": 4}, "render.tolerance": 1e-2},
    ...     "crops": {"rows": 2, "cols": 2},
    ... }
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     made = camsim.dataset(made_of, folder, workers=0)
    ...     camsim.read_pair(folder, 0)[0]["truth"].shape
    (2, 2, 3)
    """
    began_s = time.perf_counter()
    report = check(progress, Progress | None, "progress") or to_nobody
    place = Path(check(folder, FilePath, "folder"))
    engine, read = engines.engine_of(workers, scheduler), read_dataset(study)
    captures = captures_of(read, products_of(tuple(read.model.hold)), report)
    shards = shards_of(read, captures)
    size = read.model.crops.rows, read.model.crops.cols
    with alone(place, others="product"):
        made_before = Journal(place).path.exists()
        done = completed(
            place,
            [shard.identity for shard in shards],
            lambda there: shards_made([s for s in shards if s.identity not in there], size, place, engine, report),
            to_nobody,
        )
        removed = 0
        if not done.failed:
            shutil.rmtree(place / HIDDEN / CAPTURES, ignore_errors=True)
            # Only in a data set's folder: elsewhere such files may be the user's.
            removed = remove_others(place, done.rows) if made_before else 0
        pictures = any(
            isinstance(capture, Shot) or any(isinstance(shape, Raster) for shape in capture.scene.shapes)
            for _, capture in captures
        )
        write_card(place, read, done.rows, pictures=pictures)
    unstated = "scenes show pictures, and nobody says whose they are and under which licence: key sources"
    others = f"{removed} files of shards that this data set has no more were removed"
    return Made(
        folder=place,
        rows=done.rows,
        made=done.made,
        found=done.found,
        failed=done.failed,
        seconds=time.perf_counter() - began_s,
        notes=(
            *((Note("no-sources", unstated, "sources"),) if pictures and not read.model.sources else ()),
            *((Note("shards-removed", others),) if removed else ()),
        ),
    )


def check_dataset(study: StudyOrFile) -> None:
    """Refuse a data set that could not be made, by its keys in every scene and its windows; nothing is captured."""
    read = read_dataset(study)
    for capture in validate_values(read, products_of(tuple(read.model.hold))):
        _crop(read, capture, 0, 0)


@in_words
def read_pair(folder: str | os.PathLike[str], index: int) -> tuple[dict[str, F32], dict[str, Any]]:
    """Return a sample of a data set: its arrays by part (noisy, clean, truth), and its row of the index.

    noisy : codes (of a sensor that compands, their data numbers), uint16;  clean : (rows, cols) and truth : (rows,
            cols, channels) mean electrons, float32

    Electrons of a code are (code − black_level_dn − black_offsets_dn) · electrons_per_dn.

    >>> import tempfile
    >>> import camsim
    >>> made_of = {
    ...     "scene": ["flat-field", "grey-steps", "slanted-edge"],
    ...     "set": {"region": {"rows": 4, "cols": 4}, "render.tolerance": 1e-2},
    ...     "crops": {"rows": 2, "cols": 2},
    ... }
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     made = camsim.dataset(made_of, folder, workers=0)
    ...     arrays, about = camsim.read_pair(folder, 2)
    >>> arrays["noisy"].shape, about["black_level_dn"]
    ((2, 2), 128)
    """
    import pyarrow.parquet as parquet

    path = Path(check(folder, FilePath, "folder")) / PARQUET
    if not path.is_file():
        raise InputError(f"{str(folder)!r} holds no data set: there is no manifest.parquet")
    found = parquet.read_table(path, filters=[("index", "==", check(index, _INDEX, "index"))]).to_pylist()
    if not found or "key" not in found[0]:
        raise InputError(f"{str(folder)!r} has no sample {index}")
    arrays, about = read_sample(Path(folder), found[0])
    # Columns of a table hold numbers and texts: matrices are JSON there.
    return arrays, {
        name: json.loads(value) if isinstance(value, str) and value.startswith("[[") else value
        for name, value in about.items()
    }


def shards_of(study: Study[DatasetFile], captures: list[tuple[Point, Exposed]]) -> list[Shard]:
    """Return a shard for each range of a split's samples; a capture with samples in two shards is listed in both."""
    ranges: dict[tuple[str, int], list[Source]] = {}
    hold, each = tuple(dict.fromkeys(study.model.hold)), study.model.crops.each
    before = dict.fromkeys(SPLITS, 0)
    for (point, capture), split in zip(captures, _splits(study, captures), strict=True):
        numbers = [(before[split] + crop) // study.model.samples_per_shard for crop in range(each)]
        before[split] += each
        source = _source(study, point, capture, split, numbers, hold)
        for number in dict.fromkeys(numbers):
            ranges.setdefault((split, number), []).append(source)
    form = study.model.shards
    return [
        Shard(
            identity=_checksum(split, number, form, [source.identity for source in sources]),
            split=split,
            number=number,
            sources=tuple(sources),
            hold=hold,
            form=form,
        )
        for (split, number), sources in ranges.items()
    ]


def _source(
    study: Study[DatasetFile],
    point: Point,
    capture: Exposed,
    split: str,
    numbers: Sequence[int],
    hold: tuple[str, ...],
) -> Source:
    crops, stated = study.model.crops, {"capture": point.index, **study.stated(point)}
    first = point.index * crops.each
    cut = tuple(_crop(study, capture, first + place, number) for place, number in enumerate(numbers))
    places = [(crop.index, crop.shard, crop.row, crop.col) for crop in cut]
    return Source(
        identity=identity_of(capture, split, stated, places, (crops.rows, crops.cols), hold),
        capture=capture,
        split=split,
        stated=stated,
        crops=cut,
    )


def _checksum(*made_of: Any) -> str:
    return hashlib.sha256(repr(made_of).encode()).hexdigest()


def _crop(study: Study[DatasetFile], capture: Exposed, index: int, shard: int) -> Crop:
    """Draw a window with the same filter phase as the capture."""
    crops, period = study.model.crops, capture.camera.cfa.period
    places = []
    for size, whole, step, name in zip(
        (crops.rows, crops.cols), (capture.grid.rows, capture.grid.cols), period, ("rows", "cols"), strict=True
    ):
        if size > whole:
            raise InvalidValueError(f"{size} is more than the {whole} of a capture", key=f"crops.{name}")
        places.append((whole - size) // step)
    rng = np.random.default_rng([study.model.seed, 1, index])
    row, col = (int(rng.integers(0, most, endpoint=True)) * step for most, step in zip(places, period, strict=True))
    return Crop(index=index, shard=shard, row=row, col=col)


def _splits(study: Study[DatasetFile], captures: list[tuple[Point, Exposed]]) -> list[str]:
    """Return each capture's split: all captures of a scene are in one, for any sensor, lens, light or noise.

    The scenes are ordered by checksum, which is effectively random, and distributed by share.
    """
    content = _scenes_displayed(captures)
    scenes = sorted(set(content))
    shares = [getattr(study.model.splits, name) for name in SPLITS]
    wanted = sum(share > 0.0 for share in shares)
    if len(scenes) < wanted:
        raise InvalidValueError(
            f"{len(scenes)} different scenes for {wanted} splits; vary the scene, or give a split no share",
            key="splits",
        )
    # Largest remainders, and at least one for each requested split.
    counts = [max(int(share * len(scenes)), int(share > 0.0)) for share in shares]
    while sum(counts) != len(scenes):
        off = [share * len(scenes) - count for share, count in zip(shares, counts, strict=True)]
        if sum(counts) < len(scenes):
            counts[int(np.argmax(off))] += 1
        else:
            counts[int(np.argmin([o if count > 1 else 1e9 for o, count in zip(off, counts, strict=True)]))] -= 1
    dealt = [name for name, count in zip(SPLITS, counts, strict=True) for _ in range(count)]
    split_of = dict(zip(scenes, dealt, strict=True))
    return [split_of[item] for item in content]


def _scenes_displayed(captures: list[tuple[Point, Exposed]]) -> list[bytes]:
    """Return the checksum of the scene of each capture; equal scenes in other lengths share the smallest.

    A scene given in photosites or frames has other lengths on every sensor, but equal content.
    """
    # Captures of one scene share it.
    displayed = {id(capture.scene): capture.scene for _, capture in captures if not isinstance(capture, Shot)}
    known = {key: checksum(scene) for key, scene in displayed.items()}
    content = [
        bytes.fromhex(capture.image.sha256) if isinstance(capture, Shot) else known[id(capture.scene)]
        for _, capture in captures
    ]
    same = {item: item for item in content}
    first: dict[str, bytes] = {}

    def least(item: bytes) -> bytes:
        while same[item] != item:
            item = same[item]
        return item

    for (point, _), item in zip(captures, content, strict=True):
        said = [
            setting for setting in point.settings if setting[0].split(".")[0] == "scene" or setting[0] == LIGHT_FILE
        ]
        one, other = sorted((least(item), least(first.setdefault(json.dumps([point.scene, said]), item))))
        same[other] = one
    return [least(item) for item in content]
