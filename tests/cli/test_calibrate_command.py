"""``camsim calibrate noise`` as people start it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest

from tests.tables import rows

from .conftest import run_camsim

SET = ("--set", "sensor.readout.read_noise_student_dof=4", "--set", "sensor.readout.row_noise_e=2")


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """DNGs of a shipped camera at two ISO settings, a folder of each; the camera says what it is in its records."""
    there = tmp_path_factory.mktemp("frames")
    for iso in ("200", "1600"):
        bench = ("--sensor", "d40-like", "--side", "128", "--frames", "6", "--iso", iso, "--keep", f"frames/iso{iso}")
        run_camsim(there, "measure", "noise", *bench, *SET).check_returncode()
    return there


@pytest.fixture(scope="module")
def made(frames: Path) -> CompletedProcess[str]:
    """Their profile, mine.yaml beside them: what was said of it."""
    return run_camsim(frames, "calibrate", "noise", "frames", "-o", "mine.yaml", "--plot", "mine.svg", "--name", "Mine")


@pytest.fixture
def taken(folder: Path, frames: Path, camsim: Any) -> Any:
    shutil.copytree(frames, folder, dirs_exist_ok=True)
    return camsim


def test_a_profile_from_a_folder_of_raw_files(folder: Path, made: CompletedProcess[str], taken: Any) -> None:
    assert made.returncode == 0, made.stderr
    assert "law of the read noise: student" in made.stdout
    done = taken("calibrate", "noise", "frames", "--dry-run")
    assert done.returncode == 0, done.stderr
    assert "frames of 128 × 128, RG/GB" in done.stdout
    assert {line.split()[1] for line in done.stdout.splitlines()[2:-1]} == {"flat", "dark", "clipped"}
    assert (folder / "mine.svg").read_bytes().startswith(b"<?xml")
    text = (folder / "mine.yaml").read_text(encoding="utf-8")
    assert "pitch_um: 4.88}    # rows, cols: files; pitch: the files" in text
    assert "# full_well_e: not determined: " in text
    assert taken("validate", "mine.yaml").returncode == 0
    displayed = taken("calibrate", "noise", "frames", "-o", "listed.yaml", "--hot", "hot.csv", "--json")
    assert displayed.returncode == 0
    assert (folder / "hot.csv").read_text(encoding="utf-8").startswith("row,col,e_per_s\n")
    assert 'defects: {hot: "hot.csv"}' in (folder / "listed.yaml").read_text(encoding="utf-8")
    assert taken("validate", "listed.yaml").returncode == 0
    stated = json.loads(displayed.stdout)
    assert stated["iso"] == [200.0, 1600.0]
    for name, value in {
        "electrons_per_dn at ISO 200": 10.0,
        "electrons_per_dn at ISO 1600": 1.25,
        "read_noise_e": 9.0,
    }.items():
        figure = stated["figures"][name]
        assert abs(figure["value"] - value) < 4.5 * figure["standard_error"] < 0.3 * value, name
    done = taken("expose", "frames/iso200/index.csv", "--sensor", "./mine.yaml")
    assert done.returncode == 2  # no light, but the sensor was found


@pytest.mark.usefixtures("made")
def test_the_profile_beside_the_camera(folder: Path, taken: Any) -> None:
    done = taken("calibrate", "noise", "frames", "--check", "mine.yaml", "--plot", "check.svg")
    assert done.returncode == 0, done.stderr
    assert "no test tells the profile's frames from the camera's at 1 %" in done.stdout
    assert (folder / "check.svg").exists()
    text = (folder / "mine.yaml").read_text(encoding="utf-8")
    other = "\n".join("  read_noise_e: 12" if "  read_noise_e:" in line else line for line in text.splitlines())
    (folder / "other.yaml").write_text(other + "\n", encoding="utf-8")
    stated = json.loads(taken("calibrate", "noise", "frames", "--check", "other.yaml", "--json").stdout)
    assert min(side["probability"]["variance against mean"] for side in stated) < 1e-6
    assert min(side["probability"]["quantiles of darks"] for side in stated) < 1e-6
    assert max(side["kl_nats"] for side in stated) > 0.01


@pytest.mark.parametrize(("arguments", "sentence"), rows("wrong-commands.txt", "calibrate noise"))
def test_a_mistake_is_told_and_nothing_written(folder: Path, taken: Any, arguments: str, sentence: str) -> None:
    before = sorted(folder.rglob("*"))
    done = taken("calibrate", "noise", *arguments.split())
    assert done.returncode == 2, done.stdout
    assert sentence in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert sorted(folder.rglob("*")) == before
