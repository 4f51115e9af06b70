"""Every colour filter array: letters, mosaic, channel index and DNG tell the same, in odd windows too."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rawpy
import tifffile

import camsim
from camsim.files import save

ARRAYS: dict[str, camsim.Cfa] = {
    **{phase: camsim.Cfa.bayer(phase) for phase in ("RGGB", "BGGR", "GRBG", "GBRG")},
    "quad 2": camsim.Cfa.quad_bayer("GRBG", 2),
    "quad 4": camsim.Cfa.quad_bayer("RGGB", 4),
    **{name: camsim.Cfa.named(name) for name in ("x-trans", "rgbw", "ryyb", "cygm", "mono")},
    "letters": camsim.Cfa(("RGe", "BYR")),
}
# What each letter lets through, by the three lines of the light below.
SEES = {"R": "r", "G": "g", "B": "b", "W": "rgb", "Y": "rg", "C": "gb", "M": "rb", "e": "b"}
LINES_NM = {"r": 650.0, "g": 550.0, "b": 450.0}
ORIGINS = [(0, 0), (7, 13)]


def camera_of(cfa: camsim.Cfa) -> camsim.Camera:
    nodes = tuple(nm + d for nm in (450.0, 550.0, 650.0) for d in (-20.0, -19.0, 19.0, 20.0))

    def curve(letter: str) -> camsim.Curve:
        seen = tuple(v for line in "bgr" for v in np.multiply((0, 1, 1, 0), line in SEES[letter]))
        return camsim.Curve(nodes, seen, outside="zero")

    return camsim.Camera(
        rows=50,
        cols=60,
        pitch_um=4.0,
        lens=camsim.Airy(f_number=4.0),
        photosite=camsim.SquarePhotosite(side_um=4.0),
        cfa=cfa,
        quantum_efficiency=camsim.QuantumEfficiency(
            tuple((letter, curve(letter)) for letter in cfa.channels), per="photon", peak=0.5
        ),
        adc=camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=1.0, base_iso=100.0),
    )


def exposed(camera: camsim.Camera, **how: Any) -> camsim.Frame:
    settings: dict[str, Any] = {
        "light": camsim.Light("E", irradiance_w_per_m2=1.0),
        "exposure": camsim.Exposure(time_s="auto", iso=100.0),
        "tolerance": 1e-3,
        "noise": False,
    }
    return camera.expose(how.pop("scene", camsim.Scene(background=1.0)), **(settings | how))


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("name", ARRAYS)
def test_primaries_land_where_their_filters_are(name: str, origin: tuple[int, int]) -> None:
    cfa = ARRAYS[name]
    rows, cols = cfa.period
    region = camsim.Region(rows=17, cols=19, origin=origin)
    letters = np.array(
        [[cfa.pattern[(origin[0] + r) % rows][(origin[1] + c) % cols] for c in range(19)] for r in range(17)]
    )
    for line, line_nm in LINES_NM.items():
        sees = np.vectorize(lambda letter, line=line: line in SEES[letter])(letters)
        light = camsim.Light(line_nm=line_nm, irradiance_w_per_m2=1.0)
        frame = exposed(camera_of(cfa), light=light, region=region, exposure=camsim.Exposure(time_s=1e-3, iso=100.0))
        np.testing.assert_array_equal(frame.mosaic > 150, sees)
        np.testing.assert_array_equal(np.array(frame.channels)[frame.channel_index], letters)
        tiled = np.array([list(frame.cfa_pattern[r % rows] * 20)[:19] for r in range(17)])
        np.testing.assert_array_equal(tiled, letters)


@pytest.mark.parametrize("name", ["RGGB", "x-trans", "quad 2"])
def test_red_green_and_blue_surfaces_stay_in_their_places(name: str) -> None:
    """Three stripes, red left, green in the middle, blue right: each is bright in its own letter alone."""
    stripes = []
    for x_um, line_nm in ((-80.0, 650.0), (0.0, 550.0), (80.0, 450.0)):
        only = camsim.Curve((line_nm - 30.0, line_nm - 29.0, line_nm + 29.0, line_nm + 30.0), (0.0, 1.0, 1.0, 0.0))
        stripes.append(camsim.Rectangle(width_um=80.0, height_um=900.0, centre_um=(x_um, 0.0), reflectance=only))
    frame = exposed(camera_of(ARRAYS[name]), scene=camsim.Scene(background=0.0, shapes=stripes))
    signal = frame.mosaic.astype(float) - 100.0
    for stripe, letter in enumerate("RGB"):
        columns = np.zeros(signal.shape, dtype=bool)
        columns[:, 20 * stripe + 4 : 20 * stripe + 16] = True
        one = frame.channel_index == frame.channels.index(letter)
        assert signal[columns & one].min() > 10.0 * signal[columns & ~one].max()


@pytest.mark.parametrize("name", ["RGGB", "GBRG", "x-trans", "quad 2"])
def test_the_dng_tells_the_same(name: str, tmp_path: Path) -> None:
    frame = exposed(camera_of(ARRAYS[name]), region=camsim.Region(rows=24, cols=30, origin=(22, 9)))
    path = tmp_path / "array.dng"
    save(frame, path, allow_odd_cfa=True)
    with tifffile.TiffFile(path) as file:
        tags = file.pages[0].tags
        rows, cols = tags[33421].value
        codes = np.frombuffer(bytes(tags[33422].value), dtype=np.uint8).reshape(rows, cols)
        np.testing.assert_array_equal(file.pages[0].asarray(), frame.mosaic)
    tiled = np.tile(codes, (24 // rows + 1, 30 // cols + 1))[:24, :30]
    # The codes of TIFF/EP: 0 red, 1 green, 2 blue, as ours.
    np.testing.assert_array_equal(tiled, frame.channel_index)
    if len(name) == 4:
        with rawpy.imread(str(path)) as raw:
            # LibRaw calls the second green 3.
            np.testing.assert_array_equal(np.where(raw.raw_colors == 3, 1, raw.raw_colors), frame.channel_index)
