"""Distortion and lateral colour of a photographed dot grid: drawn by NumPy with a known law, seen askew."""

import json
from pathlib import Path

import numpy as np
import pytest

from camsim.cli.app import app
from camsim.errors import UnsupportedError
from camsim.measure import Picture
from camsim.measure.distortion import measure_grid
from camsim.measure.picture import mosaic_planes

ROWS, COLS, SPACING, RADIUS = 420, 620, 30.0, 7.0
K1, K2 = -0.06, 0.015
HALF = 0.5 * np.hypot(ROWS, COLS)


def photographed(*, bright: bool = False, noise: float = 0.004, seed: int = 2) -> Picture:
    """Dots on a plane turned by 5° and tilted, behind barrel distortion; red is 0.1 % larger than green."""
    y, x = np.mgrid[0:ROWS, 0:COLS] + 0.5
    planes = {}
    for k, larger in enumerate((1.001, 1.0, 1.0)):
        dx, dy = (x - COLS / 2) / larger, (y - ROWS / 2) / larger
        # The undistorted place of each photosite: the law solved by iteration.
        ux, uy = dx.copy(), dy.copy()
        for _ in range(20):
            r2 = (ux**2 + uy**2) / HALF**2
            bend = 1.0 + K1 * r2 + K2 * r2**2
            ux, uy = dx / bend, dy / bend
        w = 1.0 / (1.0 - 0.00012 * ux - 0.00008 * uy)
        turn = np.radians(5.0)
        gx, gy = (np.cos(turn) * ux + np.sin(turn) * uy) * w, (np.cos(turn) * uy - np.sin(turn) * ux) * w
        off = np.hypot(gx - SPACING * np.rint(gx / SPACING), gy - SPACING * np.rint(gy / SPACING))
        inside = 1.0 / (1.0 + np.exp((off - RADIUS) / 0.5))
        planes[k] = 0.1 + 0.8 * inside if bright else 0.9 - 0.8 * inside
    channel = np.array([[0, 1], [1, 2]])[(y % 2).astype(int), (x % 2).astype(int)]
    light = np.choose(channel, [planes[0], planes[1], planes[2]])
    light = light * (1.0 - 0.2 * ((x - COLS / 2) ** 2 + (y - ROWS / 2) ** 2) / HALF**2)
    light += noise * np.random.default_rng(seed).standard_normal(light.shape)
    codes = np.clip(np.rint(512 + 15000 * light), 0, 16383).astype(np.uint16)
    return Picture(
        name="grid", shape=(ROWS, COLS), planes=mosaic_planes(codes, ("RG", "GB"), black=512.0, white=16383.0)
    )


@pytest.mark.parametrize("bright", [False, True])
def test_distortion_is_told_from_perspective(bright: bool) -> None:
    report = measure_grid(photographed(bright=bright))
    green = next(channel for channel in report.channels if channel.channel == report.reference)
    assert len(green.dots) > 150
    assert report.k1 == pytest.approx(K1, abs=max(5.0 * report.k1_error, 2e-3))
    assert report.k2 == pytest.approx(K2, abs=max(5.0 * report.k2_error, 4e-3))
    farthest = max(np.hypot(dot.x_pixel - COLS / 2, dot.y_pixel - ROWS / 2) for dot in green.dots) / HALF
    assert report.largest_distortion == pytest.approx(K1 * farthest**2 + K2 * farthest**4, rel=0.1)
    assert report.rms_pixel < 0.06
    lateral = {channel.channel: channel for channel in report.channels}
    apart = [0.001 * np.hypot(dot.x_pixel - COLS / 2, dot.y_pixel - ROWS / 2) for dot in lateral["R"].dots]
    assert lateral["R"].lateral_rms_pixel == pytest.approx(np.sqrt(np.mean(np.square(apart))), abs=0.03)
    assert lateral["B"].lateral_rms_pixel < 0.06
    assert lateral[report.reference].lateral_rms_pixel is None


def test_what_shows_no_grid_is_refused() -> None:
    codes = np.random.default_rng(1).integers(600, 4000, (200, 300)).astype(np.uint16)
    picture = Picture(name="noise", shape=codes.shape, planes=mosaic_planes(codes, ("RG", "GB"), white=4095.0))
    with pytest.raises(UnsupportedError, match="noise: shows 0 dots of a grid, and 20 are needed"):
        measure_grid(picture)


def test_the_command_measures_anybodys_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = photographed()
    codes = np.zeros(picture.shape, np.uint16)
    for plane in picture.planes:
        codes[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]] = plane.samples
    np.save(tmp_path / "grid.npy", codes)
    words = ["measure", "distortion", str(tmp_path / "grid.npy"), "--cfa", "RGGB", "--plot", str(tmp_path / "grid.svg")]
    assert not app([*words, "--json"], standalone_mode=False)
    stated = json.loads(capsys.readouterr().out)
    assert stated["k1"] == pytest.approx(K1, abs=2e-3)
    assert {channel["channel"] for channel in stated["channels"]} == {"R", "G1", "G2", "B"}
    assert (tmp_path / "grid.svg").stat().st_size > 1000
    assert not app([*words, "--force"], standalone_mode=False)
    assert "dot grid, projection and radial polynomial" in capsys.readouterr().out
