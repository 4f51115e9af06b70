"""The folder of a sweep, locked for one process: only missing files are made."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from camsim.errors import OutputError
from camsim.files.atomic import reason
from camsim.study.captures import Progress
from camsim.study.manifest import (
    CSV,
    DONE,
    FAILED,
    HIDDEN,
    Journal,
    Results,
    Row,
    in_order,
    remove_halves,
    write_manifest,
)


@contextlib.contextmanager
def alone(folder: Path, others: str) -> Iterator[None]:
    """Lock the folder for one sweep; the system releases the lock when the process ends.

    others : a column present in manifests of data sets and absent in those of studies, or the reverse
    """
    from filelock import FileLock, Timeout

    try:
        (folder / HIDDEN).mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / HIDDEN / "lock")
        lock.acquire(timeout=0)
    except Timeout:
        raise OutputError(f"another sweep is writing into {str(folder)!r}; wait for it") from None
    except OSError as error:
        raise OutputError(f"cannot write into {str(folder)!r}: {reason(error)}") from error
    try:
        _refuse_another(folder, others)
        remove_halves(folder)
        yield
        remove_halves(folder)  # of a worker that died, whose task was repeated
    finally:
        lock.release()


def _refuse_another(folder: Path, others: str) -> None:
    """Raise OutputError if the folder's manifest would be lost."""
    with contextlib.suppress(OSError), (folder / CSV).open(encoding="utf-8", errors="replace") as manifest:
        if others in manifest.readline().rstrip().split(","):
            message = "its manifest is of another kind; give a study and a data set a folder each"
            raise OutputError(f"cannot write into {str(folder)!r}: {message}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """All rows in order, and numbers of identities made, found complete, and failed."""

    rows: tuple[Row, ...]
    made: int
    found: int
    failed: int


def completed(
    folder: Path,
    wanted: Sequence[str],
    make: Callable[[Collection[str]], Iterator[Results]],
    report: Progress,
    *,
    existing: Callable[[str, list[Row]], list[Row]] = lambda identity, rows: rows,
) -> Outcome:
    """Make missing items, and write the manifest, also on interruption; the folder must be locked.

    wanted   : identities
    make     : makes all except existing ones
    existing : returns existing rows with current indices
    """
    journal = Journal(folder)
    there = journal.finished(wanted)
    journal.begin(there)
    old, new = [existing(identity, there[identity]) for identity in wanted if identity in there], list[list[Row]]()
    every: list[Row] = []
    try:
        for results in make(there):
            for identity, one in results:
                if one[0]["status"] == DONE:
                    journal.add(identity, one)
                new.append(one)
                report("capture", (len(old) + len(new)) / len(wanted))
    finally:
        every = in_order(row for one in (*old, *new) for row in one)
        if every:
            write_manifest(folder, every)
    if lost := len(wanted) - len(old) - len(new):
        raise RuntimeError(f"{lost} of {len(wanted)} tasks came back from nobody")
    failed = sum(one[0]["status"] == FAILED for one in new)
    return Outcome(rows=tuple(every), made=len(new) - failed, found=len(old), failed=failed)
