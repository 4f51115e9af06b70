"""Execution of a study: missing captures are taken, and listed in the manifest."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from camsim.api import Exposed
from camsim.config.schema.study import StudyFile
from camsim.core.calls import in_words
from camsim.core.typed import FilePath, check
from camsim.errors import InvalidValueError
from camsim.files.describe import software
from camsim.rendering.running import to_nobody
from camsim.study import engines
from camsim.study.batches import batches
from camsim.study.captures import Progress, captures_of, identity_of, validate_values
from camsim.study.folder import alone, completed
from camsim.study.manifest import Row
from camsim.study.names import Template, field_of
from camsim.study.study import Point, Study, StudyOrFile, read_study
from camsim.study.work import Item, Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """The result of a sweep.

    rows    : rows of the manifest, one for each file, in the order of indices
    varied  : columns of the varying keys
    taken, found, failed : numbers of captures taken, found complete, and failed
    """

    folder: Path
    rows: tuple[Row, ...]
    taken: int
    found: int
    failed: int
    seconds: float
    varied: tuple[str, ...] = ()


@in_words
def sweep(
    study: StudyOrFile,
    folder: str | os.PathLike[str],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Swept:
    """Take all captures of a study into a folder, with a manifest; those that are there already are not taken again.

    study     : a study file, or its keys as a mapping, whose lists may be arrays of numpy
    workers   : processes of one core each; None: as many as there are cores, or 0 for few small captures; 0: this
                process, all cores to a capture
    scheduler : instead, the address of a dask scheduler whose workers see the same folder
    progress  : called with (stage, fraction done)

    Files and their checksums do not depend on workers, engine or order. Raises ConfigError for what is wrong with the
    study, before anything is taken; a capture that fails later is a row that says why.
    Such as ``camsim.sweep({"scene": "slanted-edge", "vary": {"exposure.iso": [200, 800]}}, "out")``.

    >>> import tempfile
    >>> import camsim
    >>> study = {
    ...     "scene": "flat-field",
    ...     "set": {"region": {"rows": 2, "cols": 2}},
    ...     "vary": {"exposure.iso": [200, 800]},
    ... }
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     swept = camsim.sweep(study, folder, workers=0)
    >>> swept.taken, [row["iso"] for row in swept.rows]
    (2, [200.0, 800.0])
    """
    began_s = time.perf_counter()
    report = check(progress, Progress | None, "progress") or to_nobody
    engine, place = engines.engine_of(workers, scheduler), Path(check(folder, FilePath, "folder"))
    read, files = read_study(study)
    items = items_of(read, files, report)
    of = {item.identity: item for item in items}
    with alone(place, others="shard"):
        done = completed(
            place,
            list(of),
            lambda there: engine(_tasks([item for item in items if item.identity not in there], place)),
            report,
            existing=lambda identity, rows: _renumbered(of[identity], rows),
        )
    return Swept(
        folder=place,
        rows=done.rows,
        taken=done.made,
        found=done.found,
        failed=done.failed,
        seconds=time.perf_counter() - began_s,
        varied=("scene", *(field_of(key) for key in read.model.vary)),
    )


def check_study(study: StudyOrFile) -> None:
    """Refuse a study with keys that a scene does not know or values that it cannot have; nothing is captured."""
    read, files = read_study(study)
    validate_values(read, tuple(template.product for template in files))


def items_of(study: Study[StudyFile], files: Sequence[Template], report: Progress) -> list[Item]:
    """Return all validated captures; raises CamsimError with all faults."""
    names: dict[str, int] = {}
    items = []
    for point, capture in captures_of(study, tuple(template.product for template in files), report):
        item = _item(study, files, point, capture)
        for name in (name for frame in item.files for name, _ in frame):
            other = names.get(name)
            if other == point.index:
                raise InvalidValueError(f"capture {other} makes {name!r} twice; give each file a name", key="files")
            if other is not None:
                message = f"captures {other} and {point.index} both make {name!r}; add {{index}} to the name"
                raise InvalidValueError(message, key="files")
            names[name] = point.index
        items.append(item)
    return items


def _item(study: Study[StudyFile], templates: Sequence[Template], point: Point, capture: Exposed) -> Item:
    settings, stem = dict(point.settings), Path(point.scene).stem
    frames = study.model.frames
    files = tuple(
        tuple(
            (template.name(index=point.index, frame=k, frames=frames, scene=stem, settings=settings), template.product)
            for template in templates
        )
        for k in range(frames)
    )
    return Item(
        identity=identity_of(capture, files, study.model.measure),
        capture=capture,
        stated={"index": point.index, **study.stated(point)},
        files=files,
        measure=tuple(study.model.measure),
    )


def _renumbered(item: Item, rows: list[Row]) -> list[Row]:
    """Return existing rows with current indices, which change when a study is extended."""
    return [{**item.stated, **{key: value for key, value in row.items() if key not in item.stated}} for row in rows]


def _tasks(items: list[Item], folder: Path) -> list[Task]:
    frames = len(items[0].files) if items else 1
    return [Task(one, os.fspath(folder.resolve()), software()) for one in batches(items, frames=frames)]
