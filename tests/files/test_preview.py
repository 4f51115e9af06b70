"""The preview against LibRaw's development, and against what it must do exactly."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from camsim.camera.frame import Frame
from camsim.files import save
from camsim.files.preview import demosaic, develop
from tests.files.conftest import MakeFrame
from tests.libraw import developed

PATTERNS = ["RG GB", "BG GR", "GR BG", "GB RG"]


def linear(codes: np.ndarray) -> np.ndarray:
    """Undo the sRGB curve of IEC 61966-2-1."""
    values = codes / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_it_looks_like_libraws_development(tmp_path: Path, make_frame: MakeFrame, pattern: str) -> None:
    frame = make_frame(pattern=pattern)
    save(frame, tmp_path / "a.dng")
    ours, theirs = linear(develop(frame)), developed(tmp_path / "a.dng", "sRGB")
    # LibRaw fills the border by other means.
    difference = np.abs(ours - theirs)[2:-2, 2:-2]
    # Half an 8-bit step is at most 0.0045 of linear light.
    assert difference.max() < 0.006


@pytest.mark.parametrize("pattern", [*PATTERNS, "GBGGRG RGRBGB GBGGRG GRGGBG BGBRGR GRGGBG", "RRGG RRGG GGBB GGBB"])
@pytest.mark.parametrize("size", [(48, 66), (13, 17)])
def test_demosaicing_keeps_what_was_recorded_and_is_exact_on_flats(
    make_frame: MakeFrame, pattern: str, size: tuple[int, int]
) -> None:
    index = make_frame(*size, pattern).channel_index
    flat = np.array([0.2, 0.7, 0.4], dtype=np.float32)
    planes = demosaic(flat[index], index, 3)
    np.testing.assert_allclose(planes, np.broadcast_to(flat[:, None, None], planes.shape), rtol=1e-6)
    noisy = np.random.default_rng(0).random(size).astype(np.float32)
    planes = demosaic(noisy, index, 3)
    for channel in range(3):
        np.testing.assert_array_equal(planes[channel][index == channel], noisy[index == channel])


def test_bayer_demosaicing_is_exact_on_ramps_inside(make_frame: MakeFrame) -> None:
    index = make_frame().channel_index
    rows, cols = np.indices(index.shape, dtype=np.float32)
    ramp = 0.01 * rows + 0.003 * cols
    planes = demosaic(ramp, index, 3)
    np.testing.assert_allclose(planes[:, 1:-1, 1:-1], np.stack([ramp] * 3)[:, 1:-1, 1:-1], atol=1e-6)


def test_grey_is_grey_and_white_is_white(frame: Frame) -> None:
    # A flat square of the conftest's frame: what its curves sum to in its light.
    assert frame.truth is not None
    neutral = frame.truth[10, 10] / frame.truth[10, 10].max()
    for level, expected in ((0.18, 118), (1.0, 255)):
        codes = np.rint(128 + level * neutral * (4023 - 128)).astype(np.uint16)[frame.channel_index]
        pixels = develop(dataclasses.replace(frame, mosaic=codes)).astype(int)
        # 18 % is code 118 of sRGB; 12-bit rounding is worth less than one step there.
        assert np.abs(pixels - expected).max() <= 1


@pytest.mark.parametrize("offsets", [((0,),), ((0, 1000), (1000, 0)), ((1000, 0), (0, 1000)), ((-90, 20), (30, 200))])
def test_clipped_photosites_are_white_and_blacks_black(frame: Frame, offsets: tuple[tuple[int, ...], ...]) -> None:
    white = np.full_like(frame.mosaic, 4095)
    frame = dataclasses.replace(frame, black_offsets_dn=offsets)
    assert develop(dataclasses.replace(frame, mosaic=white)).min() == 255
    black = np.full_like(frame.mosaic, 128 + np.min(offsets))
    assert develop(dataclasses.replace(frame, mosaic=black)).max() == 0


def test_mono_is_grey(mono_frame: Frame) -> None:
    pixels = develop(mono_frame)
    assert pixels.shape == mono_frame.mosaic.shape
    expected = np.clip((mono_frame.mosaic - 128.0) / (4023 - 128), 0, 1)
    assert np.abs(linear(pixels) - expected).max() < 0.0046


def test_a_camera_without_colour_matrix_still_gets_a_picture(frame: Frame) -> None:
    given = frame.colour.quantum_efficiency
    alike = dataclasses.replace(given, curves=tuple((letter, given.curves[1][1]) for letter in given.channels))
    pixels = develop(dataclasses.replace(frame, colour=dataclasses.replace(frame.colour, quantum_efficiency=alike)))
    assert pixels.ndim == 2
    assert pixels[12, 24] > pixels[24, 24]
