"""Results of the benchmarks: JSON lines, written as they come, read back only when they are of this version."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from camsim.bench.lines import LinesFile
from camsim.bench.machine import machine, versions
from camsim.bench.records import Line, rounded
from camsim.core.cores import cores
from camsim.errors import InputError

FORMAT = "camsim-bench/2"
FILE = "results.jsonl"


class Results(LinesFile):
    """The lines of one run, in memory and on disk."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.lines: list[Line] = []

    def add(self, kind: str, **values: Any) -> None:
        """Write one line; what is None is left out."""
        line = {"kind": kind} | {name: rounded(value) for name, value in values.items() if value is not None}
        self.write(line)
        self.lines.append(line)

    def start(self, *, quick: bool) -> None:
        """Write what the run is."""
        self.add(
            "run",
            format=FORMAT,
            quick=quick,
            started=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            machine=machine(),
            versions=versions(),
            threads=cores(),
        )


def read_results(path: str | Path) -> list[Line]:
    """Read a results file; InputError when it is none, or of another version."""
    try:
        texts = Path(path).read_text(encoding="utf-8").splitlines()
        lines = [json.loads(text) for text in texts if text.strip()]
    except FileNotFoundError:
        raise InputError(f"{str(path)!r} does not exist; give the {FILE} of an earlier make bench") from None
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from None
    except ValueError:
        raise InputError(
            f"{str(path)!r} is not a results file: it is not JSON lines; give a {FILE} of make bench"
        ) from None
    head = lines[0] if lines and isinstance(lines[0], dict) else {}
    if head.get("kind") != "run":
        raise InputError(f"{str(path)!r} is not a results file of make bench: its first line is not a run")
    if head.get("format") != FORMAT:
        raise InputError(
            f"{str(path)!r} is of version {head.get('format')!r}, and this camsim compares {FORMAT!r} only; "
            "run make bench of this version once more and compare with that"
        )
    return lines


def of_kind(lines: Iterable[Line], *kinds: str) -> list[Line]:
    """Return the lines of some kinds."""
    return [line for line in lines if line["kind"] in kinds]
