"""JSON lines, written to disk immediately."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import TracebackType

from camsim.bench.records import Line
from camsim.errors import OutputError


class LinesFile:
    """A file of one JSON object per line; written lines survive a crash."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("w", encoding="utf-8")
        except OSError as error:
            raise OutputError(
                f"cannot write {str(path)!r}: {error.strerror or error}; choose a folder with -o"
            ) from None

    def __enter__(self) -> LinesFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def write(self, line: Line) -> None:
        """Write and flush one line."""
        self._file.write(json.dumps(line, ensure_ascii=False, allow_nan=False) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())
