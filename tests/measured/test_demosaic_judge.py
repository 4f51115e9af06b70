"""The judge: its figures by other roads, its names for what is wrong, and its order of published methods."""

import dataclasses
import math
import warnings

import judged
import numpy as np
import pytest
from scipy import ndimage, signal
from skimage.metrics import peak_signal_noise_ratio

import camsim
from camsim.files.preview import demosaic
from camsim.measure.demosaic import compete, evaluate, methods, subject_of_capture
from camsim.measure.demosaic.artefacts import artefacts
from camsim.measure.demosaic.methods import signal as balanced_signal
from camsim.measure.demosaic.similarity import ms_ssim, psnr_db, ssim
from tests.tables import rows


@pytest.fixture(scope="module")
def subject():
    return subject_of_capture(judged.capture(), judged.frame().truth)


@pytest.fixture(scope="module")
def ahd():
    """LibRaw's AHD of the picture, 1 where white clips."""
    (method,) = (method for method in methods(judged.frame())[0] if method.name == "LibRaw: AHD")
    return method.run(judged.frame())


def faults(found, subject):
    return [fault.name for fault in evaluate(found.astype(np.float32), subject, method="x")[0].faults]


def halved(image):
    """Means of 2 × 2 pixels."""
    rows, cols = (size // 2 for size in image.shape[:2])
    return image.reshape(rows, 2, cols, 2, 3).mean(axis=(1, 3))


def window(image, size=11, sigma=1.5):
    """Gaussian means over whole windows, directly."""
    x = np.arange(size) - size // 2
    g = np.exp(-0.5 * (x / sigma) ** 2)
    kernel = np.outer(g, g) / g.sum() ** 2
    return signal.convolve2d(image, kernel, mode="valid")


def direct_ssim(a, b):
    """Wang et al. 2004, equation by equation: brightness and contrast-structure, as maps."""
    ma, mb = window(a), window(b)
    va, vb, cab = window(a * a) - ma**2, window(b * b) - mb**2, window(a * b) - ma * mb
    light = (2 * ma * mb + 0.01**2) / (ma**2 + mb**2 + 0.01**2)
    return light, (2 * cab + 0.03**2) / (va + vb + 0.03**2)


def pair(side=190):
    rng = np.random.default_rng(4)
    a = ndimage.gaussian_filter(rng.random((side, side, 3)), (2, 2, 0))
    a = (a - a.min()) / np.ptp(a)
    return a.astype(np.float32), np.clip(a + rng.normal(0, 0.05, a.shape), 0, 1).astype(np.float32)


def test_likeness_is_that_of_the_papers():
    a, b = pair()
    used = np.zeros(a.shape[:2], bool)
    used[7:-7, 7:-7] = True
    inner = slice(2, -2), slice(2, -2)  # whole windows about what is used
    expected = np.mean(
        [np.mean(np.multiply(*direct_ssim(a[..., k].astype(float), b[..., k].astype(float)))[inner]) for k in range(3)]
    )
    assert ssim(b, a, used) == pytest.approx(expected, abs=1e-5)
    expected = []
    for k in range(3):
        x, y, product = a[7:-7, 7:-7, k].astype(float), b[7:-7, 7:-7, k].astype(float), 1.0
        for number, weight in enumerate((0.0448, 0.2856, 0.3001, 0.2363, 0.1333)):
            light, contrast = direct_ssim(x, y)
            product *= np.mean(light * contrast if number == 4 else contrast) ** weight
            x, y = (part[: len(part) // 2 * 2, : len(part) // 2 * 2] for part in (x, y))
            x, y = (part.reshape(len(part) // 2, 2, -1, 2).mean(axis=(1, 3)) for part in (x, y))
        expected.append(product)
    assert ms_ssim(b, a, used) == pytest.approx(np.mean(expected), abs=1e-5)
    whole, channels = psnr_db(b, a, used)
    cut = slice(7, -7), slice(7, -7)
    assert whole == pytest.approx(peak_signal_noise_ratio(a[cut], b[cut], data_range=1.0), abs=1e-4)
    assert channels[1] == pytest.approx(
        peak_signal_noise_ratio(a[cut][..., 1], b[cut][..., 1], data_range=1.0), abs=1e-4
    )


def test_an_identical_picture_is_infinitely_good(subject):
    verdict, _ = evaluate(judged.frame().truth[..., :], subject, method="the truth in electrons")
    assert verdict.identical
    assert math.isinf(verdict.cpsnr_db)
    assert (verdict.ssim, verdict.delta_e_mean, verdict.delta_e_95, verdict.zipper) == (1.0, 0.0, 0.0, 0.0)
    assert verdict.as_dict()["cpsnr_db"] is None
    assert not verdict.faults


def test_a_colour_difference_is_what_it_is(subject):
    """A shift of a* by one everywhere but on some photosites: no zipper there, ΔC = 1."""
    assert artefacts(subject.truth * np.float32(1.0), subject).false_colour == 0.0
    spoilt = subject.truth.copy()
    spoilt[40, 40:60] *= np.array([1.6, 1.0, 0.6], np.float32)
    seen = artefacts(spoilt, subject)
    # Each of the 20, and some of their neighbours whose nearest in colour they were.
    assert 15 <= seen.zipper * subject.used.sum() <= 80
    assert seen.delta_e_mean > 0.0


@pytest.mark.parametrize(("name", "spoil"), rows("spoiled-pictures.txt", "demosaiced"))
def test_what_is_wrong_is_named(name, spoil, subject, ahd):
    assert faults(eval(spoil)(ahd, subject.neutral), subject) == [name]


@pytest.mark.parametrize("scale", [1.0, 65535.0, 3e-3])
def test_scale_and_undone_white_balance_are_no_faults(scale, subject, ahd):
    best = evaluate(ahd, subject, method="x", scale=subject.level)[0]
    for found in (ahd * scale, ahd * scale * subject.neutral):
        verdict, _ = evaluate(found.astype(np.float32), subject, method="x")
        assert not verdict.faults
        assert verdict.cpsnr_db == pytest.approx(best.cpsnr_db, abs=0.05)


@pytest.mark.parametrize("phase", ["GRBG", "GBRG", "BGGR"])
def test_a_wrong_phase_is_named(phase, subject):
    frame = judged.frame()
    wrong = camsim.Cfa.bayer(phase).channel_index(*frame.shape)
    codes = (frame.mosaic.astype(np.float32) - frame.black_level_dn) / subject.neutral.astype(np.float32)[wrong]
    found = np.moveaxis(demosaic(codes.astype(np.float32), wrong, 3), 0, 2)
    assert faults(found, subject) == ["R and B are swapped" if phase == "BGGR" else "wrong phase"]


def test_published_methods_are_in_their_known_order():
    """Grey rings without a low-pass filter: bilinear is the worst, and three programs' bilinear are the same."""
    capture, frame = judged.capture(coloured=False), judged.frame(coloured=False)
    subject = subject_of_capture(capture, frame.truth)
    entries, why = methods(frame)
    assert len(entries) == 11
    assert not why
    ranking = compete(subject, frame, entries)
    verdicts = ranking.verdicts
    last = {verdict.method for verdict in verdicts[-3:]}
    assert last == {"camsim: bilinear", "colour-demosaicing: bilinear", "LibRaw: linear"}
    bilinear = [verdict.cpsnr_db for verdict in verdicts[-3:]]
    assert max(bilinear) - min(bilinear) < 0.01
    assert verdicts[0].cpsnr_db > bilinear[0] + 3.0
    assert not any(verdict.faults for verdict in verdicts)
    assert [entry["rank"] for entry in ranking.as_dict()["verdicts"]] == list(range(1, 12))


def test_the_four_phases_have_the_same_verdict():
    """Rings in the middle of many periods: which photosite begins changes next to nothing."""
    found = []
    for phase in ("RGGB", "BGGR", "GRBG", "GBRG"):
        frame = judged.frame(phase)
        subject = subject_of_capture(judged.capture(phase), frame.truth)
        image = np.moveaxis(demosaic(balanced_signal(frame), frame.channel_index, 3), 0, 2)
        found.append(evaluate(image, subject, method=phase, scale=subject.level)[0].cpsnr_db)
    assert np.ptp(found) < 0.05


def with_black_offsets(offsets):
    """The picture and its frame of a camera with black offsets."""
    capture = judged.capture()
    adc = dataclasses.replace(capture.camera.adc, black_offsets_dn=offsets)
    capture = dataclasses.replace(capture, camera=capture.camera.replace(adc=adc))
    return capture, capture.frame(products=("mosaic", "truth"))


def test_black_offsets_change_no_level():
    """The least of them is LibRaw's black, and moves the file's white as well."""
    _, frame = with_black_offsets(((-20, 10), (0, -20)))
    one, others = (next(m for m in methods(f)[0] if m.name == "LibRaw: linear").run(f) for f in (judged.frame(), frame))
    # Codes are rounded, and LibRaw's scale as well.
    assert others.mean() == pytest.approx(one.mean(), rel=5e-4)


def test_photosites_that_black_offsets_let_clip_are_not_judged():
    capture, frame = with_black_offsets(((0, 2000), (0, 0)))
    used = subject_of_capture(capture, frame.truth).used
    assert (frame.mosaic == 4095).any()
    assert used.any()
    assert frame.mosaic[used].max() < 4095


def test_colour_demosaicing_leaves_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for method in methods(judged.frame())[0]:
            assert method.run(judged.frame()).shape == (96, 96, 3)
