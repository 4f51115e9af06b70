"""Moiré of a photographed zone plate: drawn by NumPy behind a Gaussian blur, whose rings have a closed form."""

import json
from pathlib import Path

import numpy as np
import pytest
import rawpy
from maker_files import Tags, mosaic_tags, tiff_raw

import camsim
from camsim.cli.app import app
from camsim.errors import UnsupportedError
from camsim.measure import Picture, picture_of_frame
from camsim.measure.picture import mosaic_planes
from camsim.measure.target import measure_moire, measure_plate

ROWS, COLS, GROWTH, MIDDLE = 740, 820, 0.0019, (361.3, 405.6)
BLACK, WHITE = 512, 16383
SIGMA = (0.62, 0.55, 0.7)
"""Of the blur of R, G and B, pixels."""


def rings(square: np.ndarray, sigma: float, *, hard: bool) -> np.ndarray:
    """Gaussian blur of cos(πk·r² + 0.7), or of the first two harmonics of hard rings: chirps stay chirps."""
    out = np.zeros_like(square)
    for order, amplitude in ((1, 1.0), (3, -1.0 / 3.0)) if hard else ((1, 1.0),):
        a = np.pi * GROWTH * order
        spread = 1.0 - 2j * a * sigma**2
        out += amplitude * np.real(np.exp(1j * (a * square / spread + 0.7 * order)) / spread)
    return out


def photographed(*, askew: float = 0.004, noise: float = 0.006, hard: bool = False, seed: int = 1) -> np.ndarray:
    """Codes of a Bayer array: a plate seen a little askew, in light that falls off to one side."""
    y, x = np.mgrid[0:ROWS, 0:COLS].astype(float)
    dy, dx = y - MIDDLE[0], x - MIDDLE[1]
    square = dy**2 * (1 + askew) + dx**2 * (1 - askew) + askew * dx * dy
    channel = np.array([[0, 1], [1, 2]])[(y % 2).astype(int), (x % 2).astype(int)]
    light = np.choose(channel, [0.4 * (1.0 + 0.7 * rings(square, sigma, hard=hard)) for sigma in SIGMA])
    light = light * (1.0 - 0.1 * x / COLS)
    light += noise * np.random.default_rng(seed).standard_normal(light.shape)
    return np.clip(np.rint(BLACK + 15000 * light), 0, WHITE).astype(np.uint16)


def picture_of(codes: np.ndarray) -> Picture:
    return Picture(name="plate", shape=codes.shape, planes=mosaic_planes(codes, ("RG", "GB"), black=BLACK, white=WHITE))


@pytest.mark.parametrize(("askew", "hard"), [(0.0, False), (0.004, True)])
def test_ghosts_have_the_transfer_at_their_sampling_frequency(askew: float, hard: bool) -> None:
    report = measure_plate(picture_of(photographed(askew=askew, hard=hard)))
    assert report.middle_pixel == pytest.approx((MIDDLE[1] + 0.5, MIDDLE[0] + 0.5), abs=0.02)
    assert len(report.ghosts) == 16
    for ghost in report.ghosts:
        sigma = SIGMA["RGB".index(ghost.channel[0])]
        want = np.exp(-2.0 * (np.pi * sigma * 0.5) ** 2)
        assert abs(ghost.contrast - want) < 4.5 * ghost.contrast_error
        assert ghost.contrast_error < 0.01
        assert np.hypot(ghost.x_pixel, ghost.y_pixel) == pytest.approx(0.5 / GROWTH, rel=0.006)


def test_a_shipped_camera_measures_as_with_its_scene() -> None:
    """Behind lens, filters and photosites of camsim, with noise: what its own measurement tells with all known."""
    plate = "scene.shapes=[{kind: chart, name: zone-plate, radius: 150, rim_period: 1.5, dark: 0.1}]"
    changes = [plate, "region={rows: 310, cols: 310}", "render.tolerance=2e-3", "sensor.olpf=null"]
    capture = camsim.load("zone-plate", sensor="d40-like", overrides=changes)
    picture = picture_of_frame(capture.frame())
    known, found = measure_moire(picture, capture), measure_plate(picture, rim_pixel=150.0)
    assert [ghost.channel for ghost in found.ghosts] == [ghost.channel for ghost in known.ghosts]
    for one, other in zip(known.ghosts, found.ghosts, strict=True):
        assert other.x_pixel == pytest.approx(one.x_pixel, abs=0.3)
        assert other.y_pixel == pytest.approx(one.y_pixel, abs=0.3)
        assert abs(other.contrast - one.contrast) < 0.015 + 4.0 * np.hypot(one.contrast_error, other.contrast_error)


def test_the_rim_leaves_ghosts_beyond_it_out() -> None:
    with pytest.raises(UnsupportedError, match=r"plate: the rings are as fine as the lattice of R 263.* px from their"):
        measure_plate(picture_of(photographed(noise=0.0)), rim_pixel=200.0)


def test_what_shows_no_plate_is_refused() -> None:
    codes = np.random.default_rng(1).integers(600, 4000, (200, 300)).astype(np.uint16)
    with pytest.raises(UnsupportedError, match="channel R shows no rings of a zone plate about the picture's middle"):
        measure_plate(picture_of(codes))
    with pytest.raises(UnsupportedError, match="channel R is clipped; expose less"):
        measure_plate(picture_of(np.minimum(photographed(noise=0.0), 9500) + np.uint16(WHITE - 9500)))


def test_the_command_measures_anybodys_raw_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    codes = photographed()
    levels: Tags = {50714: ("I", BLACK), 50717: ("I", WHITE)}
    tiff_raw(
        tmp_path / "plate.dng", codes.astype("<u2").tobytes(), {**mosaic_tags(codes, 16), **levels}, make="Acme",
        model="One", first={254: ("I", 1), 50706: ("B", bytes((1, 4, 0, 0)))},
    )  # fmt: skip
    with rawpy.imread(str(tmp_path / "plate.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, codes)
    words = ["measure", "moire", str(tmp_path / "plate.dng"), "--plot", str(tmp_path / "plate.svg")]
    assert not app([*words, "--json"], standalone_mode=False)
    stated = json.loads(capsys.readouterr().out)
    assert stated["moire"]["G1"] == pytest.approx(np.exp(-2.0 * (np.pi * 0.55 * 0.5) ** 2), abs=0.005)
    assert stated["ghosts"][0]["theory"] is None
    assert (tmp_path / "plate.svg").stat().st_size > 1000
    assert not app([*words, "--force", "--rim", "400"], standalone_mode=False)
    assert "taken to reach 400 px from there (--rim)" in capsys.readouterr().out
