"""DNGs of lossless JPEG: the codes come back exactly, from other people's decoders."""

import sys
from pathlib import Path

import numpy as np
import pytest
import rawpy
import tifffile

from camsim.camera.frame import Frame
from camsim.errors import OutputError
from camsim.files import save
from camsim.files.reading import read_file
from tests.files.conftest import X_TRANS, MakeFrame


# Around the sizes at which tiles are full: 128 rows, multiples of 32 columns.
@pytest.mark.parametrize(
    ("size", "pattern"),
    [
        *[((48, 66), "RG GB"), ((128, 64), "GB RG"), ((129, 65), "RG GB"), ((127, 63), "GB RG"), ((300, 33), "RG GB")],
        *[((129, 65), X_TRANS), ((48, 66), "Y"), ((127, 63), "Y"), ((256, 800), "Y")],
    ],
)
def test_the_codes_come_back(tmp_path: Path, make_frame: MakeFrame, size: tuple[int, int], pattern: str) -> None:
    frame = make_frame(*size, pattern)
    save(frame, tmp_path / "a.dng", compress=True)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, frame.mosaic)
    with tifffile.TiffFile(tmp_path / "a.dng") as file:
        assert file.pages.first.compression == 7
    held = read_file(tmp_path / "a.dng")
    assert (held.compressed, held.rows, held.cols) == (True, *size)


@pytest.mark.parametrize("codes", ["noise", "zero", "largest"])
def test_any_16_bits_come_back(tmp_path: Path, make_frame: MakeFrame, codes: str) -> None:
    frame = make_frame(200, 300, bit_depth=16, black_level_dn=0, white_level_dn=65535)
    drawn = np.random.default_rng(1).integers(0, 65536, frame.mosaic.shape).astype(np.uint16)
    frame.mosaic[:] = {"noise": drawn, "zero": 0, "largest": 65535}[codes]
    save(frame, tmp_path / "a.dng", compress=True)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, frame.mosaic)


def test_the_truth_comes_back(tmp_path: Path, make_frame: MakeFrame) -> None:
    frame = make_frame(300, 200)
    for name, compress in (("a.dng", True), ("b.dng", False)):
        save(frame, tmp_path / name, product="truth", compress=compress)
    with rawpy.imread(str(tmp_path / "a.dng")) as one, rawpy.imread(str(tmp_path / "b.dng")) as other:
        np.testing.assert_array_equal(one.raw_image_visible[:, :, :3], other.raw_image_visible[:, :, :3])


def test_it_is_smaller_and_the_same_each_time(tmp_path: Path, make_frame: MakeFrame) -> None:
    frame = make_frame(400, 600)
    save(frame, tmp_path / "plain.dng")
    for name in ("a.dng", "b.dng"):
        save(frame, tmp_path / name, compress=True)
    assert (tmp_path / "a.dng").read_bytes() == (tmp_path / "b.dng").read_bytes()
    assert (tmp_path / "a.dng").stat().st_size < 0.8 * (tmp_path / "plain.dng").stat().st_size


def test_without_the_library_the_message_says_which(
    tmp_path: Path, frame: Frame, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imagecodecs", None)
    with pytest.raises(OutputError, match=r"needs the package imagecodecs: .*camsim-spectral\[compress\]"):
        save(frame, tmp_path / "a.dng", compress=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("pattern", "components"), [("RG GB", 2), ("Y", 1)])
def test_a_bayer_mosaic_is_two_components_side_by_side(
    tmp_path: Path, make_frame: MakeFrame, pattern: str, components: int
) -> None:
    """As cameras write it: red beside green predicts better from two to the left. Told by the frame header, SOF3."""
    save(make_frame(pattern=pattern), tmp_path / "a.dng", compress=True)
    content = (tmp_path / "a.dng").read_bytes()
    header = content[content.index(b"\xff\xd8\xff") :]
    assert header[header.index(b"\xff\xc3") + 9] == components
