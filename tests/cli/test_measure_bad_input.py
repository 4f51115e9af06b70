"""What no ``camsim measure`` command can use: one sentence, exit 2, and nothing written."""

import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

from camsim.cli.app import app
from camsim.files import png

OUT = ("--csv", "out.csv", "--plot", "out.svg")
COMMANDS = {
    "mtf": ("mtf", "{bad}", *OUT),
    "star": ("star", "{bad}", *OUT),
    "texture": ("texture", "{bad}", *OUT),
    "colour": ("colour", "{bad}", *OUT, "--picture", "out.png"),
    "distortion": ("distortion", "{bad}", *OUT),
    "moire": ("moire", "{bad}", *OUT),
    "truth": ("truth", "{bad}", "-o", "out.npy"),
    "demosaic's truth": ("demosaic", "{bad}", "good.npy", *OUT, "--html", "out.html"),
    "demosaic's result": ("demosaic", "good.npy", "{bad}", *OUT, "--html", "out.html"),
    "noise": ("noise", "{bad}", *OUT, "--xml", "out.xml"),
}
BAD = {
    "missing.dng": None,
    "empty.npy": b"",
    "empty.dng": b"",
    "torn.dng": b"II*\0\x08\0\0\0\x05\0",
    "words.tiff": b"this is no picture\n" * 9,
    "words.exr": b"this is no picture\n" * 9,
    "words.png": b"this is no picture\n" * 9,
    "camera.nef": b"II*\0" * 9,
    "no suffix": b"x",
    "folder.dng": "folder",
    "eight.png": lambda: png.plain(np.full((40, 40, 3), 90, np.uint8)),
    "nan.npy": lambda: np.full((40, 40, 3), np.nan, np.float32),
    "tiny.npy": lambda: np.ones((3, 3, 3), np.float32),
    "words.npy": lambda: np.array([["a", "b"]]),
    "vector.npy": lambda: np.arange(9.0),
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("good.npy", np.random.default_rng(1).random((56, 56, 3), np.float32))
    for name, content in BAD.items():
        if content is None:
            continue
        made = content() if callable(content) else content
        if isinstance(made, str):
            (tmp_path / name).mkdir()
        elif isinstance(made, bytes):
            (tmp_path / name).write_bytes(made)
        else:
            np.save(name, made)
    return tmp_path


def refused(*words):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        done = CliRunner().invoke(app, ["measure", *words])
    assert done.exit_code == 2, (words, done.output, done.exception)
    said = done.stderr.strip().splitlines()
    assert len(said) == 1, (words, done.stderr)
    assert done.stdout == ""
    return said[0]


@pytest.mark.parametrize("command", list(COMMANDS))
def test_files_that_cannot_be_measured_are_refused_by_name(here, command):
    for name in BAD:
        said = refused(*(word.format(bad=name) for word in COMMANDS[command]))
        assert name in said, said
    assert not list(here.glob("out.*"))
