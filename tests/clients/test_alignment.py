"""The truth lies on its mosaic: where two demosaicing libraries put the picture is where the truth is, to 0.05 px.

The best shift between a demosaiced channel and the truth's is found by least squares on brightness (Lucas and
Kanade), after a blur that hides what demosaicing does to single photosites. Half a photosite, or a phase that is
wrong by one, would show as 0.5 or 1.
"""

import functools
import warnings
from pathlib import Path

import numpy as np
import pytest
import rawpy
from scipy import ndimage

import camsim
from camsim.camera.frame import Frame
from tests.libraw import developed

pytestmark = pytest.mark.clients

SIDE = 120
WITHIN_PX = 0.05
PHASES = ("RGGB", "BGGR", "GRBG", "GBRG")


def rings(pitch_um: float) -> camsim.Scene:
    """Return rings that get narrower outwards, as on a zone plate, off the centre."""
    radii = [52.0 * (k / 8) ** 0.5 for k in range(8, 0, -1)]
    discs = [
        camsim.Disc(
            radius_um=r * pitch_um, centre_um=(3.3 * pitch_um, -2.1 * pitch_um), reflectance=0.1 + 0.7 * (k % 2)
        )
        for k, r in enumerate(radii)
    ]
    return camsim.Scene(background=0.5, shapes=discs)


def slanted(pitch_um: float) -> camsim.Scene:
    shape = camsim.Rectangle(
        width_um=60 * pitch_um, height_um=50 * pitch_um, centre_um=(5.3, -7.1), rotate_deg=17.0, reflectance=0.08
    )
    return camsim.Scene(background=0.8, shapes=[shape])


@functools.cache
def frame_of(scene: str, phase: str, origin: tuple[int, int]) -> Frame:
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    camera = camera.replace(rows=221, cols=223, cfa=camsim.Cfa.bayer(phase))
    return camera.expose(
        {"rings": rings, "slanted": slanted}[scene](camera.pitch_um),
        light=camsim.Light("D55", illuminance_lux=5000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        region=camsim.Region(rows=SIDE, cols=SIDE, origin=origin),
        products=("mosaic", "truth"),
        tolerance=1e-4,
        noise=False,
    )


def by_rawpy(frame: Frame, folder: Path) -> np.ndarray:
    camsim.save(frame, folder / "a.dng", force=True)
    how = {"demosaic_algorithm": rawpy.DemosaicAlgorithm.AHD, "use_camera_wb": False, "user_wb": [1, 1, 1, 1]}
    return developed(folder / "a.dng", "raw", **how)


def by_colour_demosaicing(frame: Frame, folder: Path) -> np.ndarray:
    signal = (frame.mosaic.astype(float) - frame.black_level_dn) * frame.electrons_per_dn
    with warnings.catch_warnings():
        # It imports names that scipy and matplotlib have moved.
        warnings.simplefilter("ignore")
        from colour_demosaicing import demosaicing_CFA_Bayer_Menon2007

    return np.asarray(demosaicing_CFA_Bayer_Menon2007(signal, "".join(frame.cfa_pattern)))


def best_shift(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Return (rows, cols) by which ``found`` must be moved to lie on ``truth``."""
    blurred, wanted = (ndimage.gaussian_filter(image, 1.5) for image in (found, truth))
    shift = np.zeros(2)
    for _ in range(5):
        moved = ndimage.shift(blurred, shift, order=3)[12:-12, 12:-12]
        slopes = np.stack(
            [-slope.ravel() for slope in np.gradient(moved)] + [moved.ravel(), np.ones(moved.size)], axis=1
        )
        # Gain and offset are free: libraries scale.
        solved = np.linalg.lstsq(slopes, wanted[12:-12, 12:-12].ravel(), rcond=None)[0]
        shift += solved[:2] / solved[2]
    return shift


def test_the_measure_finds_a_shift() -> None:
    truth = ndimage.gaussian_filter(np.random.default_rng(0).normal(size=(SIDE, SIDE)), 3)
    for wanted in ((0.5, -0.25), (1.0, 0.0), (0.03, 0.0)):
        moved = ndimage.shift(truth, [-wanted[0], -wanted[1]], order=5)
        np.testing.assert_allclose(best_shift(3 * moved + 1, truth), wanted, atol=0.003)


@pytest.mark.parametrize("library", [by_rawpy, by_colour_demosaicing])
@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize(
    ("scene", "origin"), [("rings", (50, 50)), ("slanted", (50, 50)), ("slanted", (51, 50)), ("slanted", (50, 51))]
)
def test_truth_and_picture_lie_on_one_another(tmp_path, library, scene, phase, origin) -> None:
    frame = frame_of(scene, phase, origin)
    picture = library(frame, tmp_path)
    assert picture.shape == frame.truth.shape
    for channel in range(3):
        shift = best_shift(picture[:, :, channel], frame.truth[:, :, channel].astype(float))
        assert np.abs(shift).max() <= WITHIN_PX, (channel, shift)
