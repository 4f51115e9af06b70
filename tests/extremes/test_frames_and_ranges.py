"""Frames of one photosite or one row, windows in corners, and numbers from very small to very large."""

import numpy as np
import pytest
from examples import (
    OPTICS,
    PICTURE,
    PITCH_UM,
    TOLERANCE,
    image_of,
    moved,
    scene_of,
    worst,
)
from tolerances import METHOD

import camsim


@pytest.fixture(scope="module")
def whole():
    return image_of(PICTURE, OPTICS["f/8, OLPF"], 300, 300)


@pytest.mark.parametrize(("rows", "cols"), [(1, 2), (1, 300), (300, 1), (65, 63)])
def test_small_and_narrow_frames(whole, rows, cols):
    """The middle of a large frame; an odd size has its middle on a photosite, so there the scene is moved by half."""
    shift = (0.5 * (cols % 2), 0.5 * (rows % 2))
    image = image_of(moved(PICTURE, shift=np.negative(shift)), OPTICS["f/8, OLPF"], rows, cols)
    row, col = 150 - rows // 2, 150 - cols // 2
    expected = whole[row : row + rows, col : col + cols]
    assert image.shape == (rows, cols)
    assert worst(image, expected) <= METHOD * TOLERANCE


CAMERA = camsim.Camera(
    rows=131,
    cols=170,
    pitch_um=PITCH_UM,
    lens=camsim.Airy(f_number=5.6),
    olpf=camsim.FourSpotOlpf(split_um=3.0),
    photosite=camsim.SquarePhotosite(side_um=PITCH_UM),
    cfa=camsim.Cfa.bayer("GRBG"),
    quantum_efficiency=camsim.QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.4),
    adc=camsim.Adc(bit_depth=12, black_level_dn=64, electrons_per_dn=5.0, base_iso=100.0),
)


def exposed(region=None):
    return CAMERA.expose(
        scene_of(moved(PICTURE, np.eye(2) * 9.0)),
        light=camsim.Light("D55", illuminance_lux=3000.0),
        exposure=camsim.Exposure(time_s=0.02, iso=100.0),
        region=region,
        tolerance=1e-5,
        noise=False,
    )


@pytest.fixture(scope="module")
def full_frame():
    return exposed()


@pytest.mark.parametrize(
    ("corner", "rows", "cols"), [((0, 0), 1, 1), ((0, 1), 7, 9), ((1, 0), 64, 65), ((1, 1), 131, 1)]
)
def test_a_window_in_every_corner_of_the_frame(full_frame, corner, rows, cols):
    row, col = corner[0] * (131 - rows), corner[1] * (170 - cols)
    window = exposed(camsim.Region(rows=rows, cols=cols, origin=(row, col)))
    part = np.s_[row : row + rows, col : col + cols]
    np.testing.assert_array_equal(window.channel_index, full_frame.channel_index[part])
    scale = full_frame.mean_electrons.max()
    assert worst(window.mean_electrons / scale, full_frame.mean_electrons[part] / scale) <= 2 * METHOD * 1e-5
    # The window's own pattern begins with its own first photosite.
    letters = np.array(full_frame.channels)[full_frame.channel_index]
    first = letters[row : row + 2, col : col + 2]
    for r in range(first.shape[0]):
        assert "".join(first[r]) == window.cfa_pattern[r][: first.shape[1]]


def test_a_window_without_origin_is_the_middle_in_phase():
    window = exposed(camsim.Region(rows=10, cols=10))
    assert window.cfa_pattern == CAMERA.cfa.pattern
    # (131 − 10)/2 = 60.5 and (170 − 10)/2 = 80, rounded down to even.
    again = exposed(camsim.Region(rows=10, cols=10, origin=(60, 80)))
    np.testing.assert_array_equal(window.mosaic, again.mosaic)


def test_a_photosite_of_ten_pitches():
    """It is the mean of a hundred of one pitch (an image of them, averaged)."""
    lens, side = camsim.Airy(f_number=4.0), 10
    wide = image_of(PICTURE, [lens, camsim.SquarePhotosite(side_um=side * PITCH_UM)], 5, 5)
    fine = image_of(PICTURE, [lens, camsim.SquarePhotosite(side_um=PITCH_UM)], 4 + side, 4 + side)
    mean = [[fine[r : r + side, c : c + side].mean() for c in range(5)] for r in range(5)]
    assert worst(wide, mean) <= METHOD * TOLERANCE
