"""What ``camsim bench SCENE`` calls an error is one: against truths that no engine of camsim's shares."""

from typing import get_args

import numpy as np
import pytest

import camsim
from camsim.bench import bench_scene
from camsim.bench.records import Point, TruthLine
from camsim.bench.settings import METHODS
from camsim.bench.window import busiest
from camsim.bench.words import words_of_point, words_of_truths
from camsim.camera.window import Region
from camsim.errors import UnsupportedError
from tests.cli.conftest import SCENE
from tests.truth.lattice import Lens, window_truths

REGION = Region(rows=4, cols=5, origin=(88, 105))  # of the paper's 446 × 446: the square's upper left corner
QUICK = {"region": Region(rows=2, cols=3, origin=(997, 1514)), "longest_s": 0.5}  # beside what the small scene shows
TURN = np.radians(4.0)
CORNERS = (
    125.0
    * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    @ np.array([[np.cos(TURN), np.sin(TURN)], [-np.sin(TURN), np.cos(TURN)]])
)


@pytest.fixture(scope="module")
def exact():
    """The region by a Fourier sum of its own."""
    covered = window_truths(
        CORNERS,
        Lens(blur=np.array([0.55 * 8.0 / 4.88]), weights=np.ones(1)),
        [(1.0, 0.0)],
        origin=(105.5 - 223.0, 88.5 - 223.0),
        shape=(4, 5),
        shifts=np.zeros((1, 2)),
    )
    return 1.0 - covered[0, 0]


def test_errors_are_what_an_independent_truth_says(exact):
    """The square as a user of Python makes it, its errors taken from the other truth: the same figures."""
    found = bench_scene(
        "paper-square",
        methods=("boundary", "area", "uniform", "importance"),
        tolerances=(1e-2, 1e-4),
        samples=(121,),
        region=REGION,
        longest_s=0.5,
    )
    assert [p.label for p in found.points] == [
        *("boundary 1e-2", "boundary 1e-4"),
        *("area", "uniform", "importance, 121 samples"),
    ]
    side = 250.0 * 4.88
    black = camsim.Rectangle(width_um=side, height_um=side, rotate_deg=4.0, reflectance=0.0)
    for point in found.points:
        image = camsim.render(
            camsim.Scene(background=1.0, shapes=[black]),
            [camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=4.88)],
            camsim.Grid(rows=4, cols=5, pitch_um=4.88, origin=REGION.origin, frame=(446, 446)),
            wavelength_nm=550.0,
            method=point.method,
            samples=point.samples,
            tolerance=point.tolerance or 1e-6,
        ).image
        error = np.abs(image - exact)
        assert point.error_max == pytest.approx(error.max(), rel=1e-3)
        assert point.error_rms == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-3)
        assert (point.row - 88, point.col - 105) == np.unravel_index(np.argmax(error), error.shape)
    for line in found.truths:
        assert line.checked_to <= line.accurate_to <= line.tolerance
        assert line.difference <= sum(truth.tolerance for truth in found.truths)


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    path = tmp_path_factory.mktemp("checked") / "small.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return bench_scene(path, methods=("boundary",), tolerances=(1e-3, 1e-4), **QUICK)


def test_where_every_photosite_is_checked_the_check_says_the_same(checked):
    """Photosites of three channels, each relative to its own full scale, computed once more by the run-time check."""
    for point in checked.points:
        assert point.error_max > 1e3 * point.accurate_to
        # Of a twentieth of its tolerance an image and its check may have the same part.
        same = point.error_estimate == pytest.approx(point.error_max, rel=0.1)
        assert same or max(point.error_estimate, point.error_max) < 0.05 * point.tolerance


def test_more_light_is_no_more_error(scene, checked):
    twice = ["exposure.time_s=0.02"]
    found = bench_scene(scene, overrides=twice, methods=("boundary",), tolerances=(1e-3,), **QUICK)
    assert found.points[0].error_max == pytest.approx(checked.points[0].error_max, rel=1e-6)


def test_a_lens_that_one_engine_renders_is_judged_by_that_one_at_its_finest(scene):
    text = scene.read_text(encoding="utf-8")
    coma = "kind: wavefront, f_number: 8, zernike_waves: [[7, 0.1]]"
    scene.write_text(text.replace("kind: airy, f_number: 8", coma))
    found = bench_scene(scene, methods=("auto", "boundary"), tolerances=(1e-3, 1e-12), **QUICK | {"longest_s": 0.1})
    (truth,) = found.truths
    assert truth.engine == "fourier"
    assert truth.difference is None
    assert [p.label for p in found.points] == ["auto 1e-3"]
    assert [(left.label, left.why.split(":")[0]) for left in found.left_out] == [
        ("auto 1e-12", "it is the truth itself"),
        ("boundary 1e-3", "lens"),
    ]
    assert "compared with itself" in " ".join(words_of_truths(found.truths))


GRATING = "{kind: sine-grating, width: 12, height: 5, period: 6, low: 0.1, high: 0.7}"
SQUARE = "{kind: rectangle, width: 4, height: 4, reflectance: 0.1}"
POINT = "{kind: point-source, electrons: 500}"


def test_what_one_engine_alone_renders_is_judged_by_itself(scene):
    shapes = [f"scene.shapes=[{GRATING}, {SQUARE}, {POINT}]", "lens={kind: gaussian, f_number: 4, sigma_um: 2}"]
    how = QUICK | {"region": Region(rows=2, cols=2), "overrides": shapes}
    found = bench_scene(scene, methods=("boundary", "fourier"), tolerances=(1e-3, 1e-9), **how)
    (truth,) = found.truths
    assert (truth.engine, truth.difference) == ("fourier", None)
    assert [p.label for p in found.points] == ["fourier 1e-3"]
    assert all(p.by_itself and p.error_max > 0.0 for p in found.points)
    assert {left.label for left in found.left_out} == {"boundary 1e-3", "fourier 1e-9"}
    sentences = " ".join(finding.sentence for finding in found.findings)
    assert "No other engine renders this window so finely in the time: fourier is compared with itself" in sentences


def test_no_time_for_any_truth_is_said(scene):
    with pytest.raises(UnsupportedError, match=r"no engine renders this window finely enough .* about 0 s"):
        bench_scene(scene, longest_s=0.0)


def test_what_takes_too_long_is_left_out_with_its_time():
    wide = Region(rows=6, cols=8, origin=(86, 102))
    found = bench_scene("paper-square", methods=("importance",), samples=(121, 400_000), region=wide, longest_s=0.3)
    assert [p.samples for p in found.points] == [121]
    (left,) = found.left_out
    assert left.label == "importance, 400000 samples"
    assert "s of one core; look at a smaller region" in left.why


def at(x, y, side):
    return camsim.Rectangle(width_um=side, height_um=side, centre_um=(x, y), reflectance=0.1)


@pytest.mark.parametrize("origin", [(0, 0), (300, 700)])
def test_the_window_lies_where_the_outlines_are(origin):
    grid = camsim.Grid(rows=1000, cols=1500, pitch_um=2.0, origin=origin, frame=(2000, 3000))
    x0, y0 = grid.first_centre
    crowd = [at(2.0 * (x0 + 1400 + 3 * k), 2.0 * (y0 + 80), 20.0) for k in range(8)]
    far = at(0.0, 0.0, 1e7)  # its sides are nowhere near
    found = busiest(camsim.Scene(background=1.0, shapes=[far, *crowd]), grid)
    assert (found.rows, found.cols) == (128, 128)
    row, col = found.origin[0] - origin[0], found.origin[1] - origin[1]
    assert row <= 75
    assert row + 128 >= 85
    assert col <= 1395
    assert col + 128 >= 1426
    assert 0 <= row <= 1000 - 128
    assert 0 <= col <= 1500 - 128


def test_the_window_of_an_even_scene_is_the_middle_and_of_a_small_one_all():
    grid = camsim.Grid(rows=1000, cols=1500, pitch_um=2.0)
    assert busiest(camsim.Scene(background=1.0), grid) == Region(rows=128, cols=128, origin=(436, 686))
    small = camsim.Grid(rows=100, cols=300, pitch_um=2.0)
    assert busiest(camsim.Scene(background=1.0), small) == Region(rows=100, cols=128, origin=(0, 86))


def point(label, error, seconds, *, method="auto", accurate_to=1e-13, cpu_s=None, estimate=0.0):
    return Point(
        method=method,
        label=label,
        tolerance=1e-6,
        samples=None,
        engine="boundary",
        error_max=error,
        error_rms=error / 3,
        row=0,
        col=0,
        truth="fourier at 1e-11",
        accurate_to=accurate_to,
        error_estimate=estimate,
        wall_s=seconds,
        cpu_s=cpu_s or seconds,
        first_wall_s=seconds,
        laps=3,
    )


def test_what_is_faster_is_said_and_noise_is_not():
    auto = point("auto 1e-6", 2.3e-8, 0.13)
    best = "auto at 1e-6 (boundary): 0.13 s, error 2e-8; nothing is faster at that error."
    assert words_of_point(auto, [auto]) == best
    slower = point("boundary 1e-6", 2.3e-8, 0.12, method="boundary")
    worse = point("area", 0.3, 0.001, method="area")
    by_one_clock = point("fourier 1e-6", 1e-9, 0.05, method="fourier", cpu_s=0.13)
    assert words_of_point(auto, [auto, worse]) == best
    # What the table shows beside it is not denied: quicker by less than times scatter, or by one of two clocks.
    assert words_of_point(auto, [auto, slower, worse]).endswith(
        "nothing is clearly faster at that error (boundary 1e-6: 0.12 s)."
    )
    assert words_of_point(auto, [auto, slower, worse, by_one_clock]).endswith(
        "nothing is clearly faster at that error (fourier 1e-6: 0.05 s)."
    )
    faster = point("fourier 1e-6", 1e-9, 0.05, method="fourier")
    assert words_of_point(auto, [auto, worse, faster]).endswith(
        "error 2e-8; fourier 1e-6 is faster at no larger an error: 0.05 s."
    )


def test_an_error_that_the_truth_cannot_tell_is_not_called_one():
    auto = point("auto 1e-10", 7.1e-11, 5.0, accurate_to=7e-11, estimate=2e-14)
    coarse = point("boundary 1e-9", 6.9e-11, 1.0, method="boundary", accurate_to=1e-14)
    assert words_of_point(auto, [auto, coarse]).endswith(
        "error about 7e-11 or less (2e-14 where computed directly); nothing is clearly faster at that error "
        "(boundary 1e-9: 1 s)."
    )


def test_the_words_of_two_truths():
    lines = [
        TruthLine(
            engine=engine,
            tolerance=tolerance,
            checked_to=checked_to,
            checked_photosites=18,
            accurate_to=accurate_to,
            seconds=1.0,
            difference=7e-11,
        )
        for engine, tolerance, checked_to, accurate_to in (
            ("boundary", 1e-9, 4e-12, 7e-11),
            ("fourier", 1e-11, 1e-14, 1e-14),
        )
    ]
    first, second, third = words_of_truths(lines)
    assert first == "Truth: boundary at 1e-9; 18 of its photosites computed directly differ by 4e-12 at most."
    assert second.startswith("Truth: fourier at 1e-11;")
    assert "differ by 7e-11 at most, anywhere" in third
    assert "errors below 7e-11 (boundary) and 1e-14 (fourier) cannot be distinguished" in third


def test_a_flat_scene_has_no_error_and_a_page():
    from camsim.bench.report import page

    found = bench_scene("flat-field", methods=("auto",), tolerances=(1e-3,))
    assert found.points[0].error_max <= 1e-15
    assert "error 0; nothing is faster" in found.findings[-2].sentence
    assert "from [935, 1439] of 446 × 446, the middle of" in found.findings[0].sentence
    assert "The two truths differ by 0 at most" in found.findings[3].sentence
    assert "<svg" in page(found)


def test_methods_are_those_of_the_renderer():
    from camsim.rendering.auto import NAMES
    from camsim.rendering.render import AnyMethod

    assert set(METHODS) == set(NAMES) == set(get_args(AnyMethod))
