"""What a worker does: captures of a few points into files, one optical image for all that share it."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camsim.errors import CamsimError
from camsim.exposing import Capture
from camsim.files import save
from camsim.files.describe import software
from camsim.frame import Frame, Product
from camsim.optical_image import OpticalImage
from camsim.sweeping.columns import measured
from camsim.sweeping.manifest import DONE, FAILED, Row, sha256_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One capture to be taken, with its frames.

    identity : of all that it is made of
    told     : of its rows, known before: index, scene, keys that vary
    files    : of each frame (file, product)
    measure  : columns to measure
    """

    identity: str
    capture: Capture
    told: Row
    files: tuple[tuple[tuple[str, Product], ...], ...]
    measure: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Task:
    """Items for one worker, those that share an optical image one after another."""

    items: tuple[Item, ...]
    folder: str
    software: str


def carry_out(task: Task) -> list[tuple[str, list[Row]]]:
    """Take the captures of a task; returns (identity, rows) of each. What fails is a row that says why."""
    if task.software != software():
        raise CamsimError(f"this worker has {software()}, and the sweep was begun by {task.software}; install that one")
    done, shared = [], _Shared()
    for item in task.items:
        try:
            rows = list(_taken(item, Path(task.folder), shared))
        except (CamsimError, OSError, MemoryError, ArithmeticError, ValueError) as error:
            message = str(error) if isinstance(error, CamsimError) else f"{type(error).__name__}: {error}"
            rows = [{**item.told, "frame": 0, "file": "", "status": FAILED, "message": message}]
        done.append((item.identity, rows))
    return done


class _Shared:
    """The optical image that was rendered last."""

    def __init__(self) -> None:
        self._key: tuple[str, bool] = ("", False)
        self._image: OpticalImage | None = None

    def of(self, capture: Capture, products: frozenset[Product]) -> OpticalImage:
        key = capture.optical_key, "truth" in products
        if self._image is None or key != self._key:
            self._image = None  # two would need twice the memory
            self._key, self._image = key, capture.optical_image(products=tuple(products))
        return self._image


def _taken(item: Item, folder: Path, shared: _Shared) -> Iterator[Row]:
    began_s = time.perf_counter()
    products = frozenset(product for files in item.files for _, product in files)
    seen = shared.of(item.capture, products)
    frames = item.capture.frames(len(item.files), products=tuple(products), optical_image=seen)
    for number, (frame, files) in enumerate(zip(frames, item.files, strict=True)):
        figures = measured(frame, item.measure)
        for name, product in files:
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            save(frame, path, product=product, force=True)
            seconds = time.perf_counter() - began_s
            yield {**item.told, **_of_file(frame, number, path, name, product), "seconds": seconds, **figures}
        began_s = time.perf_counter()


def _of_file(frame: Frame, number: int, path: Path, name: str, product: Product) -> dict[str, Any]:
    report = frame.report
    error = report.truth_error_estimate if product == "truth" else report.error_estimate
    return {
        "frame": number,
        "file": name,
        "product": product,
        "sha256": sha256_of(path),
        "bytes": path.stat().st_size,
        "status": DONE,
        "message": "; ".join(report.notes),
        "seed": frame.seed,
        "frame_number": frame.frame_number,
        "rows": frame.shape[0],
        "cols": frame.shape[1],
        "iso": frame.iso,
        "time_s": frame.time_s,
        "f_number": frame.f_number,
        "black_level_dn": frame.black_level_dn,
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": frame.electrons_per_dn,
        "method": report.method,
        "tolerance": report.tolerance,
        "error_estimate": error,
    }


def with_own_seed(capture: Capture, index: int) -> Capture:
    """Return the capture with noise of its own: the scene's seed and the index."""
    return dataclasses.replace(capture, seed=(capture.seed + index) % 2**63)
