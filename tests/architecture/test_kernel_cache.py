"""Compiled kernels are kept under a key made of their sources, and a cache that is in no order is survived.

A small package of the same name stands for camsim: its kernel is in one module and takes in a function of another.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import types

from camsim.core.kernels import kernel
from camsim.core.kernels.cache import KEPT, _sources

CORE = Path(__file__).parents[2] / "camsim" / "core"
OUTER = """
from camsim.inner import inside
from camsim.core.kernels import is_cached, kernel

@kernel()
def outer(x):
    return 10.0 * inside(x)

if __name__ == "__main__":
    before = is_cached(outer)
    print(outer(1.0), before, bool(outer.stats.cache_hits))
"""
INNER = """
from camsim.core.kernels import kernel

@kernel()
def inside(x):
    return x + {}
"""


@pytest.fixture
def small(tmp_path):
    """The package; a function writes what is inside and runs it in a process of its own."""
    package = tmp_path / "camsim"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "outer.py").write_text(OUTER)
    shutil.copytree(CORE, package / "core", ignore=shutil.ignore_patterns("__pycache__"))

    def begin(inside, cache="cache"):
        (package / "inner.py").write_text(INNER.format(inside))
        environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / cache)}
        environment["PYTHONDONTWRITEBYTECODE"] = "1"  # Python does not see a change of the same second and size
        return subprocess.Popen(
            [sys.executable, "-m", "camsim.outer"], env=environment, cwd=tmp_path, stdout=subprocess.PIPE, text=True
        )

    def run(inside, cache="cache"):
        said, _ = begin(inside, cache).communicate()
        return said.split()

    run.begin = begin
    return run


def test_a_change_in_what_a_kernel_takes_in_is_seen_and_the_old_version_stays(small):
    assert small("1.0") == ["20.0", "False", "False"]
    assert small("2.0") == ["30.0", "False", "False"]
    assert small("1.0") == ["20.0", "True", "True"]


def test_a_damaged_cache_is_compiled_again(small, tmp_path):
    small("1.0")
    for suffix in (".nbi", ".nbc"):
        (damaged,) = (tmp_path / "cache").glob(f"outer.outer-*{suffix}")
        damaged.write_bytes(damaged.read_bytes()[:30])
        assert small("1.0")[0] == "20.0"
    assert small("1.0") == ["20.0", "True", "True"]


def test_a_folder_that_cannot_be_written_is_survived(small, tmp_path):
    (tmp_path / "file").write_text("no folder can be made in here")
    assert small("1.0", "file/cache") == ["20.0", "False", "False"]


def test_processes_share_a_cache(small):
    processes = [small.begin("1.0") for _ in range(2)]
    assert {process.communicate()[0].split()[0] for process in processes} == {"20.0"}
    assert small("1.0") == ["20.0", "True", "True"]


def test_old_versions_go(small, tmp_path):
    """Fewer are kept here than by camsim: each takes a process."""
    cache = tmp_path / "camsim" / "core" / "kernels" / "cache.py"
    cache.write_text(cache.read_text().replace(f"KEPT = {KEPT} ", "KEPT = 2 "))
    for inside in range(3):
        small(f"{inside}.0")
    assert len(list((tmp_path / "cache").glob("outer.outer-*.nbi"))) == 2
    assert small("2.0") == ["30.0", "True", "True"]


def test_no_kernel_is_compiled_anew_for_a_change_far_away():
    """A kernel's key has all that its module imports; a scene or a YAML table among that would be half the package."""
    package = CORE.parent
    modules = [file for file in package.rglob("*.py") if re.search(r"^@kernel\(", file.read_text(), re.MULTILINE)]
    assert len(modules) > 20
    assert [file.name for file in modules if _sources(str(file)) & {str(package / "scene" / "__init__.py")}] == []


def test_a_count_that_begins_at_a_known_number_is_taken_in_once():
    """Numba calls it Literal[int](1) first, and int64 when it has seen that it grows; flags have a version each."""

    @kernel()
    def inside(count, flag):
        return count if flag else -count

    for count, flag in (
        (types.literal(1), types.boolean),
        (types.int64, types.boolean),
        (types.int64, types.literal(True)),
    ):
        inside.get_call_template((count, flag), {})
    assert len(inside._taken_in) == 2
