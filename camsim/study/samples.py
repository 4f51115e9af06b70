"""Samples of a data set, cut from captures; each capture's are in a separate file until packed in shards."""

from __future__ import annotations

import contextlib
import io
import json
import math
import tarfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from camsim.api import Exposed
from camsim.camera.frame import Frame, Product
from camsim.errors import UnsupportedError
from camsim.files.atomic import replacing
from camsim.sensor.colour_matrix import as_shot_neutral, fit
from camsim.sensor.stages.column_noise import ColumnNoise
from camsim.sensor.stages.dark_current import DarkCurrent
from camsim.sensor.stages.dsnu import Dsnu
from camsim.sensor.stages.offset_map import OffsetMap
from camsim.sensor.stages.shot_noise import ShotNoise
from camsim.study.manifest import BETWEEN_NOTES, DONE, FAILED, Results, Row, sha256_of
from camsim.study.work import FAILURES, Shared, refuse_other_software, said

_OF_THE_FOLDER = ("status", "message", "frame", "shard", "file", "sha256")


@dataclass(frozen=True, slots=True, kw_only=True)
class Crop:
    """One sample: index in the data set, shard, and the first photosite of its window in the capture."""

    index: int
    shard: int
    row: int
    col: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A capture with the samples that are cut from it.

    identity : key of the capture and of its samples
    stated   : columns known in advance: index of the capture, and keys that vary
    """

    identity: str
    capture: Exposed
    split: str
    stated: Row
    crops: tuple[Crop, ...]

    @property
    def file(self) -> str:
        """Name of the file that holds the samples of this capture."""
        return f"{self.stated['capture']:08d}.tar"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cuts:
    """A task: samples of a few captures, those that share an optical image one after another."""

    sources: tuple[Source, ...]
    size: tuple[int, int]
    hold: tuple[str, ...]
    folder: str
    software: str

    @property
    def photosites(self) -> int:
        """Photosites of all its captures."""
        return sum(one.capture.grid.rows * one.capture.grid.cols for one in self.sources)

    def carry_out(self) -> Results:
        """Write the samples of each capture into a file. Failures become rows with the reason."""
        refuse_other_software(self.software)
        done, shared = [], Shared()
        for source in self.sources:
            try:
                rows = self._cut(source, shared)
            except FAILURES as error:
                rows = _failed(source, said(error))
            done.append((source.identity, rows))
        return done

    def given_up(self, why: str) -> Results:
        """Return rows with the reason why the captures could not be taken."""
        return [(source.identity, _failed(source, why)) for source in self.sources]

    def _cut(self, source: Source, shared: Shared) -> list[Row]:
        products = products_of(self.hold)
        frame = next(shared.frames(source.capture, 1, frozenset(products)))
        whole: dict[str, Any] = {"noisy": frame.linear_dn, "clean": frame.mean_electrons, "truth": frame.truth}
        about, offsets_dn = noise_model(frame, source.capture), np.array(frame.black_offsets_dn)
        rows: list[Row] = []
        path = Path(self.folder) / source.file
        with into_tar(path) as write:
            for crop in source.crops:
                window = np.s_[crop.row : crop.row + self.size[0], crop.col : crop.col + self.size[1]]
                rows.append(
                    {
                        "index": crop.index,
                        "frame": 0,
                        "key": f"{crop.index:08d}",
                        "split": source.split,
                        "shard": crop.shard,
                        "row": crop.row,
                        "col": crop.col,
                        **source.stated,
                        **about,
                        "black_offsets_dn": np.roll(offsets_dn, (-crop.row, -crop.col), (0, 1)).tolist(),
                        "status": DONE,
                        "message": BETWEEN_NOTES.join(map(str, frame.report.notes)),
                    }
                )
                write(rows[-1], {part: _stored(whole[part][window]) for part in self.hold})
        about_file = {"file": source.file, "sha256": sha256_of(path)}
        return [{**row, **about_file} for row in rows]


def products_of(hold: tuple[str, ...]) -> tuple[Product, ...]:
    """Return the products to render; the truth is left out if not held, as it takes more than twice the time."""
    return ("mosaic", "truth") if "truth" in hold else ("mosaic",)


def _failed(source: Source, why: str) -> list[Row]:
    shared = {"frame": 0, "file": "", "status": FAILED, "message": why}
    return [{"index": crop.index, "shard": crop.shard, **shared} for crop in source.crops]


def _stored(window: np.ndarray) -> np.ndarray:
    """Return a copy in the type of samples: codes unchanged, electrons as float32."""
    return np.array(window, dtype=np.float32 if window.dtype.kind == "f" else window.dtype, order="C")


def noise_model(frame: Frame, capture: Exposed) -> dict[str, Any]:
    """Return the noise model of a frame's codes, for denoisers, and its colour metadata, for developers.

    In codes above black, for a photosite with mean light m: the mean signal is m + dark_dn, and the mean squared
    deviation is shot_dn · (m + dark_dn) + read_dn2 + (prnu · m)² + dsnu_dn². The first two terms are temporal, the
    others fixed patterns of the sensor. read_dn2 includes rounding, 1/12 DN² at every ISO, as the gain acts before the
    converter. dsnu_dn combines all fixed offsets: DSNU, columns, non-uniform dark current. prnu is the PRNU on a
    uniform grey after crosstalk, which averages independent gains. No term includes the non-linearity, which comes
    after m; the NoiseProfile of a DNG is for codes, and includes the slope at mid-grey.
    """
    gain, acting, dark_e = frame.electrons_per_dn, capture.electronics, capture.dark_e
    offsets_e = [0.0]
    for stage in acting:
        if isinstance(stage, DarkCurrent):
            offsets_e.append(stage.nonuniformity * dark_e)
        elif isinstance(stage, Dsnu | ColumnNoise):
            offsets_e.append(stage.sigma_e)
        elif isinstance(stage, OffsetMap):
            offsets_e.append(stage.spread_e(gain))
    read_e = math.hypot(*(stage.dark_noise_e(gain) for stage in acting))
    stated = {
        "cfa": "/".join(frame.cfa_pattern),
        "channels": "".join(frame.channels) if all(len(c) == 1 for c in frame.channels) else "/".join(frame.channels),
        "black_level_dn": frame.black_level_dn,
        "black_offsets_dn": [list(row) for row in frame.black_offsets_dn],
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": gain,
        "shot_dn": 1.0 / gain if any(isinstance(stage, ShotNoise) for stage in acting) else 0.0,
        "read_dn2": (read_e / gain) ** 2 + 1.0 / 12.0,
        "dark_dn": dark_e / gain,
        "prnu": capture.camera.prnu_on_grey if capture.noise else 0.0,
        "dsnu_dn": math.hypot(*offsets_e) / gain,
        "serial": capture.camera.serial,
        "iso": frame.iso,
        "time_s": frame.time_s,
        "f_number": frame.f_number,
        "seed": frame.seed,
        "error_estimate": frame.report.error_estimate,
        "truth_error_estimate": frame.report.truth_error_estimate,
    }
    if len(frame.channels) > 1:
        neutral = as_shot_neutral(frame.colour)
        stated |= {f"neutral_{name}": float(value) for name, value in zip(frame.channels, neutral, strict=True)}
        with contextlib.suppress(UnsupportedError):  # nearly equal filters have no matrix
            matrix = fit(frame.colour.of_filters, "D65").xyz_to_camera
            stated["xyz_to_camera_d65"] = [[round(float(value), 6) for value in row] for row in matrix]
    return stated


Write: TypeAlias = Callable[[Row, Mapping[str, Any]], None]


@contextlib.contextmanager
def into_tar(path: Path) -> Iterator[Write]:
    """Return a writer of samples in the format of webdataset: files of one sample, its key, are adjacent."""
    with replacing(path) as temporary, tarfile.open(temporary, "w", format=tarfile.USTAR_FORMAT) as tar:

        def write(row: Row, arrays: Mapping[str, Any]) -> None:
            for part, array in arrays.items():
                content = io.BytesIO()
                np.save(content, array, allow_pickle=False)
                _add(tar, f"{row['key']}.{part}.npy", content.getvalue())
            _add(tar, f"{row['key']}.json", json.dumps(facts(row), sort_keys=True).encode())

        yield write


def _add(tar: tarfile.TarFile, name: str, content: bytes) -> None:
    member = tarfile.TarInfo(name)  # no time, no owner: equal samples give equal bytes
    member.size = len(content)
    tar.addfile(member, io.BytesIO(content))


def facts(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the metadata of a sample: its row without its location."""
    return {name: value for name, value in row.items() if name not in _OF_THE_FOLDER}


def arrays_in(tar: tarfile.TarFile, key: str) -> dict[str, Any]:
    """Return the arrays of one sample."""
    arrays = {}
    for name in tar.getnames():
        file = tar.extractfile(name) if name.startswith(f"{key}.") and name.endswith(".npy") else None
        if file is not None:
            arrays[name.split(".")[1]] = np.load(io.BytesIO(file.read()), allow_pickle=False)
    return arrays
