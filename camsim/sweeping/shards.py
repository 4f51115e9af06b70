"""Samples of a data set: crops of captures, packed into the shards that a range of samples makes."""

from __future__ import annotations

import contextlib
import io
import json
import tarfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from camsim.arrays import F32
from camsim.exposing import Capture
from camsim.files.atomic import replacing
from camsim.frame import Frame, Product
from camsim.sensor.colour_matrix import as_shot_neutral
from camsim.sweeping.manifest import DONE, FAILED, Results, Row, sha256_of
from camsim.sweeping.work import FAILURES, Shared, refuse_other_software, said

SPLITS = ("train", "val", "test")
_PRODUCTS: tuple[Product, ...] = ("mosaic", "truth")


@dataclass(frozen=True, slots=True, kw_only=True)
class Crop:
    """One sample: its index in the data set, and the first photosite of its window of the capture."""

    index: int
    row: int
    col: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A capture with the samples that are cut from it; told: of their rows, index of the capture and keys that vary."""

    capture: Capture
    split: str
    told: Row
    crops: tuple[Crop, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardTask:
    """All samples with indices of one range, each into its split's shard of that number."""

    identity: str
    number: int
    sources: tuple[Source, ...]
    size: tuple[int, int]
    hold: tuple[str, ...]
    form: Literal["tar", "npy"]
    folder: str
    software: str

    def carry_out(self) -> Results:
        """Write the shard of every split that has samples here. What fails is a row that says why."""
        refuse_other_software(self.software)
        try:
            return [(self.identity, self._written())]
        except FAILURES as error:
            return self.given_up(said(error))

    def given_up(self, why: str) -> Results:
        """Return a row that says why nobody could."""
        first = self.sources[0].crops[0].index
        return [(self.identity, [{"index": first, "frame": 0, "file": "", "status": FAILED, "message": why}])]

    def _written(self) -> list[Row]:
        folder, shared = Path(self.folder), Shared()
        counts = {split: sum(len(s.crops) for s in self.sources if s.split == split) for split in SPLITS}
        rows: dict[str, list[Row]] = {split: [] for split in SPLITS if counts[split]}
        stems = {split: f"{split}-{self.number:05d}" for split in rows}
        with contextlib.ExitStack() as stack:
            into = _into_tar if self.form == "tar" else _into_npy
            writers = {split: stack.enter_context(into(folder / stems[split], counts[split])) for split in rows}
            for source in self.sources:
                for row, arrays in self._cut(source, shared):
                    writers[source.split](row, arrays)
                    rows[source.split].append(row)
        done: list[Row] = []
        for split, own in rows.items():
            files = _files(stems[split], self.form, self.hold)
            sums = {file: sha256_of(folder / file) for file in files}
            about = {"file": files[0], "sha256": sums.pop(files[0]), **({"also": sums} if sums else {})}
            done += [{**row, **about, "place": place} for place, row in enumerate(own)]
        return done

    def _cut(self, source: Source, shared: Shared) -> Iterator[tuple[Row, dict[str, Any]]]:
        seen = shared.of(source.capture, frozenset(_PRODUCTS))
        frame = next(source.capture.frames(products=_PRODUCTS, optical_image=seen))
        assert frame.truth is not None
        whole: dict[str, Any] = {
            "noisy": frame.mosaic,
            "clean": frame.mean_electrons.astype(np.float32),
            "truth": frame.truth,
        }
        about = noise_model(frame)
        for crop in source.crops:
            window = np.s_[crop.row : crop.row + self.size[0], crop.col : crop.col + self.size[1]]
            row = {
                "index": crop.index,
                "frame": 0,
                "key": f"{crop.index:08d}",
                "split": source.split,
                "shard": self.number,
                "row": crop.row,
                "col": crop.col,
                **source.told,
                **about,
                "status": DONE,
                "message": "",
            }
            yield row, {part: np.ascontiguousarray(whole[part][window]) for part in self.hold}


def noise_model(frame: Frame) -> dict[str, Any]:
    """Return what a denoiser needs to know of a frame's codes.

    In codes above black: variance = shot_dn · mean + read_dn2, shot noise and all that does not grow with the light.
    """
    gain = frame.electrons_per_dn
    told = {
        "cfa": "/".join(frame.cfa_pattern),
        "channels": "".join(frame.channels) if all(len(c) == 1 for c in frame.channels) else "/".join(frame.channels),
        "black_level_dn": frame.black_level_dn,
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": gain,
        "shot_dn": 1.0 / gain,
        "read_dn2": (frame.read_noise_e / gain) ** 2 + 1.0 / 12.0,
        "iso": frame.iso,
        "time_s": frame.time_s,
        "f_number": frame.f_number,
        "seed": frame.seed,
        "error_estimate": frame.report.error_estimate,
        "truth_error_estimate": frame.report.truth_error_estimate,
    }
    if len(frame.channels) > 1:
        neutral = as_shot_neutral(frame.colour)
        told |= {f"neutral_{name}": float(value) for name, value in zip(frame.channels, neutral, strict=True)}
    return told


Write: TypeAlias = Callable[[Row, dict[str, Any]], None]


def _files(stem: str, form: str, hold: tuple[str, ...]) -> list[str]:
    return [f"{stem}.tar"] if form == "tar" else [f"{stem}.jsonl", *(f"{stem}-{part}.npy" for part in hold)]


@contextlib.contextmanager
def _into_tar(stem: Path, count: int) -> Iterator[Write]:
    """Write samples as webdataset reads them: members of one key lie together."""
    with (
        replacing(stem.with_name(f"{stem.name}.tar")) as beside,
        tarfile.open(beside, "w", format=tarfile.USTAR_FORMAT) as tar,
    ):

        def write(row: Row, arrays: dict[str, Any]) -> None:
            for part, array in arrays.items():
                content = io.BytesIO()
                np.save(content, array, allow_pickle=False)
                _add(tar, f"{row['key']}.{part}.npy", content.getvalue())
            _add(tar, f"{row['key']}.json", json.dumps(_facts(row), sort_keys=True).encode())

        yield write


@contextlib.contextmanager
def _into_npy(stem: Path, count: int) -> Iterator[Write]:
    """Write one array for each part, samples along its first axis, and their facts as lines of JSON."""
    with contextlib.ExitStack() as stack:
        lines = stack.enter_context(
            stack.enter_context(replacing(stem.with_name(f"{stem.name}.jsonl"))).open("w", encoding="utf-8")
        )
        stacks: dict[str, Any] = {}
        written = 0

        def write(row: Row, arrays: dict[str, Any]) -> None:
            nonlocal written
            for part, array in arrays.items():
                if part not in stacks:
                    beside = stack.enter_context(replacing(stem.with_name(f"{stem.name}-{part}.npy")))
                    stacks[part] = np.lib.format.open_memmap(
                        beside, mode="w+", dtype=array.dtype, shape=(count, *array.shape)
                    )
                stacks[part][written] = array
            lines.write(json.dumps(_facts(row), sort_keys=True) + "\n")
            written += 1

        yield write
        for whole in stacks.values():
            whole.flush()
        stacks.clear()


def _add(tar: tarfile.TarFile, name: str, content: bytes) -> None:
    member = tarfile.TarInfo(name)  # no time, no owner: equal samples give equal bytes
    member.size = len(content)
    tar.addfile(member, io.BytesIO(content))


def _facts(row: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in row.items() if name not in ("status", "message", "frame", "shard")}


def read_sample(folder: Path, row: Mapping[str, Any]) -> tuple[dict[str, F32], dict[str, Any]]:
    """Return the arrays of a sample and its facts, by its row of the index."""
    if str(row["file"]).endswith(".tar"):
        with tarfile.open(folder / row["file"]) as tar:
            members = [member for member in tar.getmembers() if member.name.startswith(f"{row['key']}.")]
            content = {member.name.split(".", 1)[1]: tar.extractfile(member) for member in members}
            arrays = {
                name[:-4]: np.load(io.BytesIO(file.read()), allow_pickle=False)
                for name, file in content.items()
                if file is not None and name.endswith(".npy")
            }
        return arrays, dict(row)
    stem = str(row["file"]).removesuffix(".jsonl")
    arrays = {}
    for part in ("noisy", "clean", "truth"):
        path = folder / f"{stem}-{part}.npy"
        if path.exists():
            arrays[part] = np.array(np.load(path, mmap_mode="r", allow_pickle=False)[int(row["place"])])
    return arrays, dict(row)
