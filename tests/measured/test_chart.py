"""The ColorChecker of the shipped scene, from YAML through the camera and a DNG to a raw developer's colours.

The colours are judged against the eye's, as in ``test_colour``; there the mosaic is made by hand, here by camsim.
"""

import numpy as np
import pytest
import rawpy

import camsim
from tests.colorchecker import delta_e

PATCHES = [(x, y) for y in (-108, -36, 36, 108) for x in (-180, -108, -36, 36, 108, 180)]
HALF = 20  # of the 60 photosites of a patch only the middle is measured


def developed_xyz(path):
    """LibRaw's linear XYZ, one triple a patch; the perfect diffuser is at 80 % of the range."""
    with rawpy.imread(str(path)) as raw:
        image = raw.postprocess(
            demosaic_algorithm=rawpy.DemosaicAlgorithm.LINEAR,
            use_camera_wb=True,
            output_color=rawpy.ColorSpace.XYZ,
            output_bps=16,
            gamma=(1, 1),
            no_auto_bright=True,
            adjust_maximum_thr=0,
        )
    rows, cols = image.shape[:2]
    means = []
    for x, y in PATCHES:
        row, col = rows // 2 + y, cols // 2 + x
        means.append(image[row - HALF : row + HALF, col - HALF : col + HALF].mean(axis=(0, 1)))
    return np.array(means) / 65535


@pytest.mark.parametrize("light", ["D65", "D55"])
def test_colours_through_a_raw_developer(tmp_path, light):
    frame = camsim.capture(
        "colorchecker", sensor="d40-like", overrides=[f"light.illuminant={light}", "noise.enabled=false"]
    )
    # exposure.time_s: auto. A perfect diffuser would stand at 80 % of black..white in the brightest channel.
    span = frame.white_level_dn - frame.black_level_dn
    white_patch = frame.mosaic[150 + 108 - HALF : 150 + 108 + HALF, 222 - 180 - HALF : 222 - 180 + HALF]
    reflectance = camsim.reflectance("white 9.5").at(np.array([530.0]))[0]
    assert (white_patch.max() - frame.black_level_dn) / span == pytest.approx(0.8 * reflectance, rel=0.01)
    camsim.save(frame, tmp_path / "chart.dng")
    differences = delta_e(light, developed_xyz(tmp_path / "chart.dng"))
    print(f"{light}: ΔE2000 mean {differences.mean():.2f}, largest {differences.max():.2f}")
    assert differences.mean() <= 1.5
