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


@pytest.mark.parametrize(
    ("index", "sentence"),
    [
        (None, "index.csv' is missing"),
        ("", "needs the columns"),
        ("a.npy,flat,1,0.01", "has 1 levels of light"),
        ("a.npy,flat,1,0.01\na.npy,dark,0,0.01", "'a.npy' is named in line 2 already"),
        ("gone.npy,flat,1,0.01", "gone.npy"),
        ("a.npy,grey,1,0.01", "is no kind"),
        ("a.npy,flat,bright,0.01", "must be numbers"),
        ("a.npy,flat,1,0.01\nb.npy,dark,0,0.01", "or another array"),
        ("f.npy,flat,1,0.01", "holds no codes"),
        ("../good.npy,flat,1,0.01", "must be a file in this folder"),
    ],
)
def test_folders_of_flats_and_darks(here, index, sentence):
    (here / "shots").mkdir()
    np.save(here / "shots" / "a.npy", np.full((40, 40), 900, np.uint16))
    np.save(here / "shots" / "b.npy", np.full((40, 42), 900, np.uint16))
    np.save(here / "shots" / "f.npy", np.full((40, 40), 0.5, np.float32))
    if index is not None:
        (here / "shots" / "index.csv").write_text("file,kind,exposure,time_s\n" * bool(index) + index, encoding="utf-8")
    assert sentence in refused("noise", "shots", *OUT, "--xml", "out.xml")
    assert not list(here.glob("out.*"))


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("mtf", "flat.npy"), "no measurable slanted edge found"),
        (("mtf", "flat.npy", "--cfa", "XYZW"), "XYZW"),
        (("mtf", "flat.npy", "--roi", "0,0,40,40"), "no edge found"),
        (("mtf", "flat.npy", "--roi", "1,2,3"), "give row,col,rows,cols"),
        (("mtf", "flat.npy", "--gamma", "bright"), "give srgb or an exponent"),
        (("mtf", "flat.npy", "--map", "out.doc"), "a plot is one of"),
        (("demosaic", "good.npy"), "give a truth and one result or more"),
        (("demosaic", "good.npy", "flat.npy"), "R, G and B"),
        (("star", "good.npy"), "does not say what it was taken of"),
        (("colour", "good.npy", "--picture", "out.jpg"), "the picture is a .png"),
        (("noise",), "give a folder of flats and darks"),
        (("noise", "frames", "--iso", "400"), "--iso: the frames of a folder are taken"),
        (("noise", "frames", "--seed", "0"), "--seed: the frames of a folder are taken"),
        *(
            (("noise", "--sensor", "mono-345", "--side", "40", "--frames", "2", *words), sentence)
            for words, sentence in (
                (("--iso", "0"), "--iso: must be a number from 0.001 to 1e+09, not 0.0"),
                (("--iso", "-5"), "--iso: must be a number from 0.001 to 1e+09, not -5.0"),
                (("--iso", "nan"), "--iso: must be a finite number from 0.001 to 1e+09, not nan"),
                (("--iso", "1e400"), "--iso: must be a finite number from 0.001 to 1e+09, not inf"),
                (("--seed", "-1"), "--seed: must be a whole number from 0 to 2^63 − 1, not -1"),
                (("--frames", "1"), "--frames: must be a whole number from 2 to 1000, not 1"),
            )
        ),
        (("noise", "--sensor", "mono-345", "--set", "exposure.time_s=1"), "--set exposure.time_s: a photon transfer"),
        (("noise", "--sensor", "mono-345", "--set", "exposure.iso=no"), "--set exposure.iso: must be a number"),
        (("truth", "flat-field", "-o", "out.doc"), "out.doc"),
        (("truth", "no-such-scene", "-o", "out.npy"), "no-such-scene"),
    ],
)
def test_wrong_options_and_pictures(here, words, sentence):
    np.save(here / "flat.npy", np.full((48, 48), 900, np.uint16))
    assert sentence in refused(*words)
    assert not list(here.glob("out.*"))
