"""A file is there whole or not at all, whatever happens while it is written."""

import dataclasses
import errno
import json
import os
import pickle
import resource
import stat
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from camsim.camera.frame import Frame
from camsim.errors import InvalidValueError, OutputError
from camsim.files import SUFFIXES, save
from camsim.files.atomic import replacing, together, write_whole
from tests.files.conftest import MakeFrame

HERE = Path(__file__).parent
KILLS = 4


def test_a_kill_leaves_the_old_or_the_new_file(tmp_path: Path, make_frame: MakeFrame) -> None:
    frames = {"one": make_frame(400, 600, seed=1), "other": make_frame(400, 600, seed=2)}
    pickled = tmp_path / "frames.pickle"
    pickled.write_bytes(pickle.dumps(frames))
    folder = tmp_path / "out"
    folder.mkdir()
    ran = subprocess.run(
        [sys.executable, HERE / "interrupted.py", pickled, folder, str(KILLS)],
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
        env={**os.environ, "PYTHONPATH": str(HERE.parents[1])},
    )
    found = json.loads(ran.stdout)
    assert set(found) == set(SUFFIXES)
    states = Counter(state for each in found.values() for state in each)
    assert set(states) == {"one", "other"}, found
    assert states.total() == KILLS * len(SUFFIXES)
    # Some kills came in the middle of writing, or nothing was tested: they leave the file beside.
    assert any(path.name.endswith(".part") for path in folder.iterdir())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_cut_short_by_the_system_is_said_and_leaves_the_old_one(
    tmp_path: Path, frame: Frame, suffix: str
) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    target = folder / f"a{suffix}"
    target.write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OutputError) as caught:
            save(dataclasses.replace(frame, spectral=None), target, force=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert str(caught.value) == f"cannot write {str(target)!r}: the file would be larger than the system allows"
    assert [path.name for path in folder.iterdir()] == [target.name]
    assert target.read_text() == "old"


@pytest.mark.parametrize(
    ("suffix", "product"),
    [(suffix, product) for suffix, form in SUFFIXES.items() for product in form.writers],
)
def test_every_writer_notices_a_full_disk(make_frame: MakeFrame, suffix: str, product: str) -> None:
    for size in ((6, 6), (48, 66), (300, 300)):
        with pytest.raises(OSError, match=r"No space left") as caught:
            SUFFIXES[suffix].writers[product](make_frame(*size), Path("/dev/full"))
        assert caught.value.errno == errno.ENOSPC


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (errno.ENOSPC, "the disk is full"),
        (errno.EDQUOT, "the disk quota is used up"),
        (errno.EROFS, "the disk is mounted read-only"),
        (errno.EIO, "Input/output error"),
    ],
)
def test_the_systems_no_is_one_sentence_and_leaves_nothing(tmp_path: Path, code: int, words: str) -> None:
    target = tmp_path / "a.dng"
    target.write_text("old")

    def write() -> None:
        with replacing(target) as beside:
            beside.write_text("half")
            raise OSError(code, os.strerror(code))

    with pytest.raises(OutputError) as caught:
        write()
    assert str(caught.value) == f"cannot write {str(target)!r}: {words}"
    assert [path.name for path in tmp_path.iterdir()] == ["a.dng"]
    assert target.read_text() == "old"


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit, MemoryError, ValueError])
def test_an_interruption_leaves_nothing(tmp_path: Path, interruption: type[BaseException]) -> None:
    def write() -> None:
        with replacing(tmp_path / "a.dng") as beside:
            beside.write_text("half")
            raise interruption

    with pytest.raises(interruption):
        write()
    assert list(tmp_path.iterdir()) == []


def test_a_new_file_has_the_permissions_of_any_new_file(tmp_path: Path, frame: Frame) -> None:
    (tmp_path / "plain").touch()
    save(frame, tmp_path / "a.npy")
    ours, plain = (stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("a.npy", "plain"))
    assert ours == plain


def test_a_link_is_followed(tmp_path: Path, frame: Frame) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "a.npy").symlink_to(elsewhere / "real.npy")
    save(frame, tmp_path / "a.npy")
    assert (tmp_path / "a.npy").is_symlink()
    assert [path.name for path in elsewhere.iterdir()] == ["real.npy"]


def test_the_longest_name_can_be_written(tmp_path: Path, frame: Frame) -> None:
    for stem in ("a" * 251, "µ" * 125):
        save(frame, tmp_path / f"{stem}.npy")
        assert (tmp_path / f"{stem}.npy").is_file()


def test_files_that_belong_together_are_there_all_or_none(tmp_path: Path) -> None:
    """A command that failed at its second file left the first, and the second try said that it exists."""
    (tmp_path / "old").write_text("old")

    def write(fails: bool) -> None:
        with together():
            write_whole(tmp_path / "old", b"new")
            with together():  # a part of the command that writes several itself
                write_whole(tmp_path / "first", b"1")
            if fails:
                raise InvalidValueError("a plot that cannot be drawn")
            write_whole(tmp_path / "second", b"2")

    with pytest.raises(InvalidValueError, match="cannot be drawn"):
        write(True)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old": "old"}
    write(False)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old": "new", "first": "1", "second": "2"}
    write_whole(tmp_path / "old", b"alone")  # and what is written on its own is in its place at once
    assert (tmp_path / "old").read_text() == "alone"
