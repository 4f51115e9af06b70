"""What a command cannot use: the sentence of tests/data/wrong-commands.txt, exit code 2, and nothing written."""

import os
import shlex
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import camsim
from camsim.cli.app import app

from .conftest import SCENE

TABLE = Path(__file__).parents[1] / "data" / "wrong-commands.txt"
FILES = {
    "small.yaml": SCENE,
    "set.yaml": "camsim: dataset/1\nscene: [photos/no 0.jpg]\ncrops: {rows: 4, cols: 4}\n",
    "study.yaml": "camsim: study/1\nscene: photos/no 1.jpg\nvary: {exposure.iso: [200, 400]}\n",
    "globs.yaml": "camsim: dataset/1\nscene: flat-field\ncrops: {rows: 4, cols: 4}\n"
    'vary: {scene.shapes.0.file: {glob: "photos/*.png"}}\n',
    "cut.png": "\x89PNG\r\n",
    "a.webp": "RIFF",
    "a.NEF": "MM\0*",
    "file": "",
}


def cases() -> Iterator[tuple[str, str, bool]]:
    """Yield a command, what is said to it, and whether that is one sentence."""
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            one_line = line == "# one sentence"
        else:
            command, _, said = line.partition(" | ")
            yield command, said, one_line


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with everything that the commands name."""
    desk = tmp_path_factory.mktemp("desk")
    for name, text in FILES.items():
        (desk / name).write_bytes(text.encode("latin-1"))
    for folder in ("photos", "sub", "none"):
        (desk / folder).mkdir()
    for number in range(2):
        Image.new("RGB", (120, 80)).save(desk / f"photos/no {number}.jpg")
    random = np.random.default_rng(1)
    truth = random.random((60, 64, 3), np.float32)
    arrays = {
        "flat": np.full((48, 48), 900, np.uint16),
        "grey": np.full((200, 300), 900, np.uint16),
        "mean": np.ones((4, 4)),
        "truth": truth,
        "eight": np.rint(255 * truth).astype(np.uint8),
        "twelve": np.rint(4095 * truth / truth.max()).astype(np.uint16),
        "electrons": 2e4 * truth / truth.max(),
        "plane": truth[..., 0],
        "nan": np.where(truth == truth[30, 30, 1], np.nan, truth),
    }
    for name, array in arrays.items():
        np.save(desk / f"{name}.npy", array)
    edge = camsim.capture("knife-edge", overrides=["region={rows: 64, cols: 60}"], products=("mosaic", "preview"))
    for name in ("edge.dng", "edge.tiff", "edge.npy", "look.png"):
        edge.save(desk / name)
    return desk


@pytest.mark.parametrize(("command", "said", "one_line"), list(cases()))
def test_it_is_refused(command: str, said: str, one_line: bool, desk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(desk)
    monkeypatch.delenv("CAMSIM_PATH", raising=False)
    before = sorted(os.walk("."))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        done = CliRunner().invoke(app, shlex.split(command), terminal_width=200)
    assert (done.exit_code, done.stdout) == (2, ""), (done.output, done.exception)
    assert said in " ".join(done.stderr.replace("│", " ").split())
    assert not one_line or len(done.stderr.splitlines()) == 1, done.stderr
    assert sorted(os.walk(".")) == before
