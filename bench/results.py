"""Results: JSON lines, written as they come, read back only when they are of this version."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any, TypeAlias

from camsim.errors import InputError, OutputError

FORMAT = "camsim-bench/2"
FILE = "results.jsonl"
Line: TypeAlias = dict[str, Any]


class Results:
    """The lines of one run, in memory and on disk."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: list[Line] = []
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("w", encoding="utf-8")
        except OSError as error:
            raise OutputError(
                f"cannot write {str(path)!r}: {error.strerror or error}; choose a folder with -o"
            ) from None

    def __enter__(self) -> Results:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def add(self, kind: str, **values: Any) -> Line:
        """Write one line, at once and for good."""
        line = {"kind": kind} | {name: rounded(value) for name, value in values.items() if value is not None}
        self._file.write(json.dumps(line, ensure_ascii=False, allow_nan=False) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())
        self.lines.append(line)
        return line


def rounded(value: Any) -> Any:
    """Return numbers to four significant digits, inside lists and tables too: no clock and no error has more.

    >>> rounded({"error": 1.23456e-7, "laps": 5, "curve": [0.100004]})
    {'error': 1.235e-07, 'laps': 5, 'curve': [0.1]}
    """
    if isinstance(value, bool | int | str) or value is None:
        return value
    if isinstance(value, dict):
        return {name: rounded(part) for name, part in value.items()}
    if isinstance(value, Iterable):
        return [rounded(part) for part in value]
    number = float(value)
    return float(f"{number:.4g}") if math.isfinite(number) else None


def read_results(path: str | Path) -> list[Line]:
    """Read a results file; InputError when it is none, or of another version."""
    try:
        texts = Path(path).read_text(encoding="utf-8").splitlines()
        lines = [json.loads(text) for text in texts if text.strip()]
    except FileNotFoundError:
        raise InputError(f"{str(path)!r} does not exist; give the {FILE} of an earlier camsim bench") from None
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from None
    except ValueError:
        raise InputError(
            f"{str(path)!r} is not a results file: it is not JSON lines; give a {FILE} of camsim bench"
        ) from None
    head = lines[0] if lines and isinstance(lines[0], dict) else {}
    if head.get("kind") != "run":
        raise InputError(f"{str(path)!r} is not a results file of camsim bench: its first line is not a run")
    if head.get("format") != FORMAT:
        raise InputError(
            f"{str(path)!r} is of version {head.get('format')!r}, and this camsim compares {FORMAT!r} only; "
            "run camsim bench of this version once more and compare with that"
        )
    return lines


def of_kind(lines: Iterable[Line], *kinds: str) -> list[Line]:
    """Return the lines of some kinds."""
    return [line for line in lines if line["kind"] in kinds]
