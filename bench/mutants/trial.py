"""One mutant at a time in a copy of the project: a forked process runs the tests that its line matters to."""

from __future__ import annotations

import contextlib
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
from collections.abc import Iterator, Set
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
import pytest
from draw import ROOT, Mutant
from references import References

KERNELS = "kernels"
_GENEROUS = 5.0
_START_S = 40.0
_MOST_BYTES = 12 << 30
_COPIED = ("camsim", "tests", "scenes", "sensors", "lenses", "docs", "bench", "README.md", "CHANGELOG.md")
_PRELOADED = (
    *("numpy", "scipy.special", "scipy.ndimage", "scipy.optimize", "scipy.signal", "scipy.stats", "numba", "shapely"),
    *("finufft", "pydantic", "yaml", "typer", "rich.console", "tifffile", "OpenEXR", "PIL.Image", "rawpy", "colour"),
)


def copy_tree(to: Path) -> Path:
    """Copy what tests need, and the kernels that were compiled."""
    for name in (
        *_COPIED,
        "pyproject.toml",
        "Makefile",
        "LICENSE",
        "DATA_LICENSES.md",
        "CONTRIBUTING.md",
        "CITATION.cff",
    ):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, to / name)
        else:
            shutil.copy2(ROOT / name, to / name)
    compiled = Path(os.environ.get("NUMBA_CACHE_DIR") or Path(platformdirs.user_cache_dir("camsim")) / KERNELS)
    if compiled.is_dir():
        shutil.copytree(compiled, to / KERNELS, copy_function=_copied)
    return to


def _copied(file: str, to: str) -> str:
    """Copy a file that another process may take away: an older kernel."""
    with contextlib.suppress(FileNotFoundError):
        shutil.copy2(file, to)
    return to


class Selection:
    """The tests that run a line, from what ``traced.Recorder`` noted: those first that run little else."""

    def __init__(self, lines: Path) -> None:
        self._seconds: dict[str, float] = {}
        self._lines: dict[str, int] = {}
        self._by_line: dict[tuple[str, int], set[str]] = defaultdict(set)
        for stated in map(json.loads, lines.read_text(encoding="utf-8").splitlines()):
            self._seconds[stated["test"]] = stated["seconds"]
            self._lines[stated["test"]] = sum(map(len, stated["lines"].values()))
            for path, numbers in stated["lines"].items():
                for number in numbers:
                    self._by_line[path, number].add(stated["test"])
        self._killers: dict[str, Counter[str]] = defaultdict(Counter)

    def of(self, mutant: Mutant, references: References, most_s: float) -> tuple[list[str], float]:
        """Return tests to run in order, at most ``most_s`` of them, and the seconds that they should take."""
        lines = references.run_by(mutant.path, mutant.number)
        wanted = {test for line in lines for test in self._by_line[line]}
        if not wanted:  # of an expression over several lines some are never told
            wanted = {test for path, n in lines for k in range(n - 6, n + 7) for test in self._by_line[path, k]}
        if not wanted:  # what runs while a module is imported is told of no test
            paths = {path for path, _ in lines}
            wanted = {test for (path, _), tests in self._by_line.items() if path in paths for test in tests}
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
    """Have the mutant in the copy; afterwards all is as it was."""
    path = tree / mutant.path
    for bytecode in (path.parent / "__pycache__").glob(f"{path.stem}.cpython*"):
        bytecode.unlink()
    path.write_text(mutant.text(), encoding="utf-8")
    try:
        yield
    finally:
        shutil.copy2(ROOT / mutant.path, path)


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


def run_tests(
    tree: Path,
    tests: list[str],
    limit_s: float,
    *,
    interpreted: bool = False,
    compiled_anew: Set[str] = frozenset(),
) -> tuple[str, str]:
    """Run tests in the copy; returns "survived", "killed" or "timeout", and the test that failed.

    interpreted   : run kernels as plain Python: nothing is compiled, which would take a minute or two
    compiled_anew : the modules whose kernels hold the mutant; all others are those of the unchanged project
    """
    result = tree / "result.json"
    result.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        _as_child(tree, tests, result, interpreted, compiled_anew)
    deadline = time.monotonic() + limit_s
    while time.monotonic() < deadline:
        if os.waitpid(child, os.WNOHANG)[0]:
            break
        time.sleep(0.02)
    else:
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return "timeout", ""
    stated: dict[str, Any] = json.loads(result.read_text()) if result.exists() else {"failed": "the process itself"}
    return ("killed" if stated["failed"] else "survived"), stated["failed"]


def _as_child(tree: Path, tests: list[str], result: Path, interpreted: bool, compiled_anew: Set[str]) -> None:
    os.setpgid(0, 0)
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES))
    enter(tree, interpreted, compiled_anew)
    with (tree / "log").open("w") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
    watch = _Watch(tests)
    files = list(dict.fromkeys(test.split("::")[0] for test in tests))
    code = pytest.main(["-x", "-q", "--no-header", "-p", "no:cacheprovider", "--tb=short", *files], plugins=[watch])
    failed = watch.failed or ("" if code in (0, 5) else f"pytest ended with {int(code)}")
    result.write_text(json.dumps({"failed": failed}))
    os._exit(0)


def enter(tree: Path, interpreted: bool, compiled_anew: Set[str] = frozenset()) -> None:
    """Make this process, and those that it starts, work in the copy; nothing of camsim may be loaded yet."""
    import numba

    numba.config.DISABLE_JIT = interpreted
    numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"] = str(tree / KERNELS)
    os.chdir(tree)
    os.environ["PYTHONPATH"] = str(tree)
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    sys.dont_write_bytecode = True
    sys.path[:] = [str(tree), *(entry for entry in sys.path if entry not in (str(ROOT), ""))]

    from camsim.core.kernels import cache

    key_of = cache._key
    cache.KEPT = 1_000_000  # or the unchanged kernels would be forgotten after eight mutants

    def key(file: str) -> str:
        """Kernels that do not hold the mutant are those of the unchanged project, whatever their modules import."""
        if not Path(file).is_relative_to(tree):
            return key_of(file)
        name = Path(file).relative_to(tree)
        root = str(tree if name.as_posix() in compiled_anew else ROOT)
        if root != cache._ROOT:
            cache._ROOT = root
            for kept in (cache._file_of, cache._read):  # they know the imports of the other one
                kept.cache_clear()
        return key_of(os.path.join(root, name))

    cache._key = key


def limit_s(expected_s: float) -> float:
    """How long a mutant's tests may take before they count as never ending."""
    return _START_S + _GENEROUS * expected_s
