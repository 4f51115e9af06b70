"""Shards of a data set: samples packed by ranges as soon as a range is complete."""

from __future__ import annotations

import contextlib
import functools
import itertools
import json
import os
import re
import tarfile
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from camsim.files.atomic import replacing, write_whole
from camsim.files.describe import software
from camsim.study.batches import batches
from camsim.study.captures import Progress
from camsim.study.engines import Engine
from camsim.study.manifest import DONE, FAILED, HIDDEN, Journal, Results, Row, sha256_of
from camsim.study.samples import Cuts, Source, Write, arrays_in, facts, into_tar
from camsim.study.work import FAILURES, said

SPLITS = ("train", "val", "test")
PARTS = ("noisy", "clean", "truth")
_SHARD = re.compile(rf"({'|'.join(SPLITS)})-\d{{5,}}(\.tar|\.jsonl|-({'|'.join(PARTS)})\.npy)?")
_SAMPLE = re.compile(rf"\d{{8,}}\.(json|({'|'.join(PARTS)})\.npy)")
CAPTURES = "captures"
"""The hidden folder of samples not packed yet."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shard:
    """A range of a split's samples, in one file or several; sources: the captures they are from, in order."""

    identity: str
    split: str
    number: int
    sources: tuple[Source, ...]
    hold: tuple[str, ...]
    form: str

    def packed(self, cut: Mapping[str, Sequence[Row]], parts: Path, folder: Path) -> Results:
        """Write the shard. ``cut``: rows of every source, files in ``parts``; failures become rows that say why."""
        one = [[row for row in cut[source.identity] if row["shard"] == self.number] for source in self.sources]
        if failed := [rows[0] for rows in one if rows[0]["status"] == FAILED]:
            return [(self.identity, failed)]
        try:
            return [(self.identity, self._written([row for rows in one for row in rows], parts, folder))]
        except FAILURES as error:
            about = {"frame": 0, "file": "", "status": FAILED, "message": said(error)}
            return [(self.identity, [{"index": one[0][0]["index"], **about}])]

    @property
    def stem(self) -> str:
        """Prefix of the names of the shard's files."""
        return f"{self.split}-{self.number:05d}"

    def _written(self, rows: Sequence[Row], parts: Path, folder: Path) -> list[Row]:
        with _FORMS[self.form](folder / self.stem, len(rows)) as write:
            for part, cut in itertools.groupby(rows, lambda row: str(row["file"])):
                with tarfile.open(parts / part) as tar:
                    for row in cut:
                        write(row, arrays_in(tar, row["key"]))
        checksum = functools.cache(lambda file: sha256_of(folder / file))
        done: list[Row] = []
        for place, row in enumerate(rows):
            file, *also = _files(self.stem, self.form, self.hold, row["key"])
            about = {"also": {other: checksum(other) for other in also}} if also else {}
            done.append({**row, "file": file, "sha256": checksum(file), **about, "place": place})
        return done


def made(
    shards: Sequence[Shard], size: tuple[int, int], folder: Path, engine: Engine, report: Progress
) -> Iterator[Results]:
    """Take the captures for shards, and pack a shard in this process as soon as all of its samples exist.

    A capture's samples are stored in a hidden file: one rendering serves all captures that share it, for any shards,
    and captures taken before a sweep was killed are not repeated.
    """
    if not shards:
        return
    parts = folder / HIDDEN / CAPTURES
    (parts / HIDDEN).mkdir(parents=True, exist_ok=True)
    sources = {source.identity: source for shard in shards for source in shard.sources}
    lacking = {shard.identity: len(shard.sources) for shard in shards}
    users: dict[str, list[Shard]] = defaultdict(list)
    for shard in shards:
        for source in shard.sources:
            users[source.identity].append(shard)
    journal = Journal(parts)
    cut: dict[str, list[Row]] = journal.finished(sources)
    journal.begin(cut)
    tasks = _tasks([source for name, source in sources.items() if name not in cut], shards, size, parts)
    taken = 0
    for identity, rows in itertools.chain(list(cut.items()), itertools.chain.from_iterable(engine(tasks))):
        if identity not in cut and rows[0]["status"] == DONE:
            journal.add(identity, rows)
        cut[identity] = rows
        taken += 1
        report("capture", taken / len(sources))
        for shard in users[identity]:
            lacking[shard.identity] -= 1
            if lacking[shard.identity]:
                continue
            yield shard.packed(cut, parts, folder)
            for source in shard.sources:
                if not any(lacking[other.identity] for other in users[source.identity]):
                    (parts / source.file).unlink(missing_ok=True)


def _tasks(sources: Iterable[Source], shards: Sequence[Shard], size: tuple[int, int], parts: Path) -> list[Cuts]:
    place, by = os.fspath(parts.resolve()), software()
    return [
        Cuts(sources=one, size=size, hold=shards[0].hold, folder=place, software=by)
        for one in batches(sources, frames=1)
    ]


def _files(stem: str, form: str, hold: tuple[str, ...], key: str) -> list[str]:
    """Return all files with parts of a sample."""
    if form == "tar":
        return [f"{stem}.tar"]
    if form == "npy":
        return [f"{stem}.jsonl", *(f"{stem}-{part}.npy" for part in hold)]
    return [f"{stem}/{key}.json", *(f"{stem}/{key}.{part}.npy" for part in hold)]


def _into_shard(stem: Path, count: int) -> contextlib.AbstractContextManager[Write]:
    return into_tar(stem.with_name(f"{stem.name}.tar"))


@contextlib.contextmanager
def _into_files(stem: Path, count: int) -> Iterator[Write]:
    """Write each sample into separate files, in a folder."""
    stem.mkdir(exist_ok=True)

    def write(row: Row, arrays: Mapping[str, Any]) -> None:
        for part, array in arrays.items():
            with replacing(stem / f"{row['key']}.{part}.npy") as temporary, temporary.open("wb") as file:
                np.save(file, array, allow_pickle=False)
        write_whole(stem / f"{row['key']}.json", json.dumps(facts(row), sort_keys=True).encode())

    yield write


@contextlib.contextmanager
def _into_npy(stem: Path, count: int) -> Iterator[Write]:
    """Write one array for each part, samples along its first axis, and their metadata as lines of JSON."""
    with contextlib.ExitStack() as stack:
        lines = stack.enter_context(
            stack.enter_context(replacing(stem.with_name(f"{stem.name}.jsonl"))).open("w", encoding="utf-8")
        )
        stacks: dict[str, Any] = {}
        written = 0

        def write(row: Row, arrays: Mapping[str, Any]) -> None:
            nonlocal written
            for part, array in arrays.items():
                if part not in stacks:
                    temporary = stack.enter_context(replacing(stem.with_name(f"{stem.name}-{part}.npy")))
                    stacks[part] = np.lib.format.open_memmap(
                        temporary, mode="w+", dtype=array.dtype, shape=(count, *array.shape)
                    )
                stacks[part][written] = array
            lines.write(json.dumps(facts(row), sort_keys=True) + "\n")
            written += 1

        yield write
        for whole in stacks.values():
            whole.flush()
        stacks.clear()


_FORMS: Mapping[str, Callable[[Path, int], contextlib.AbstractContextManager[Write]]] = {
    "tar": _into_shard,
    "npy": _into_npy,
    "files": _into_files,
}


def remove_others(folder: Path, rows: Iterable[Row]) -> int:
    """Remove files of shards without any of these rows, and return their number.

    They are from an earlier run: readers of all shards of a split would get samples that are now in another split.
    """
    one = {file for row in rows for file in (row["file"], *row.get("also", ()))}
    removed = 0
    for path in sorted(folder.iterdir()):
        if not _SHARD.fullmatch(path.name) or path.is_symlink():
            continue
        held = [file for file in path.iterdir() if _SAMPLE.fullmatch(file.name)] if path.is_dir() else [path]
        for file in held:
            if file.relative_to(folder).as_posix() not in one:
                file.unlink()
                removed += 1
        if path.is_dir() and not any(path.iterdir()):
            path.rmdir()
    return removed


def read_sample(folder: Path, row: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the arrays of a sample and its metadata, by its row of the index."""
    if str(row["file"]).endswith(".tar"):
        with tarfile.open(folder / row["file"]) as tar:
            return arrays_in(tar, row["key"]), dict(row)
    stem, suffix = os.path.splitext(str(row["file"]))
    between, place = ("-", int(row["place"])) if suffix == ".jsonl" else (".", ...)
    arrays = {}
    for part in PARTS:
        path = folder / f"{stem}{between}{part}.npy"
        if path.exists():
            arrays[part] = np.array(np.load(path, mmap_mode="r", allow_pickle=False)[place])
    return arrays, dict(row)
