"""What a command cannot use: the sentence of tests/data/wrong-commands.txt, exit code 2, and nothing written."""

import os
import shlex
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import camsim
from camsim.cli.app import app
from camsim.files import png
from tests.tables import rows

from .conftest import SCENE

ONE, MORE = (rows("wrong-commands.txt", title) for title in ("one sentence", "more lines"))
FILES = {
    "small.yaml": SCENE,
    "list.yaml": "camsim: scene/1\nsensor: d40-like\nscene: [photos/no 0.jpg]\n",
    "set.yaml": "camsim: dataset/1\nscene: [photos/no 0.jpg]\ncrops: {rows: 4, cols: 4}\n",
    "study.yaml": "camsim: study/1\nscene: photos/no 1.jpg\nvary: {exposure.iso: [200, 400]}\n",
    "globs.yaml": "camsim: dataset/1\nscene: flat-field\ncrops: {rows: 4, cols: 4}\n"
    'vary: {scene.shapes.0.file: {glob: "photos/*.png"}}\n',
    "cut.png": "\x89PNG\r\n",
    "a.webp": "RIFF",
    "a.NEF": "MM\0*",
    "file": "",
}


OUT = "--csv out.csv --plot out.svg"
MEASURING = [
    *(f"{kind} {{}} {OUT}" for kind in ("mtf", "star", "texture", "distortion", "moire")),
    *(f"colour {{}} {OUT} --picture out.png", "truth {} -o out.npy", f"noise {{}} {OUT} --xml out.xml"),
    *(f"demosaic {{}} truth.npy {OUT} --html out.html", f"demosaic truth.npy {{}} {OUT} --html out.html"),
]
BAD: dict[str, bytes | np.ndarray | None] = {
    "missing.dng": None,
    "empty.npy": b"",
    "empty.dng": b"",
    "torn.dng": b"II*\0\x08\0\0\0\x05\0",
    **dict.fromkeys(("words.tiff", "words.exr", "words.png"), b"this is no picture\n" * 9),
    "camera.nef": b"II*\0" * 9,
    "no suffix": b"x",
    "nan of all.npy": np.full((40, 40, 3), np.nan, np.float32),
    "tiny.npy": np.ones((3, 3, 3), np.float32),
    "words.npy": np.array([["a", "b"]]),
    "vector.npy": np.arange(9.0),
}


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
    (desk / "half.dng").write_bytes((desk / "edge.dng").read_bytes()[:3000])
    for name, made in BAD.items():
        if isinstance(made, bytes):
            (desk / name).write_bytes(made)
        elif made is not None:
            np.save(desk / name, made)
    (desk / "folder.dng").mkdir()
    (desk / "eight.png").write_bytes(png.plain(np.full((40, 40, 3), 90, np.uint8)))
    return desk


@pytest.fixture
def refused(desk: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Run a command that can do nothing, and leaves nothing; return what it says."""
    monkeypatch.chdir(desk)
    monkeypatch.delenv("CAMSIM_PATH", raising=False)

    def run(command: str) -> str:
        before = sorted(os.walk("."))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            done = CliRunner().invoke(app, shlex.split(command), terminal_width=200)
        assert (done.exit_code, done.stdout) == (2, ""), (command, done.output, done.exception)
        assert sorted(os.walk(".")) == before
        return done.stderr

    return run


@pytest.mark.parametrize(("command", "said"), [*ONE, *MORE])
def test_it_is_refused(command: str, said: str, refused: Callable[[str], str]) -> None:
    stated = refused(command)
    assert said in " ".join(stated.replace("│", " ").split())
    assert [command, said] in MORE or len(stated.splitlines()) == 1, stated


@pytest.mark.parametrize("command", MEASURING)
def test_files_that_cannot_be_measured_are_refused_by_name(command: str, refused: Callable[[str], str]) -> None:
    for name in (*BAD, "folder.dng", "eight.png"):
        stated = refused("measure " + command.format(f"'{name}'"))
        assert name in stated
        assert len(stated.strip().splitlines()) == 1, (name, stated)
