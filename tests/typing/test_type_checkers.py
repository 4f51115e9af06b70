"""What type checkers make of calls: mypy and pyright, both strict, take the right ones and refuse the wrong ones."""

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
from blocks import blocks_of

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RIGHT, WRONG = HERE / "right.py", HERE / "wrong.py"
MARK = "# wrong from here on"

Refused: TypeAlias = Callable[[list[Path]], Iterator[tuple[str, int]]]


def calls(path: Path, mark: str) -> set[int]:
    """Return the lines after a mark that call or name something of camsim."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(number for number, line in enumerate(lines, 1) if line.startswith(mark))
    return {number for number, line in enumerate(lines, 1) if number >= first and line and not line.startswith("#")}


def pages(folder: Path) -> list[Path]:
    """Return the Python of each page on stages of one's own as a file."""
    files = []
    for page in ("howto/own-noise", "howto/own-lens", "developers"):
        blocks = blocks_of((ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8"))
        files.append(folder / f"{Path(page).name.replace('-', '_')}.py")
        lines = "\n".join(block.body for block in blocks if block.language == "python").splitlines()
        # Blocks further down a page import again what is there.
        again = {n for n, line in enumerate(lines) if line.startswith(("import ", "from ")) and line in lines[:n]}
        files[-1].write_text("\n".join(line for n, line in enumerate(lines) if n not in again), encoding="utf-8")
    return files


def stated(files: list[Path], *arguments: str) -> str:
    """Return what a checker says of files; it sees the package of this checkout."""
    paths = {"PYTHONPATH": str(ROOT), "MYPYPATH": str(ROOT)}
    ran = subprocess.run(
        [sys.executable, "-m", *arguments, *map(str, files)],
        cwd=ROOT,
        env={**os.environ, **paths},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert ran.returncode == 1, ran.stdout + ran.stderr
    return ran.stdout


def by_mypy(files: list[Path]) -> Iterator[tuple[str, int]]:
    for name, line in re.findall(r"(\w+\.py):(\d+): error", stated(files, "mypy", "--no-error-summary")):
        yield name, int(line)


def by_pyright(files: list[Path]) -> Iterator[tuple[str, int]]:
    for found in json.loads(stated(files, "basedpyright", "--outputjson"))["generalDiagnostics"]:
        if found["severity"] == "error":
            yield Path(found["file"]).name, found["range"]["start"]["line"] + 1


@pytest.mark.parametrize(("checker", "refused"), [("mypy", by_mypy), ("basedpyright", by_pyright)])
def test_right_uses_are_taken_and_wrong_ones_refused(checker: str, refused: Refused, tmp_path: Path) -> None:
    pytest.importorskip(checker)
    found = set(refused([RIGHT, WRONG, *pages(tmp_path)]))
    assert {(name, line) for name, line in found if name != WRONG.name} == set()
    wrong = calls(WRONG, MARK)
    assert {line for name, line in found if name == WRONG.name} == wrong
    assert len(wrong) >= 40
    assert len(calls(RIGHT, "flat =")) >= 40


def test_the_right_uses_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert runpy.run_path(str(RIGHT))["truth"].shape == (8, 8, 1)
