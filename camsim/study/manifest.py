"""What a sweep's folder holds: a journal line for every capture that is done, and the manifest made of them."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from camsim.core.errors import OutputError
from camsim.files.atomic import reason, write_whole

Row: TypeAlias = dict[str, Any]
Results: TypeAlias = list[tuple[str, list[Row]]]
"""Of a task: the rows of each identity."""

HIDDEN = ".sweep"
PARQUET, CSV = "manifest.parquet", "manifest.csv"
DONE, FAILED = "done", "failed"
BETWEEN_NOTES = " | "
"""In the column of messages; notes have semicolons of their own."""

_CHUNK = 1 << 20
_HALF = re.compile(r"\..*\.[0-9a-f]{8}\.part")


class Journal:
    """Rows of captures that are done, appended as they come: what was finished survives whatever ends a sweep."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.path = folder, folder / HIDDEN / "journal.jsonl"

    def finished(self, wanted: Collection[str]) -> dict[str, list[Row]]:
        """Return the rows of each capture of those wanted, by identity, all of whose files are there as written."""
        kept: dict[str, list[Row]] = {}
        asked = frozenset(wanted)
        for identity, rows in self._lines():
            if identity in asked:
                kept[identity] = rows
        return {identity: rows for identity, rows in kept.items() if self._is_there(rows)}

    def _is_there(self, rows: Sequence[Row]) -> bool:
        """Whether every file of these rows is as it was written; a shard has many rows and is read once."""
        wanted = {(row["file"], row["sha256"]) for row in rows}
        wanted |= {pair for row in rows for pair in row.get("also", {}).items()}
        return all(sha256_of(self.folder / file) == checksum for file, checksum in wanted)

    def begin(self, kept: Mapping[str, Sequence[Row]]) -> None:
        """Write anew what is kept: a line that was cut off, and what is not wanted any more, go."""
        lines = [_line(identity, rows) for identity, rows in kept.items()]
        write_whole(self.path, "".join(lines).encode())

    def add(self, identity: str, rows: Sequence[Row]) -> None:
        """Append what a capture has given."""
        try:
            with self.path.open("a", encoding="ascii") as file:
                file.write(_line(identity, rows))
        except OSError as error:
            raise OutputError(f"cannot write {str(self.path)!r}: {reason(error)}") from error

    def _lines(self) -> Iterator[tuple[str, list[Row]]]:
        if not self.path.exists():
            return
        with self.path.open(encoding="ascii", errors="replace") as file:
            for line in file:
                try:
                    said = json.loads(line)
                    yield said["capture"], said["rows"]
                except (ValueError, KeyError, TypeError):
                    continue  # cut off when the sweep ended


def _line(identity: str, rows: Sequence[Row]) -> str:
    return json.dumps({"capture": identity, "rows": rows}, ensure_ascii=True) + "\n"


def remove_halves(folder: Path) -> None:
    """Remove what a process that was killed has left beside its files; whoever writes holds the folder's lock."""
    for path in folder.rglob(".*.part"):
        if _HALF.fullmatch(path.name):
            path.unlink(missing_ok=True)


def write_manifest(folder: Path, rows: Sequence[Row]) -> None:
    """Write the manifest as Parquet and as CSV, one row for each file."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(zip(*columns.values(), strict=True))
    write_whole(folder / CSV, text.getvalue().encode())
    write_whole(folder / PARQUET, _parquet(columns))


def _column(values: list[Any]) -> list[Any]:
    """Return a column of one type: numbers, or texts (what is neither as JSON)."""
    there = [value for value in values if value is not None]
    if all(isinstance(value, bool) for value in there) or all(isinstance(value, str) for value in there):
        return values
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in there):
        whole = all(isinstance(value, int) for value in there)
        return values if whole else [None if value is None else float(value) for value in values]
    return [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]


def _parquet(columns: Mapping[str, list[Any]]) -> bytes:
    import pyarrow  # half a second; nothing else needs it
    from pyarrow import parquet

    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.table(dict(columns)), sink)
    content: bytes = sink.getvalue().to_pybytes()
    return content


def sha256_of(path: Path) -> str:
    """Return the checksum of a file; empty where there is none."""
    found = hashlib.sha256()
    try:
        with path.open("rb") as file:
            while chunk := file.read(_CHUNK):
                found.update(chunk)
    except OSError:
        return ""
    return found.hexdigest()


def in_order(rows: Iterable[Row]) -> list[Row]:
    """Return rows by index, frame and file, whatever the order in which they were finished."""
    return sorted(rows, key=lambda row: (row["index"], row["frame"], row["file"]))
