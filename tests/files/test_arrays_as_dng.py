"""Anyone's array as a DNG: read back by LibRaw, developed as a capture's file is, refused in one sentence."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rawpy

import camsim
from camsim.files import preview
from camsim.measure import read_picture
from camsim.sensor.colour_matrix import as_shot_neutral, fit
from tests.files.conftest import MakeFrame

CODES = np.arange(48 * 66).reshape(48, 66)


@pytest.mark.parametrize(
    ("cfa", "dtype", "white_dn"),
    [("RGGB", np.uint8, 255), ("BGGR", np.uint16, 1023), ("GRBG", np.int64, 65535), ("GBRG", np.uint16, 4095)],
)
def test_libraw_reads_the_codes_and_levels(tmp_path: Path, cfa: str, dtype: type, white_dn: int) -> None:
    codes = np.random.default_rng(4).integers(0, white_dn + 1, (49, 66)).astype(dtype)
    camsim.write_dng(tmp_path / "a.dng", codes, cfa, black_level_dn=16, white_level_dn=white_dn)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, codes)
        assert raw.black_level_per_channel == [16] * 4
        assert raw.white_level == white_dn
        colours = np.where(raw.raw_colors_visible == 3, 1, raw.raw_colors_visible)[:2, :2]
        assert "".join("RGB"[k] for k in colours.ravel()) == cfa


@pytest.mark.parametrize("compress", [False, True])
def test_an_array_of_three_colours_is_a_linear_dng(tmp_path: Path, compress: bool) -> None:
    codes = np.random.default_rng(4).integers(0, 4096, (49, 66, 3)).astype(np.uint16)
    camsim.write_dng(tmp_path / "a.dng", codes, black_level_dn=16, white_level_dn=4095, compress=compress)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible[:, :, :3], codes)
    planes = read_picture(tmp_path / "a.dng").planes
    assert [(plane.name, plane.black, plane.white) for plane in planes] == [(c, 16.0, 4095.0) for c in "RGB"]
    np.testing.assert_array_equal(np.stack([plane.samples for plane in planes], axis=2), codes)


@pytest.mark.parametrize("cfa", ["x-trans", "mono"])
def test_libraw_reads_other_arrays(tmp_path: Path, cfa: str) -> None:
    codes = np.random.default_rng(4).integers(0, 4096, (516, 600)).astype(np.uint16)
    camsim.write_dng(tmp_path / "a.dng", codes, cfa, white_level_dn=4095, compress=True)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, codes)


def test_an_array_develops_as_the_capture_that_it_came_from(tmp_path: Path, make_frame: MakeFrame) -> None:
    """By LibRaw from both files, and by ``develop`` as by the preview."""
    frame = make_frame(pattern="GB RG")
    said: dict[str, Any] = {
        "cfa": "GBRG",
        "black_level_dn": 128,
        "white_level_dn": 4023,
        "colour_matrix": 3.0 * fit(frame.colour, "D65").xyz_to_camera,
        "as_shot_neutral": 2.0 * as_shot_neutral(frame.colour),
    }
    np.testing.assert_array_equal(camsim.develop(frame.mosaic, **said), preview.develop(frame))
    camsim.write_dng(tmp_path / "array.dng", frame.mosaic, **said)
    camsim.save(frame, tmp_path / "frame.dng")
    developed = []
    for name in ("array", "frame"):
        with rawpy.imread(str(tmp_path / f"{name}.dng")) as raw:
            developed.append(raw.postprocess(use_camera_wb=True, no_auto_bright=True, output_bps=16) / 65535)
    assert np.abs(developed[0] - developed[1]).max() < 2e-4


@pytest.mark.parametrize("blacks", [[[0, 1000], [1000, 0]], [[1000, 0], [0, 1000]], [[0, 200], [200, 200]]])
def test_black_levels_that_differ_leave_grey_grey_and_white_white(blacks: list[list[int]]) -> None:
    """Whichever comes first; of the largest is the span, as in DNG: 0.25 of it is code 137 of sRGB."""
    levels = np.tile(blacks, (8, 8))
    for codes, expected in ((np.full((16, 16), 4095), 255), (levels + (4095 - levels.max()) // 4, 137)):
        pixels = camsim.develop(codes, black_level_dn=blacks, white_level_dn=4095)
        assert np.unique(pixels).tolist() == [expected]


def test_an_array_of_srgb_is_seen_as_it_is(tmp_path: Path) -> None:
    """Without a matrix the channels are linear sRGB's: LibRaw gives the flat colour back."""
    colour = np.array([0.7, 0.4, 0.2])
    index = camsim.Cfa.bayer("RGGB").channel_index(48, 66)
    camsim.write_dng(tmp_path / "a.dng", np.rint(16383 * colour[index]).astype(np.uint16), white_level_dn=16383)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        linear = raw.postprocess(use_camera_wb=True, no_auto_bright=True, output_bps=16, gamma=(1, 1)) / 65535
    np.testing.assert_allclose(linear[8:-8, 8:-8].mean(axis=(0, 1)), colour, atol=1e-3)


def test_equal_arrays_give_equal_bytes(tmp_path: Path) -> None:
    for name in ("a.dng", "b.dng"):
        camsim.write_dng(tmp_path / name, CODES, white_level_dn=4095)
    assert (tmp_path / "a.dng").read_bytes() == (tmp_path / "b.dng").read_bytes()
