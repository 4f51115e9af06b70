"""Published methods have the figures that follow from their published coefficients, and the order that is known."""

from dataclasses import replace

import judged
import numpy as np
import pytest

import camsim
from camsim.errors import UnsupportedError
from camsim.measure.demosaic import evaluate, methods, subject_of_capture
from camsim.measure.demosaic.similarity import psnr_db, ssim

BILINEAR = {"camsim: bilinear", "colour-demosaicing: bilinear", "LibRaw: linear"}

# Malvar, He and Cutler 2004, figure 2, in eighths, as (right, down): weight; bilinear beside it.
CROSS = {(1, 0): 2, (-1, 0): 2, (0, 1): 2, (0, -1): 2}
DIAGONALS = {(1, 1): 2, (1, -1): 2, (-1, 1): 2, (-1, -1): 2}
FAR = ((2, 0), (-2, 0), (0, 2), (0, -2))
BESIDE = {(1, 0): 4, (-1, 0): 4}
FILTERS = {
    "bilinear": {"green": CROSS, "opposite": DIAGONALS, "beside": BESIDE},
    "Malvar 2004": {
        "green": {(0, 0): 4, **CROSS, **dict.fromkeys(FAR, -1)},
        "opposite": {(0, 0): 6, **DIAGONALS, **dict.fromkeys(FAR, -1.5)},
        "beside": {
            (0, 0): 5,
            **BESIDE,
            **dict.fromkeys(DIAGONALS, -1),
            (2, 0): -1,
            (-2, 0): -1,
            (0, 2): 0.5,
            (0, -2): 0.5,
        },
    },
}


def mean_square(name, fx, fy):
    """Return (R, G, B) what a method leaves of a grey grating of power 1: |1 − H(f)|² of what each place asks."""

    def lost(kind, turned=False):
        f = (fy, fx) if turned else (fx, fy)
        weights = FILTERS[name][kind].items()
        return (1.0 - sum(w * np.cos(2 * np.pi * (f[0] * x + f[1] * y)) for (x, y), w in weights) / 8.0) ** 2

    # Of four places one knows the colour itself; of green two do.
    red = (lost("beside") + lost("beside", turned=True) + lost("opposite")) / 4.0
    return np.array([red, lost("green") / 2.0, red])


@pytest.mark.parametrize(("across", "down"), [(11, 7), (3, 22)])
def test_a_grating_is_as_bad_as_published_coefficients_make_it(across, down):
    """Whole periods in the 80 × 80 photosites that are judged, so that every phase counts alike."""
    frame, fx, fy = judged.frame(coloured=False), across / 80.0, down / 80.0
    y, x = np.indices(frame.shape)
    light = 0.5 + 0.3 * np.cos(2 * np.pi * (fx * x + fy * y) + 0.7)
    subject = subject_of_capture(judged.capture(coloured=False), frame.truth)
    used = np.zeros(frame.shape, bool)
    used[8:-8, 8:-8] = True
    subject = replace(subject, truth=np.repeat(light[..., None], 3, axis=2).astype(np.float32), used=used, clipped=0)
    span = (frame.white_level_dn - frame.black_level_dn) * subject.level
    codes = frame.black_level_dn + span * light * subject.neutral[frame.channel_index]
    frame = replace(frame, mosaic=np.rint(codes).astype(np.uint16))
    for method in methods(frame)[0]:
        if method.name in BILINEAR or "Malvar" in method.name:
            squares = 0.5 * 0.3**2 * mean_square("Malvar 2004" if "Malvar" in method.name else "bilinear", fx, fy)
            verdict = evaluate(method.run(frame), subject, method=method.name, scale=subject.level)[0]
            assert verdict.cpsnr_db == pytest.approx(-10 * np.log10(squares.mean()), abs=0.02)
            assert verdict.psnr_db == pytest.approx(-10 * np.log10(squares), abs=0.03)


def test_likeness_is_that_of_another_program():
    """IPOL's imdiff on scikit-image's photograph with noise (values published with scikit-image's own tests)."""
    data = pytest.importorskip("skimage.data")
    photograph = data.camera()
    draws = np.random.RandomState(5).randn(*photograph.shape)  # the generator that the published values were drawn by
    noisy = np.clip(photograph + 20.0 * draws, 0, 255).astype(np.uint8)
    used = np.zeros(photograph.shape, bool)
    used[5:-5, 5:-5] = True
    a, b = (image[..., None].astype(np.float32) / np.float32(255.0) for image in (noisy, photograph))
    assert ssim(a, b, used) == pytest.approx(0.357959091663361, abs=5e-4)
    assert psnr_db(a, b, np.ones_like(used))[0] == pytest.approx(22.409353363576034, abs=1e-4)


@pytest.mark.parametrize("side", [36, 512])
def test_x_trans_has_the_methods_that_its_size_allows(side):
    """LibRaw's own passes fail below 512 photosites a side, and are left out in a sentence there."""
    changes = [f"region={{rows: {side}, cols: {side}}}", "render.tolerance=1e-2", "noise.enabled=false"]
    frame = camsim.load("flat-field", sensor="x-trans-376", overrides=changes).frame()
    for method in methods(frame)[0]:
        if side < 512 and "pass" in method.name:
            with pytest.raises(UnsupportedError, match="needs 512 photosites a side, and the picture has 36"):
                method.run(frame)
            continue
        image = method.run(frame)[8:-8, 8:-8]
        assert np.ptp(image) < 0.01 * image.mean()
