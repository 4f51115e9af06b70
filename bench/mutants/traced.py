"""A pytest plugin that notes which lines of camsim each test runs.

One JSON line for each test that passes: its name, the seconds that it took (traced, so half as many again as without)
and line numbers by file. What a fixture runs is noted with the first test that asks for it. Other processes show no
lines, nor do compiled kernels: small tests of those are traced apart, with the kernels run as plain Python.
"""

from __future__ import annotations

import functools
import json
import signal
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

    def __init__(self, root: Path, path: Path, most_s: float = 0.0) -> None:
        """``most_s``: break off tests that take more CPU time, and note functions as a whole; 0: neither."""
        self._most_s = most_s
        self._root = f"{root}/"
        self._package = f"{root}/camsim/"
        self._file = path.open("a", encoding="utf-8")
        self._seen: dict[CodeType, set[int]] = defaultdict(set)
        self._lines: dict[CodeType, set[int]] = {}
        self._failed = False

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note whether anything of the test failed."""
        self._failed |= report.failed

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Any:
        """Trace the test with its fixtures."""
        _forget_kept_results()
        self._seen.clear()
        self._failed = False
        signal.signal(signal.SIGPROF, _too_long)
        signal.setitimer(signal.ITIMER_PROF, self._most_s)
        began = time.perf_counter()
        threading.settrace(self._call)
        sys.settrace(self._call)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            sys.settrace(None)
            threading.settrace(None)  # type: ignore[arg-type]
            lines: dict[str, set[int]] = defaultdict(set)
            for code, numbers in self._seen.items():
                lines[code.co_filename.removeprefix(self._root)] |= numbers
            stated = {
                "test": item.nodeid,
                "seconds": round(time.perf_counter() - began, 3),
                "lines": {path: sorted(numbers) for path, numbers in sorted(lines.items())},
            }
            if not self._failed:
                print(json.dumps(stated, ensure_ascii=False), file=self._file, flush=True)

    def _call(self, frame: FrameType, event: str, argument: Any) -> Any:
        code = frame.f_code
        if not code.co_filename.startswith(self._package):
            return None
        seen = self._seen[code]
        seen.add(frame.f_lineno)
        if self._most_s:
            seen |= self._lines_of(code)
        # Once every line has been met there is no need to step through the function again.
        return None if len(seen) >= len(self._lines_of(code)) else self._line

    def _line(self, frame: FrameType, event: str, argument: Any) -> Any:
        self._seen[frame.f_code].add(frame.f_lineno)
        return self._line

    def _lines_of(self, code: CodeType) -> set[int]:
        if code not in self._lines:
            self._lines[code] = {line for *_, line in code.co_lines() if line is not None}
        return self._lines[code]


def _forget_kept_results() -> None:
    """Empty the caches of camsim's functions, or only the first test would be seen to run what they hold."""
    for name, module in list(sys.modules.items()):
        if name.split(".")[0] == "camsim":
            for kept in vars(module).values():
                if isinstance(kept, functools._lru_cache_wrapper):
                    kept.cache_clear()


def _too_long(number: int, frame: FrameType | None) -> None:
    raise TimeoutError("takes too long to be traced")
