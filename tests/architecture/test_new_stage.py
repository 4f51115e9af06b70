"""How much a new noise stage touches: one is put into a copy of the project, and nothing else there knows of it."""

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OWN_FILE = "camsim/sensor/stages/row_noise.py"
"""Of the stage that the new one is like."""

LAW = """LAWS["popcorn"] = Law(
    stage=camsim.Popcorn(3.0), idle=camsim.Popcorn(0.0), variance=lambda m: 3.0**2, each="row", adds=True
)
"""
CAPTURE = """
import camsim
frame = camsim.capture(
    "flat-field", overrides=["sensor.readout.popcorn_e=500", "region={rows: 70, cols: 9}", "noise.seed=3"]
)
camsim.save(frame, "popcorn.dng")
assert "Popcorn(sigma_e=500.0)" in frame.report.electronics, frame.report.electronics
assert frame.read_noise_e > 500.0
quiet = camsim.capture("flat-field", overrides=["region={rows: 70, cols: 9}", "noise.seed=3"])
assert frame.report.work["random_numbers"] == quiet.report.work["random_numbers"] + 70
off_e = frame.electrons - quiet.electrons
assert 400.0 < off_e.std() < 600.0 and abs(off_e - off_e[:, :1]).max() < 1e-9
"""


def renamed(text):
    return text.replace("RowNoise", "Popcorn").replace("row_noise", "popcorn").replace("row noise", "popcorn")


def with_twins(text):
    """Return a file in which everything that is said of row noise is said of popcorn too."""
    lines = text.splitlines(keepends=True)
    spans = {
        (node.lineno, node.end_lineno)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.stmt) and node.end_lineno - node.lineno < 5
    }
    named = {number for number, line in enumerate(lines, 1) if re.search("RowNoise|row_noise", line)}
    # The short statement around a line; of a long one (a dictionary) the line alone.
    blocks = {
        min((span for span in spans if span[0] <= number <= span[1]), key=lambda s: s[1] - s[0], default=(number,) * 2)
        for number in named
    }
    for first, last in sorted(blocks, reverse=True):
        lines.insert(last, renamed("".join(lines[first - 1 : last])))
    return "".join(lines)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The project with a new stage, and which files of the package that took."""
    folder = tmp_path_factory.mktemp("project")
    for part in ("camsim", "sensors", "scenes"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "tests").mkdir()
    for name in ("conftest.py", "electronics.py", "tolerances.py", "properties/test_electronic_stages.py"):
        shutil.copy(ROOT / "tests" / name, folder / "tests")
    touched = []
    for path in sorted(folder.glob("camsim/**/*.py*")):
        text, place = path.read_text(encoding="utf-8"), str(path.relative_to(folder))
        if place == OWN_FILE:
            new = path.with_name("popcorn.py")
            new.write_text(renamed(text).replace("stream: ClassVar = 7", "stream: ClassVar = 99"), encoding="utf-8")
            touched.append(str(new.relative_to(folder)))
        elif re.search("RowNoise|row_noise", text) and "calibrate" not in place:  # which tells what it can tell
            path.write_text(with_twins(text), encoding="utf-8")
            touched.append(place)
    laws = folder / "tests" / "electronics.py"
    laws.write_text(laws.read_text(encoding="utf-8").replace("OWN = {", LAW + "OWN = {"), encoding="utf-8")
    return folder, touched


def run(folder, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    ran = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


def test_it_takes_the_files_that_the_page_names(copy):
    _, touched = copy
    assert touched == [
        "camsim/__init__.pyi",
        "camsim/config/schema/electronics.py",
        "camsim/sensor/electronics.py",
        "camsim/sensor/stages/popcorn.py",
    ]
    page = (ROOT / "docs" / "developers.md").read_text(encoding="utf-8")
    (row,) = re.findall(r"\| noise stage \| (\d+) \|", page)
    assert int(row) == len(touched)


def test_it_takes_part_in_every_law(copy):
    folder, _ = copy
    stated = run(folder, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests", "-k", "popcorn or every or additive")
    assert int(re.search(r"(\d+) passed", stated)[1]) > 25


def test_it_runs_from_yaml_and_is_taken_again(copy):
    folder, _ = copy
    run(folder, "-c", CAPTURE)
    run(folder, "-m", "camsim", "recapture", "popcorn.dng", "-o", "again.dng")
    assert (folder / "again.dng").read_bytes() == (folder / "popcorn.dng").read_bytes()
