"""A pytest plugin that notes which lines of camsim each test runs.

One JSON line for each test that passes: its name, the seconds that it took (traced, so half as many again as without)
and line numbers by file. What a fixture runs is noted with the first test that asks for it. Compiled kernels and other
processes show no lines; ``references.py`` finds who calls the kernels.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections import defaultdict
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest


class Recorder:
    """Notes the lines of ``root``/camsim that tests run, at the end of a file."""

    def __init__(self, root: Path, path: Path) -> None:
        self._root = f"{root}/"
        self._package = f"{root}/camsim/"
        self._file = path.open("a", encoding="utf-8")
        self._seen: dict[CodeType, set[int]] = defaultdict(set)
        self._number: dict[CodeType, int] = {}
        self._failed = False

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note whether anything of the test failed."""
        self._failed |= report.failed

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Any:
        """Trace the test with its fixtures."""
        self._seen.clear()
        self._failed = False
        began = time.perf_counter()
        threading.settrace(self._call)
        sys.settrace(self._call)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            threading.settrace(None)  # type: ignore[arg-type]
            lines: dict[str, set[int]] = defaultdict(set)
            for code, numbers in self._seen.items():
                lines[code.co_filename.removeprefix(self._root)] |= numbers
            told = {
                "test": item.nodeid,
                "seconds": round(time.perf_counter() - began, 3),
                "lines": {path: sorted(numbers) for path, numbers in sorted(lines.items())},
            }
            if not self._failed:
                print(json.dumps(told, ensure_ascii=False), file=self._file, flush=True)

    def _call(self, frame: FrameType, event: str, argument: Any) -> Any:
        code = frame.f_code
        if not code.co_filename.startswith(self._package):
            return None
        seen = self._seen[code]
        seen.add(frame.f_lineno)
        # Once every line has been met there is no need to step through the function again.
        return None if len(seen) >= self._number_of(code) else self._line

    def _line(self, frame: FrameType, event: str, argument: Any) -> Any:
        self._seen[frame.f_code].add(frame.f_lineno)
        return self._line

    def _number_of(self, code: CodeType) -> int:
        if code not in self._number:
            self._number[code] = len({line for *_, line in code.co_lines() if line is not None})
        return self._number[code]
