"""The ColorChecker through a raw developer: how far are its colours from what the eye would see?

The mosaic is made directly from reflectance × light × sensitivity, with the perfect diffuser at 80 % of the
range and no noise: what is left is the colour of the file, that is white balance, matrix, levels and LibRaw's
reading of them.

Reference: XYZ of each patch (CIE 1931 2°, sums every 5 nm), taken from the light's white to D65 after
Bradford, then Lab relative to D65. LibRaw gives XYZ relative to D65: its white balance makes the
diffuser D65 white.
"""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import camsim
from camsim.files import save
from tests.colorchecker import WHITE, chart, delta_e, patch_means, reference_xyz
from tests.libraw import developed

ROWS, COLS = 128, 192


# Measured: mean 0.93, largest 3.4 under D65; 1.04 and 3.7 under D55; 2.9 and 8.3 under A, because developers
# use the D65 matrix for every light.
@pytest.mark.parametrize(("light", "mean", "largest"), [("D65", 1.1, 3.8), ("D55", 1.1, 4.1), ("A", 3.2, 9.0)])
def test_colorchecker_through_libraw(tmp_path: Path, light: str, mean: float, largest: float) -> None:
    save(chart(ROWS, COLS, light=light), tmp_path / "a.dng")
    found = patch_means(developed(tmp_path / "a.dng"), ROWS, COLS)
    differences = delta_e(light, found)
    print(f"{light}: ΔE2000 mean {differences.mean():.3f}, largest {differences.max():.2f}")
    assert differences.mean() <= mean
    assert differences.max() <= largest
    # Luminance of the grey patches, with no freedom to scale: white at 80 % is Y = 0.8.
    np.testing.assert_allclose(found[18:, 1] / WHITE, reference_xyz(light)[18:, 1], rtol=0.01, atol=0.0005)


def test_a_matrix_fitted_to_the_scene_is_right_under_lamp_light(tmp_path: Path) -> None:
    """Developers know one matrix, that of D65; fitted to the scene's light and given in D65's form it serves A."""
    frame = chart(ROWS, COLS, light="A")
    fitted = dataclasses.replace(frame, colour=dataclasses.replace(frame.colour, matrix="scene"))
    save(fitted, tmp_path / "a.dng")
    differences = delta_e("A", patch_means(developed(tmp_path / "a.dng"), ROWS, COLS))
    print(f"A, scene matrix: ΔE2000 mean {differences.mean():.3f}, largest {differences.max():.2f}")
    assert differences.mean() <= 1.2
    assert differences.max() <= 5.2


def test_the_two_matrices_differ_little_in_daylight(tmp_path: Path) -> None:
    frame = chart(ROWS, COLS, light="D65")
    fitted = dataclasses.replace(frame, colour=dataclasses.replace(frame.colour, matrix="scene"))
    save(frame, tmp_path / "standard.dng")
    save(fitted, tmp_path / "scene.dng")
    one, other = (patch_means(developed(tmp_path / f"{name}.dng"), ROWS, COLS) for name in ("standard", "scene"))
    np.testing.assert_allclose(one, other, atol=2e-4)


PATCHES = [(x, y) for y in (-108, -36, 36, 108) for x in (-180, -108, -36, 36, 108, 180)]
HALF = 20  # of the 60 photosites of a patch only the middle is measured


def middles(image: np.ndarray) -> np.ndarray:
    """Means of the middles of the shipped chart's patches."""
    rows, cols = (size // 2 for size in image.shape[:2])
    cut = [image[rows + y - HALF : rows + y + HALF, cols + x - HALF : cols + x + HALF] for x, y in PATCHES]
    return np.array([patch.mean(axis=(0, 1)) for patch in cut])


@pytest.mark.parametrize("light", ["D65", "D55"])
def test_the_shipped_chart_through_camera_and_raw_developer(tmp_path: Path, light: str) -> None:
    frame = camsim.capture(
        "colorchecker", sensor="d40-like", overrides=[f"light.illuminant={light}", "noise.enabled=false"]
    )
    # exposure.time_s: auto. A perfect diffuser would stand at 80 % of black..white in the brightest channel.
    span = frame.white_level_dn - frame.black_level_dn
    white_patch = frame.mosaic[150 + 108 - HALF : 150 + 108 + HALF, 222 - 180 - HALF : 222 - 180 + HALF]
    reflectance = camsim.reflectance("white 9.5").at(np.array([530.0]))[0]
    assert (white_patch.max() - frame.black_level_dn) / span == pytest.approx(0.8 * reflectance, rel=0.01)
    save(frame, tmp_path / "chart.dng")
    assert delta_e(light, middles(developed(tmp_path / "chart.dng"))).mean() <= 1.5
