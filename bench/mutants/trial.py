"""One mutant at a time in a copy of the project: a forked process runs the tests that its line matters to."""

from __future__ import annotations

import importlib
import json
import os
import resource
import shutil
import signal
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from draw import ROOT, Mutant
from references import References

_GENEROUS = 5.0
_START_S = 40.0
_MOST_BYTES = 12 << 30
_COPIED = ("camsim", "tests", "scenes", "sensors", "docs", "bench", "README.md", "CHANGELOG.md", "pyproject.toml")
_PRELOADED = (
    *("numpy", "scipy.special", "scipy.ndimage", "scipy.optimize", "scipy.signal", "scipy.stats", "numba", "shapely"),
    *("finufft", "pydantic", "yaml", "typer", "rich.console", "tifffile", "OpenEXR", "PIL.Image", "rawpy", "colour"),
)


def copy_tree(to: Path) -> Path:
    """Copy what tests need, compiled kernels included, with the files' times by which Numba knows them."""
    for name in (*_COPIED, "Makefile", "LICENSE", "DATA_LICENSES.md"):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, to / name)
        else:
            shutil.copy2(ROOT / name, to / name)
    return to


class Selection:
    """The tests that run a line, from what ``traced.Recorder`` noted: those first that run little else."""

    def __init__(self, lines: Path) -> None:
        self._seconds: dict[str, float] = {}
        self._lines: dict[str, int] = {}
        self._by_line: dict[tuple[str, int], set[str]] = defaultdict(set)
        for told in map(json.loads, lines.read_text(encoding="utf-8").splitlines()):
            self._seconds[told["test"]] = told["seconds"]
            self._lines[told["test"]] = sum(map(len, told["lines"].values()))
            for path, numbers in told["lines"].items():
                for number in numbers:
                    self._by_line[path, number].add(told["test"])
        self._killers: dict[str, Counter[str]] = defaultdict(Counter)

    def of(self, mutant: Mutant, references: References, most_s: float) -> tuple[list[str], float]:
        """Return tests to run in order, at most ``most_s`` of them, and the seconds that they should take."""
        lines = references.run_by(mutant.path, mutant.number)
        wanted = {test for line in lines for test in self._by_line[line]}
        if not wanted:  # of an expression over several lines some are never told
            wanted = {test for path, n in lines for k in range(n - 6, n + 7) for test in self._by_line[path, k]}
        files: dict[str, list[str]] = defaultdict(list)
        took_s = 0.0
        for test in sorted(wanted, key=lambda test: (-self._killers[mutant.path][_function(test)], self._lines[test])):
            if took_s + self._seconds[test] <= most_s:
                files[test.split("::")[0]].append(test)
                took_s += self._seconds[test]
        # Those of a file together, or its fixtures would be made again and again.
        return [test for tests in files.values() for test in tests], took_s

    def forget(self, start: str) -> None:
        """Ask no more for tests whose name begins so."""
        for tests in self._by_line.values():
            tests -= {test for test in tests if test.startswith(start)}

    def remember(self, mutant: Mutant, killer: str) -> None:
        """Ask a test that killed first, when it comes to the same module again."""
        self._killers[mutant.path][_function(killer)] += 1


def _function(test: str) -> str:
    return test.split("[")[0]


@contextmanager
def changed(tree: Path, mutant: Mutant) -> Iterator[None]:
    """Have the mutant in the copy; afterwards all is as it was.

    The file keeps its time, by which the compiled kernels of others know that they are not stale.
    """
    path = tree / mutant.path
    before = path.stat()
    for bytecode in (path.parent / "__pycache__").glob(f"{path.stem}.cpython*"):
        bytecode.unlink()
    path.write_text(mutant.text(), encoding="utf-8")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    try:
        yield
    finally:
        shutil.copy2(ROOT / mutant.path, path)
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


@contextmanager
def compiled_anew(tree: Path, modules: set[str]) -> Iterator[None]:
    """Have none of these modules' kernels compiled in the copy; afterwards they are as they were."""
    places = [(tree / path).parent / "__pycache__" for path in modules]
    aside = tree / "kernels aside"
    aside.mkdir()

    def compiled() -> list[Path]:
        names = (f"{Path(path).stem}.*.nb?" for path in modules)
        return [file for place, name in zip(places, names, strict=True) for file in place.glob(name)]

    before = [(file, aside / str(k)) for k, file in enumerate(compiled())]
    for file, kept in before:
        file.rename(kept)
    try:
        yield
    finally:
        for file in compiled():
            file.unlink()
        for file, kept in before:
            kept.rename(file)
        aside.rmdir()


class _Watch:
    """A pytest plugin: only the chosen tests, in their order; keeps the first that fails."""

    def __init__(self, tests: list[str]) -> None:
        self._place = {test: k for k, test in enumerate(tests)}
        self.failed = ""

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [item for item in items if item.nodeid in self._place]
        items.sort(key=lambda item: self._place[item.nodeid])

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid


def preload() -> None:
    """Load other people's packages once, for all the forked processes; what they change in numpy is undone."""
    options = np.get_printoptions()
    with warnings.catch_warnings(), np.errstate():
        warnings.simplefilter("ignore")
        for name in _PRELOADED:
            importlib.import_module(name)
    np.set_printoptions(**options)


def run_tests(tree: Path, tests: list[str], limit_s: float, *, interpreted: bool = False) -> tuple[str, str]:
    """Run tests in the copy; returns "survived", "killed" or "timeout", and the test that failed.

    interpreted : run kernels as plain Python: nothing is compiled, which would take a minute or two
    """
    result = tree / "result.json"
    result.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        _as_child(tree, tests, result, interpreted)
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline:
        if os.waitpid(child, os.WNOHANG)[0]:
            break
        time.sleep(0.02)
    else:
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return "timeout", ""
    told: dict[str, Any] = json.loads(result.read_text()) if result.exists() else {"failed": "the process itself"}
    return ("killed" if told["failed"] else "survived"), told["failed"]


def _as_child(tree: Path, tests: list[str], result: Path, interpreted: bool) -> None:
    os.setpgid(0, 0)
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES))
    enter(tree, interpreted)
    with (tree / "log").open("w") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
    watch = _Watch(tests)
    files = list(dict.fromkeys(test.split("::")[0] for test in tests))
    code = pytest.main(["-x", "-q", "--no-header", "-p", "no:cacheprovider", "--tb=short", *files], plugins=[watch])
    failed = watch.failed or ("" if code in (0, 5) else f"pytest ended with {int(code)}")
    result.write_text(json.dumps({"failed": failed}))
    os._exit(0)


def enter(tree: Path, interpreted: bool) -> None:
    """Make this process, and those that it starts, work in the copy; nothing of camsim may be loaded yet."""
    import numba
    from numba.core import caching

    numba.config.DISABLE_JIT = interpreted
    locator = caching._SourceFileBackedLocatorMixin
    stamp = locator.get_source_stamp

    def stamp_of_the_original(self: Any) -> Any:
        """Kernels beside a changed line that they do not hold are those of the unchanged file."""
        copied = self._py_file
        self._py_file = copied.replace(str(tree), str(ROOT))
        try:
            return stamp(self)
        finally:
            self._py_file = copied

    locator.get_source_stamp = stamp_of_the_original
    os.chdir(tree)
    os.environ["PYTHONPATH"] = str(tree)
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    sys.dont_write_bytecode = True
    sys.path[:] = [str(tree), *(entry for entry in sys.path if entry not in (str(ROOT), ""))]


def limit_s(expected_s: float) -> float:
    """How long a mutant's tests may take before they count as never ending."""
    return _START_S + _GENEROUS * expected_s
