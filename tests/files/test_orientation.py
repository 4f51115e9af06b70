"""The L of three squares comes out the same way round, with its red square red, in every file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image

from camsim.camera.frame import Frame
from camsim.files import save

PHASES = ["RG GB", "BG GR", "GR BG", "GB RG"]


def eight_ways(image: np.ndarray) -> list[np.ndarray]:
    """Return the image, then its three turns and four mirror images."""
    return [np.rot90(each, k) for each in (image, image[:, ::-1]) for k in range(4)]


def assert_upright(found: np.ndarray, truth: np.ndarray) -> None:
    """The picture is nearest to the truth as it is; turned or mirrored it is far off."""
    scaled = np.minimum(truth, 38950)
    misfits = [np.abs(found - way).mean() if way.shape == found.shape else np.inf for way in eight_ways(scaled)]
    assert np.argmin(misfits) == 0
    assert misfits[0] < 0.5 * min(misfits[1:])


# Square, so that a turned picture has the right shape; and oblong.
@pytest.fixture(params=[(36, 36), (36, 54)], ids=["square", "oblong"])
def size(request: pytest.FixtureRequest) -> tuple[int, int]:
    return request.param


@pytest.mark.parametrize("pattern", PHASES)
def test_dng_as_developed(
    tmp_path: Path,
    make_frame: Callable[..., Frame],
    develop_with_rawpy: Callable[[Path], np.ndarray],
    pattern: str,
    size: tuple[int, int],
) -> None:
    frame = make_frame(*size, pattern)
    save(frame, tmp_path / "a.dng")
    assert_colours(develop_with_rawpy(tmp_path / "a.dng"), size)


@pytest.mark.parametrize("pattern", PHASES)
def test_png_preview(tmp_path: Path, make_frame: Callable[..., Frame], pattern: str, size: tuple[int, int]) -> None:
    save(make_frame(*size, pattern), tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert_colours((np.asarray(image) / 255.0) ** 2.2, size)


def assert_colours(linear: np.ndarray, size: tuple[int, int]) -> None:
    """White corner and right arm, a red lower arm, dark elsewhere."""
    assert linear.shape == (*size, 3)
    corner, right, lower = linear[9:15, 9:15], linear[9:15, 21:27], linear[21:27, 9:15]
    dark = linear[21:27, 21:27]
    assert corner.mean(axis=(0, 1)).min() > 2.5 * dark.mean()
    assert right.mean() > 1.5 * corner.mean()
    red, green, blue = lower.mean(axis=(0, 1))
    assert red > 4 * max(green, blue)


@pytest.mark.parametrize("pattern", ["RG GB", "Y"])
def test_exr_tiff_png_and_npy(
    tmp_path: Path, make_frame: Callable[..., Frame], pattern: str, size: tuple[int, int]
) -> None:
    frame = make_frame(*size, pattern)
    truth = frame.mean_electrons

    save(frame, tmp_path / "a.exr", product="electrons")
    channels = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    assert_upright(channels["noisy.Y"].pixels, truth)

    def electrons(codes: np.ndarray) -> np.ndarray:
        return (codes.astype(float) - 128) * 10

    save(frame, tmp_path / "a.tiff")
    assert_upright(electrons(tifffile.imread(tmp_path / "a.tiff")), truth)
    save(frame, tmp_path / "a.png", product="mosaic")
    with Image.open(tmp_path / "a.png") as image:
        assert_upright(electrons(np.asarray(image)), truth)
    save(frame, tmp_path / "a.npy")
    assert_upright(electrons(np.load(tmp_path / "a.npy")), truth)


def test_exr_truth(tmp_path: Path, make_frame: Callable[..., Frame], size: tuple[int, int]) -> None:
    frame = make_frame(*size)
    save(frame, tmp_path / "a.exr")
    file = OpenEXR.File(str(tmp_path / "a.exr"))
    picture = file.channels()["RGB"].pixels
    assert picture.shape == (*size, 3)
    assert picture[24, 12, 0] == 10 * picture[24, 12, 1]
    assert picture[12, 24].min() > 40000
    header = file.header()
    np.testing.assert_array_equal(header["dataWindow"], [(0, 0), (size[1] - 1, size[0] - 1)])
