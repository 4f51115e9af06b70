"""Which way round: three squares, the lower one red, found where the scene has them, before and after developing.

What else files hold is compared with these arrays, number for number (tests/files/test_formats.py). Nothing is
compared with camsim's own idea of the picture: each array is cut into 2 × 2 cells by the pattern that the file states,
the squares are found as connected bright spots, and their centres and colours must be those of the scene. A picture
that is mirrored, turned or shifted has none of them in place.
"""

import numpy as np
import pytest
import rawpy
import zxingcpp
from PIL import Image
from scipy import ndimage

import camsim
from tests.libraw import developed

PITCH_UM = 4.88
ROWS, COLS = 60, 84
SIDE = 12
# Centres as (x, y) in pitches from the optical axis, x right and y down.
WHITE_CORNER, WHITE_ARM, RED_ARM = (-20.0, -15.0), (9.0, -15.0), (-20.0, 12.0)
RED = camsim.Curve((580.0, 600.0), (0.02, 0.9), outside="hold")

WINDOWS = {
    "frame": None,
    "window": camsim.Region(rows=44, cols=70, origin=(6, 10)),
    "odd window": camsim.Region(rows=43, cols=71, origin=(7, 9)),
}


def squares():
    def square(centre, reflectance):
        return camsim.Rectangle(
            width_um=SIDE * PITCH_UM,
            height_um=SIDE * PITCH_UM,
            centre_um=(centre[0] * PITCH_UM, centre[1] * PITCH_UM),
            reflectance=reflectance,
        )

    return camsim.Scene(
        background=0.04, shapes=[square(WHITE_CORNER, 0.8), square(WHITE_ARM, 0.8), square(RED_ARM, RED)]
    )


def camera(pattern):
    colour = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=4.0))
    return colour.replace(rows=ROWS, cols=COLS, cfa=camsim.Cfa.bayer(pattern))


@pytest.fixture(scope="module", params=WINDOWS, ids=WINDOWS)
def region(request):
    return WINDOWS[request.param]


@pytest.fixture(scope="module", params=["RGGB", "GBRG"])
def frame(request, region):
    return camera(request.param).expose(
        squares(),
        light=camsim.Light("D65", illuminance_lux=4000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        seed=3,
        region=region,
        products=("mosaic", "truth"),
        tolerance=1e-4,
    )


def expected(region):
    """(row, col) of each square's centre among the window's photosites, with its colour."""
    row0, col0 = (0, 0) if region is None else region.origin
    return sorted(
        (y + ROWS / 2 - 0.5 - row0, x + COLS / 2 - 0.5 - col0, colour)
        for (x, y), colour in ((WHITE_CORNER, "white"), (WHITE_ARM, "white"), (RED_ARM, "red"))
    )


def spots(red, green, blue, scale=1, first=(0, 0)):
    """Find bright spots in three planes: sorted (row, col, colour); ``first`` is where red's first number is from."""
    found = []
    labels, count = ndimage.label(red > 0.5 * np.quantile(red, 0.97))
    for label in range(1, count + 1):
        here = labels == label
        if np.count_nonzero(here) * scale**2 < SIDE**2 / 3:
            continue  # a grain of noise
        row, col = (axis.mean() for axis in np.nonzero(here))
        other = max(green[here].mean() / green.max(), blue[here].mean() / blue.max())
        colour = "red" if other < 0.3 * red[here].mean() / red.max() else "white"
        found.append((row * scale + first[0], col * scale + first[1], colour))
    return sorted(found)


def spots_in(mosaic, letters):
    """Find them in a mosaic cut into cells of 2 × 2; ``letters`` names every photosite."""
    rows, cols = (n // 2 * 2 for n in mosaic.shape)
    planes = []
    for letter in "RGB":
        one = (letters == letter)[:rows, :cols].reshape(rows // 2, 2, cols // 2, 2)
        values = np.where(one, mosaic[:rows, :cols].reshape(one.shape).astype(float), 0.0)
        planes.append(values.sum(axis=(1, 3)) / one.sum(axis=(1, 3)))
    return spots(*planes, scale=2, first=np.argwhere(letters[:2, :2] == "R")[0])


def assert_in_place(found, region, slack=0.75):
    assert len(found) == 3
    for row, col, colour in expected(region):
        there = min(found, key=lambda spot: np.hypot(spot[0] - row, spot[1] - col))
        assert abs(there[0] - row) <= slack
        assert abs(there[1] - col) <= slack
        assert there[2] == colour


def letters_of(frame):
    return np.array(frame.channels)[frame.channel_index]


def test_mosaic(frame, region):
    assert_in_place(spots_in(frame.mosaic - 128.0, letters_of(frame)), region)


def test_truth(frame, region):
    assert_in_place(spots(*np.moveaxis(frame.truth, 2, 0)), region, slack=0.1)


def test_dng_through_rawpy(frame, region, tmp_path):
    camsim.save(frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        assert raw.sizes.flip == 0
        letters = np.array(list(raw.color_desc.decode()))[raw.raw_colors_visible]
        mosaic = raw.raw_image_visible.astype(float) - 128.0
    assert_in_place(spots_in(mosaic, letters), region)
    picture = developed(tmp_path / "a.dng", "sRGB")
    assert picture.shape[:2] == frame.mosaic.shape
    assert_in_place(spots(*np.moveaxis(picture, 2, 0)), region)


def test_a_qr_code_is_read_off_the_developed_picture(tmp_path):
    """Turned, blurred, mosaicked, noisy and developed: by an independent reader, who does not read mirrored codes."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
    code = camsim.charts.qr(text="camsim: exact optics", width_um=100 * camera.pitch_um, rotate_deg=10.0)
    frame = camera.expose(
        camsim.Scene(background=0.4, shapes=[code]),
        light=camsim.Light(line_nm=550, illuminance_lux=2000),
        exposure=camsim.Exposure(time_s="auto", iso=400),
        region=camsim.Region(rows=128, cols=128),
        tolerance=1e-3,
        seed=1,
        products=("mosaic", "preview"),
    )
    camsim.save(frame, tmp_path / "code.png")
    with Image.open(tmp_path / "code.png") as image:
        (found,) = zxingcpp.read_barcodes(np.asarray(image.convert("L").resize((512, 512))))
    assert found.text == "camsim: exact optics"
    # Upright: its position marks are at the upper left, upper right and lower left.
    assert abs(found.orientation - 10) <= 2
