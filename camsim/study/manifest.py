"""The records of a sweep's folder: a journal line for every finished capture, and the manifest made from them."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from camsim.errors import OutputError
from camsim.files.atomic import reason, write_whole

Row: TypeAlias = dict[str, Any]
Results: TypeAlias = list[tuple[str, list[Row]]]
"""Results of a task: the rows of each identity."""

HIDDEN = ".sweep"
PARQUET, CSV = "manifest.parquet", "manifest.csv"
DONE, FAILED = "done", "failed"
BETWEEN_NOTES = " | "
"""Separator in the column of messages, as notes contain semicolons."""

_CHUNK = 1 << 20
_HALF = re.compile(r"\..*\.[0-9a-f]{8}\.part")


class Journal:
    """Rows of finished captures, appended immediately, so that they survive an interrupted sweep."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.path = folder, folder / HIDDEN / "journal.jsonl"

    def finished(self, wanted: Collection[str]) -> dict[str, list[Row]]:
        """Return the rows of each wanted capture, by identity, whose files are all unchanged."""
        listed: dict[str, list[Row]] = {}
        asked = frozenset(wanted)
        for identity, rows in self._lines():
            if identity in asked:
                listed[identity] = rows
        return {identity: rows for identity, rows in listed.items() if self._is_there(rows)}

    def _is_there(self, rows: Sequence[Row]) -> bool:
        """Whether every file of these rows is unchanged; a shard has many rows and is read once."""
        wanted = {(row["file"], row["sha256"]) for row in rows}
        wanted |= {pair for row in rows for pair in row.get("also", {}).items()}
        return all(sha256_of(self.folder / file) == checksum for file, checksum in wanted)

    def begin(self, listed: Mapping[str, Sequence[Row]]) -> None:
        """Rewrite the listed rows, dropping a truncated line and unwanted rows."""
        lines = [_line(identity, rows) for identity, rows in listed.items()]
        write_whole(self.path, "".join(lines).encode())

    def add(self, identity: str, rows: Sequence[Row]) -> None:
        """Append the rows of a capture."""
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
                    continue  # truncated when the sweep ended


def _line(identity: str, rows: Sequence[Row]) -> str:
    return json.dumps({"capture": identity, "rows": rows}, ensure_ascii=True) + "\n"


def remove_halves(folder: Path) -> None:
    """Remove temporary files of a killed process; writers hold the folder's lock."""
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
    """Return a column of one type: numbers, or texts (others as JSON)."""
    there = [value for value in values if value is not None]
    if all(isinstance(value, bool) for value in there) or all(isinstance(value, str) for value in there):
        return values
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in there):
        whole = all(isinstance(value, int) for value in there)
        return values if whole else [None if value is None else float(value) for value in values]
    return [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]


def _parquet(columns: Mapping[str, list[Any]]) -> bytes:
    import pyarrow  # imported here, as few commands need it
    from pyarrow import parquet

    sink = pyarrow.BufferOutputStream()
    arrays = [_arrow_array(values) for values in columns.values()]
    parquet.write_table(pyarrow.Table.from_arrays(arrays, names=list(columns)), sink)
    content: bytes = sink.getvalue().to_pybytes()
    return content


def _arrow_array(values: list[Any]) -> Any:
    """Return a column for pyarrow from buffers: for a list it imports pandas, where that is installed."""
    import pyarrow

    there = np.array([value is not None for value in values], bool)
    if not there.any():
        return pyarrow.nulls(len(values))
    kind = type(values[there.argmax()])
    valid = None if there.all() else pyarrow.py_buffer(np.packbits(there, bitorder="little"))
    if kind is str:
        texts = [b"" if value is None else value.encode() for value in values]
        ends = np.cumsum([0, *map(len, texts)], dtype=np.int32)
        buffers, arrow = [ends, b"".join(texts)], pyarrow.string()
    else:
        numbers = np.array([kind() if value is None else value for value in values], kind)
        arrow = {bool: pyarrow.bool_(), int: pyarrow.int64(), float: pyarrow.float64()}[kind]
        buffers = [np.packbits(numbers, bitorder="little") if kind is bool else numbers]
    return pyarrow.Array.from_buffers(arrow, len(values), [valid, *map(pyarrow.py_buffer, buffers)])


def sha256_of(path: Path) -> str:
    """Return the checksum of a file; empty if there is none."""
    found = hashlib.sha256()
    try:
        with path.open("rb") as file:
            while chunk := file.read(_CHUNK):
                found.update(chunk)
    except OSError:
        return ""
    return found.hexdigest()


def in_order(rows: Iterable[Row]) -> list[Row]:
    """Return rows sorted by index, frame and file."""
    return sorted(rows, key=lambda row: (row["index"], row["frame"], row["file"]))
