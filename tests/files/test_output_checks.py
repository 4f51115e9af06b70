"""Each mistake in where or what to write has its one sentence, before any work is done."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from camsim.camera.frame import Frame
from camsim.errors import OutputError
from camsim.files import PRODUCTS, SUFFIXES, check_output, save
from camsim.rendering.cube import SpectralCube


@pytest.mark.parametrize(
    ("name", "product", "chosen"),
    [
        ("a.dng", None, "mosaic"),
        ("a.DNG", None, "mosaic"),
        ("a.exr", None, "truth"),
        ("a.exr", "electrons", "electrons"),
        ("a.tiff", None, "mosaic"),
        ("a.tif", None, "mosaic"),
        ("a.npy", None, "mosaic"),
        ("a.png", None, "preview"),
        ("a.png", "mosaic", "mosaic"),
    ],
)
def test_the_suffix_chooses_the_product(tmp_path: Path, name: str, product: str | None, chosen: str) -> None:
    assert check_output(tmp_path / name, product) == chosen
    assert check_output(str(tmp_path / name), product) == chosen


def test_every_writer_is_of_a_known_product() -> None:
    assert {product for form in SUFFIXES.values() for product in form.writers} == set(PRODUCTS)


def test_a_name_that_is_too_long(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="the name is too long"):
        check_output(tmp_path / ("a" * 300 + ".dng"))


def test_mistakes_in_the_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder.dng").mkdir()
    (tmp_path / "dangling.dng").symlink_to(tmp_path / "gone" / "a.dng")
    for name, message in (
        ("none/a.dng", f"the folder '{tmp_path}/none' does not exist; make it first"),
        ("file/a.dng", f"'{tmp_path}/file' is a file and not a folder"),
        ("folder.dng", "it is a folder"),
        ("dangling.dng", f"the folder '{tmp_path}/gone' does not exist; make it first"),
    ):
        with pytest.raises(OutputError) as caught:
            check_output(tmp_path / name)
        assert str(caught.value) == f"cannot write '{tmp_path}/{name}': {message}"


def test_a_folder_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # By the system's own answer: tests may run as root, for whom every folder can be written.
    monkeypatch.setattr("camsim.files.os.access", lambda path, mode: Path(path) != tmp_path)
    with pytest.raises(OutputError, match=f"the folder '{tmp_path}' does not allow writing"):
        check_output(tmp_path / "a.dng")


def test_a_device_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "a.dng").symlink_to("/dev/full")
    with pytest.raises(OutputError, match="it is a device and not a file"):
        check_output(tmp_path / "a.dng")


def test_truth_that_was_not_asked_for(tmp_path: Path, frame: Frame) -> None:
    bare = dataclasses.replace(frame, truth=None)
    for name in ("a.exr", "a.npy"):
        with pytest.raises(OutputError, match=r"the capture holds no truth; ask for products=\('truth',\)"):
            save(bare, tmp_path / name, product="truth")
    with pytest.raises(OutputError, match=r"no truth; ask for products=\('truth',\); it holds .*product='electrons'"):
        save(bare, tmp_path / "a.exr")
    assert list(tmp_path.iterdir()) == []
    save(bare, tmp_path / "a.exr", product="electrons")


def test_a_file_that_is_there_stays_unless_told(tmp_path: Path, frame: Frame) -> None:
    path = tmp_path / "a.tiff"
    frame.save(path)
    before = path.read_bytes()
    brighter = dataclasses.replace(frame, mosaic=frame.mosaic + 1)
    for write in (brighter.save, lambda path: save(brighter, path)):
        with pytest.raises(OutputError, match=r"a.tiff': it exists; overwrite it with force=True$"):
            write(path)
    assert path.read_bytes() == before
    brighter.save(path, force=True)
    assert path.read_bytes() != before
    brighter.save(tmp_path / "b.npy", product="electrons")
    np.testing.assert_array_equal(np.load(tmp_path / "b.npy"), frame.electrons)


def test_one_by_one_frame_can_be_saved_everywhere(tmp_path: Path, frame: Frame) -> None:
    tiny = dataclasses.replace(
        frame,
        mosaic=frame.mosaic[:1, :1],
        electrons=frame.electrons[:1, :1],
        mean_electrons=frame.mean_electrons[:1, :1],
        channel_index=frame.channel_index[:1, :1],
        truth=None if frame.truth is None else np.ascontiguousarray(frame.truth[:1, :1]),
        spectral=SpectralCube((500.0,), "W.m^-2.sr^-1", lambda k, take: take(np.ones((1, 1), np.float32)) or 0.0),
    )
    for suffix, form in SUFFIXES.items():
        for product in form.writers:
            save(tiny, tmp_path / f"a{suffix}", product=product, force=True)
            assert (tmp_path / f"a{suffix}").stat().st_size > 0
