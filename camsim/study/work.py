"""What a worker does: it takes the captures of a few points into files, with shared optical images."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camsim.api import Exposed
from camsim.camera.capture import Capture
from camsim.camera.frame import Frame, Product
from camsim.camera.optical_image import OpticalImage
from camsim.camera.shot import Shot
from camsim.errors import CamsimError
from camsim.files import save
from camsim.files.describe import software
from camsim.study.columns import measured
from camsim.study.manifest import BETWEEN_NOTES, DONE, FAILED, Results, Row, sha256_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One capture to be taken, with its frames.

    identity : key of all inputs of the capture
    stated   : columns known in advance: index, scene, keys that vary
    files    : (file, product) pairs of each frame
    measure  : columns to measure
    """

    identity: str
    capture: Exposed
    stated: Row
    files: tuple[tuple[tuple[str, Product], ...], ...]
    measure: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Task:
    """Items for one worker, those that share an optical image one after another."""

    items: tuple[Item, ...]
    folder: str
    software: str

    @property
    def photosites(self) -> int:
        """Photosites of all its captures."""
        return sum(one.capture.grid.rows * one.capture.grid.cols for one in self.items)

    def carry_out(self) -> Results:
        """Take the captures. Failures become rows with the reason."""
        refuse_other_software(self.software)
        done, shared = [], Shared()
        for item in self.items:
            try:
                rows = list(_taken(item, Path(self.folder), shared))
            except FAILURES as error:
                rows = [{**item.stated, "frame": 0, "file": "", "status": FAILED, "message": said(error)}]
            done.append((item.identity, rows))
        return done

    def given_up(self, why: str) -> Results:
        """Return rows with the reason why the captures could not be taken."""
        row = {"frame": 0, "file": "", "status": FAILED, "message": why}
        return [(item.identity, [{**item.stated, **row}]) for item in self.items]


FAILURES = (CamsimError, OSError, MemoryError, ArithmeticError, ValueError)
"""Errors of a capture that do not stop the others."""


def said(error: BaseException) -> str:
    """Return an error as the text that a row of the manifest holds."""
    return str(error) if isinstance(error, CamsimError) else f"{type(error).__name__}: {error}"


def refuse_other_software(begun_by: str) -> None:
    """Raise CamsimError in a worker whose version differs from that of the main process."""
    if begun_by != software():
        raise CamsimError(f"this worker has {software()}, and the work was begun by {begun_by}; install that one")


class Shared:
    """The last rendered optical image."""

    def __init__(self) -> None:
        self._key: tuple[str, bool] = ("", False)
        self._image: OpticalImage | None = None

    def frames(self, capture: Exposed, count: int, products: frozenset[Product]) -> Iterator[Frame]:
        """Yield the frames of a capture; given light on a sensor needs no rendering."""
        if isinstance(capture, Shot):
            return capture.frames(count, products=tuple(products))
        return capture.frames(count, products=tuple(products), optical_image=self.of(capture, products))

    def of(self, capture: Capture, products: frozenset[Product]) -> OpticalImage:
        """Return the image of a capture: the last one, if equal."""
        key = capture.optical_key, "truth" in products
        if self._image is None or key != self._key:
            self._image = None  # two would need twice the memory
            self._key, self._image = key, capture.optical_image(products=tuple(products))
        return self._image


def _taken(item: Item, folder: Path, shared: Shared) -> Iterator[Row]:
    began_s = time.perf_counter()
    products = frozenset(product for files in item.files for _, product in files)
    frames = shared.frames(item.capture, len(item.files), products)
    for number, (frame, files) in enumerate(zip(frames, item.files, strict=True)):
        figures, why = measured(frame, item.capture, item.measure)
        for name, product in files:
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            save(frame, path, product=product, force=True)
            seconds = time.perf_counter() - began_s
            yield {**item.stated, **_of_file(frame, number, path, name, product, why), "seconds": seconds, **figures}
        began_s = time.perf_counter()


def _of_file(frame: Frame, number: int, path: Path, name: str, product: Product, why: list[str]) -> dict[str, Any]:
    report = frame.report
    error = report.truth_error_estimate if product == "truth" else report.error_estimate
    return {
        "frame": number,
        "file": name,
        "product": product,
        "sha256": sha256_of(path),
        "bytes": path.stat().st_size,
        "status": DONE,
        "message": BETWEEN_NOTES.join(map(str, (*report.notes, *why))),
        "seed": frame.seed,
        "frame_number": frame.frame_number,
        "rows": frame.shape[0],
        "cols": frame.shape[1],
        "iso": frame.iso,
        "time_s": frame.time_s,
        "f_number": frame.f_number,
        "black_level_dn": frame.black_level_dn,
        "black_offsets_dn": [list(row) for row in frame.black_offsets_dn],
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": frame.electrons_per_dn,
        "method": report.method,
        "tolerance": report.tolerance,
        "error_estimate": error,
    }
