"""What type checkers make of calls: mypy and pyright, both strict, take the right ones and refuse the wrong ones."""

from __future__ import annotations

import json
import os
import re
import runpy
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RIGHT, WRONG = HERE / "right.py", HERE / "wrong.py"
MARK = "# wrong from here on"

Refused: TypeAlias = Callable[[], Iterator[tuple[str, int]]]


def calls(path: Path, mark: str) -> set[int]:
    """Return the lines after a mark that call or name something of camsim."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(number for number, line in enumerate(lines, 1) if line.startswith(mark))
    return {number for number, line in enumerate(lines, 1) if number >= first and line and not line.startswith("#")}


def told(*arguments: str) -> str:
    """Return what a checker says; it sees the package of this checkout."""
    paths = {"PYTHONPATH": str(ROOT), "MYPYPATH": str(ROOT)}
    ran = subprocess.run(
        [sys.executable, "-m", *arguments, str(RIGHT), str(WRONG)],
        cwd=ROOT,
        env={**os.environ, **paths},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert ran.returncode == 1, ran.stdout + ran.stderr
    return ran.stdout


def by_mypy() -> Iterator[tuple[str, int]]:
    for name, line in re.findall(r"(\w+\.py):(\d+): error", told("mypy", "--no-error-summary")):
        yield name, int(line)


def by_pyright() -> Iterator[tuple[str, int]]:
    for found in json.loads(told("basedpyright", "--outputjson"))["generalDiagnostics"]:
        if found["severity"] == "error":
            yield Path(found["file"]).name, found["range"]["start"]["line"] + 1


@pytest.mark.parametrize(("checker", "refused"), [("mypy", by_mypy), ("basedpyright", by_pyright)])
def test_right_uses_are_taken_and_wrong_ones_refused(
    checker: str, refused: Callable[[], Iterator[tuple[str, int]]]
) -> None:
    pytest.importorskip(checker)
    found = set(refused())
    assert {line for name, line in found if name == RIGHT.name} == set()
    wrong = calls(WRONG, MARK)
    assert {line for name, line in found if name == WRONG.name} == wrong
    assert len(wrong) >= 40
    assert len(calls(RIGHT, "flat =")) >= 40


def test_the_right_uses_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert runpy.run_path(str(RIGHT))["truth"].shape == (8, 8, 1)
