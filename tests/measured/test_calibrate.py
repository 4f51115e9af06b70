"""A camera's profile from its own frames: cameras of plain NumPy come back, and mistakes are told in a sentence."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.stats
from tolerances import STATISTICAL

from bench.calibration import draw_camera, judged, verdict, write_frames
from camsim.camera.sensor import Sensor
from camsim.errors import CamsimError
from camsim.files.hot_list import hot_text
from camsim.measure.calibrate import Calibration, calibrate, read_folder
from camsim.measure.calibrate.likeness import kl_nats
from camsim.measure.calibrate.profile_file import profile_text
from camsim.measure.calibrate.tails import fit_tails
from camsim.measure.noise import Estimate

SIDE, GAIN_E, READ_E, BLACK = 96, 2.0, 6.0, 400
LEVELS_E = (600.0, 1500.0, 3000.0, 6000.0, 12000.0)


def test_synthetic_cameras_come_back() -> None:
    """The bench with fewer photosites and cameras: ``python -m bench.calibration`` has twenty of 512²."""
    results = [judged(number, side=128, levels=5) for number in (100, 102)]
    sentence, _ = verdict(results)
    assert not [fault for result in results for fault in result["faults"]], sentence
    off = np.abs([each for result in results for each in result["off"].values()])
    assert off.size > 20
    assert off.max() <= 4.0, sentence
    # Of 29 normal figures more than 4 lie beyond 2 in one case of a hundred.
    assert np.count_nonzero(off > 2.0) <= 4, sentence
    stated = [p for result in results for p in result["probability"].values()]
    assert sum(p < 0.01 for p in stated) <= 1, sentence


def frames_at(rng: np.random.Generator, light_e: float, count: int, *, dark_e: Any = 0.0, rows: Any = None) -> Any:
    for _ in range(count):
        charge = rng.poisson(light_e + dark_e, (SIDE, SIDE)) + READ_E * rng.standard_normal((SIDE, SIDE))
        charge = charge if rows is None else charge + rows()[:, None]
        yield np.clip(np.rint(charge / GAIN_E + BLACK), 0, 16383).astype(np.uint16)


Put = Callable[..., None]


@pytest.fixture
def put(tmp_path: Path) -> Put:
    """Write frames into the folder, with a line of the index each."""
    lines: list[dict[str, object]] = []

    def write(kind: str, frames: Sequence[Any], **stated: object) -> None:
        for frame in frames:
            name = f"{len(lines):03d}.npy"
            np.save(tmp_path / name, frame)
            lines.append({"file": name, "kind": kind, **stated})
        heads = list(dict.fromkeys(key for line in lines for key in line))
        with (tmp_path / "index.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, heads)
            table.writeheader()
            table.writerows(lines)

    return write


def usual(put: Put, rng: np.random.Generator, darks: int = 8, **stated: object) -> None:
    for level in LEVELS_E:
        put("flat", list(frames_at(rng, level, 2)), exposure=level, time_s=0.01, **stated)
    put("dark", list(frames_at(rng, 0.0, darks)), time_s=0.01, **stated)


def calibrated(folder: Path) -> Calibration:
    return calibrate(read_folder(folder, cfa="mono"))


def near(stated: Estimate, value: float) -> bool:
    return stated.measurable and abs(stated.value - value) < STATISTICAL * stated.sigma < 0.5 * value


def test_dark_current_its_doubling_and_hot_photosites(tmp_path: Path, put: Put, rng: np.random.Generator) -> None:
    usual(put, rng, temperature_c=20)
    hot = np.zeros((SIDE, SIDE))
    places = rng.choice(SIDE * SIDE, 12, replace=False)
    hot.flat[places] = 150.0
    for celsius in (10.0, 20.0, 30.0):
        for time_s in (2.0, 8.0):
            dark_e = (20.0 * 2.0 ** ((celsius - 20.0) / 6.0) + hot) * time_s
            put("dark", list(frames_at(rng, 0.0, 3, dark_e=dark_e)), time_s=time_s, temperature_c=celsius)
    found = calibrated(tmp_path)
    at = 2.0 ** ((found.dark_current_at_c - 20.0) / 6.0)
    mean_hot = 150.0 * 12 / SIDE**2
    assert found.dark_current_e_per_s.value == pytest.approx(20.0 * at + mean_hot, rel=0.02)
    assert found.doubling_c.value == pytest.approx(6.0, rel=0.02)
    assert found.hot_fraction.value == pytest.approx(12 / SIDE**2)
    assert found.hot_e_per_s.value == pytest.approx(150.0, rel=0.05)
    text = profile_text(found, name="Warm")
    (tmp_path / "warm.yaml").write_text(text, encoding="utf-8")
    sensor = Sensor.from_yaml(tmp_path / "warm.yaml")
    assert sensor.defects is not None
    assert sensor.dark_current is not None
    assert sensor.dark_current.doubling_c == pytest.approx(found.doubling_c.value, rel=1e-5)
    (tmp_path / "hot.csv").write_text(hot_text(found.hot), encoding="utf-8")
    (tmp_path / "warm.yaml").write_text(profile_text(found, name="Warm", hot_file="hot.csv"), encoding="utf-8")
    defects = Sensor.from_yaml(tmp_path / "warm.yaml").defects
    assert defects is not None
    assert defects.hot_fraction is None
    assert {row * SIDE + col for row, col, _ in defects.hot} == set(places.tolist())
    assert [each for *_, each in defects.hot] == pytest.approx(12 * [150.0], rel=0.15)


def test_rows_with_a_pink_spectrum(tmp_path: Path, put: Put, rng: np.random.Generator) -> None:
    """Of twice the frame's rows, so that the first row knows nothing of the last."""

    def pink() -> Any:
        power = np.zeros(SIDE + 1)
        power[1:] = 1.0 / np.arange(1, SIDE + 1)
        whole = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * SIDE)) * np.sqrt(power), n=2 * SIDE)
        scale = np.sqrt((2.0 * power[1:-1].sum() + power[-1]) / (2.0 * SIDE))
        return 4.0 * whole[:SIDE] / scale

    for level in LEVELS_E:
        put("flat", list(frames_at(rng, level, 2)), exposure=level, time_s=0.01)
    put("dark", list(frames_at(rng, 0.0, 40, rows=pink)), time_s=0.01)
    found = calibrated(tmp_path)
    assert found.flicker_rows_e.measurable
    assert abs(found.flicker_rows_e.value - 4.0) < max(STATISTICAL * found.flicker_rows_e.sigma, 0.4)


def test_uneven_noise_is_not_taken_for_tails(rng: np.random.Generator) -> None:
    one = 5.0 * np.exp(0.3 * rng.standard_normal((300, 300)) - 0.3**2)
    frames = [np.rint(1000.0 + one * rng.standard_normal(one.shape)).astype(np.int64) for _ in range(8)]
    found = fit_tails(frames, step_dn=1.0, normal_dn2=0.0)
    assert found.shape.law == "normal"
    assert abs(found.shape.spread - 0.3) < STATISTICAL * found.errors["spread"] < 0.05
    assert abs(found.shape.sigma_dn - 5.0) < STATISTICAL * found.errors["sigma_dn"] < 0.2


@pytest.mark.parametrize("law", ["student", "tukey"])
def test_laws_that_differences_hardly_tell_are_told(law: str, rng: np.random.Generator) -> None:
    """Behind offsets of photosites and of filters' cells; t of 4 degrees, and a Tukey λ with differences like its."""
    shape = (8, 128, 128)
    if law == "student":
        noise = 7.2 * np.sqrt(0.5) * rng.standard_t(4.0, shape)
    else:
        p = rng.random(shape)
        noise = 7.13 * (p**-0.1432 - (1.0 - p) ** -0.1432) / -0.1432 / scipy.stats.tukeylambda.std(-0.1432)
    offsets = 128.3 + 1.5 * rng.standard_normal(shape[1:]) + np.tile([[0.0, 3.4], [1.7, -2.2]], (64, 64))
    frames = [np.rint(each + offsets).astype(np.int64) for each in noise]
    found = fit_tails(frames, step_dn=1.0, normal_dn2=0.0, fixed_dn2=1.5**2, period=(2, 2))
    assert found.shape.law == law


def test_normal_noise_has_no_tails(rng: np.random.Generator) -> None:
    frames = [np.rint(1000.0 + 3.0 * rng.standard_normal((256, 256))).astype(np.int64) for _ in range(6)]
    found = fit_tails(frames, step_dn=1.0, normal_dn2=0.0)
    assert (found.shape.law, found.shape.fraction, found.shape.spread) == ("normal", 0.0, 0.0)
    assert found.rises == ()


def test_the_divergence_is_that_of_two_normals(rng: np.random.Generator) -> None:
    """ln(s/r) + r²/2s² − ½ nats for standard deviations r and s."""
    ours, theirs = ([np.rint(500.0 + s * rng.standard_normal((600, 600)))] for s in (20.0, 24.0))
    whole = np.log(24.0 / 20.0) + 20.0**2 / (2.0 * 24.0**2) - 0.5
    stated = kl_nats([np.asarray(a, np.int64) for a in ours], [np.asarray(a, np.int64) for a in theirs], 1.0)
    assert stated == pytest.approx(whole, rel=0.05)


def test_kinds_come_from_folders_names_and_content(tmp_path: Path, rng: np.random.Generator) -> None:
    for kind, level in (("darks", 0.0), ("Flat-1", 5000.0)):
        (tmp_path / kind).mkdir()
        np.save(tmp_path / kind / "IMG_1.npy", next(frames_at(rng, level, 1)))
    np.save(tmp_path / "bias_7.npy", next(frames_at(rng, 0.0, 1)))
    np.save(tmp_path / "IMG_2.npy", next(frames_at(rng, 0.0, 1)))
    np.save(tmp_path / "IMG_3.npy", next(frames_at(rng, 4000.0, 1)))
    for beside in ("IMG_3.JPG", "plot.png", "._IMG_3.npy"):
        (tmp_path / beside).write_bytes(b"a preview, a plot, a note of the system's")
    stated = {shot.file: (shot.kind, shot.stated_by) for shot in read_folder(tmp_path).shots}
    assert stated == {
        "darks/IMG_1.npy": ("dark", "folder"),
        "Flat-1/IMG_1.npy": ("flat", "folder"),
        "bias_7.npy": ("dark", "name"),
        "IMG_2.npy": ("dark", "content"),
        "IMG_3.npy": ("flat", "content"),
    }


def test_a_setting_without_its_frames_is_left_out(tmp_path: Path, put: Put, rng: np.random.Generator) -> None:
    usual(put, rng, iso=100)
    put("dark", list(frames_at(rng, 0.0, 2)), time_s=0.01, iso=200)
    found = calibrated(tmp_path)
    assert [setting.iso for setting in found.settings] == [100.0]
    assert any("ISO 200 is left out: has 0 levels of light" in note.text for note in found.notes)
    assert near(found.settings[0].electrons_per_dn, GAIN_E)
    assert near(found.read_noise_e, READ_E)


def test_the_middle_is_measured(tmp_path: Path, put: Put, rng: np.random.Generator) -> None:
    usual(put, rng)
    assert read_folder(tmp_path, side=40).shots[0].codes.shape == (40, 40)


def no_darks(put: Put, rng: np.random.Generator) -> None:
    for level in LEVELS_E:
        put("flat", list(frames_at(rng, level, 2)), exposure=level, time_s=0.01)


def one_exposure(put: Put, rng: np.random.Generator) -> None:
    put("flat", list(frames_at(rng, 3000.0, 6)), time_s=0.01)
    put("dark", list(frames_at(rng, 0.0, 4)), time_s=0.01)


def clipped(put: Put, rng: np.random.Generator) -> None:
    for level in LEVELS_E:
        put("flat", list(frames_at(rng, 100.0 * level, 2)), exposure=level, time_s=0.01)
    put("dark", list(frames_at(rng, 0.0, 4)), time_s=0.01)


def two_sizes(put: Put, rng: np.random.Generator) -> None:
    usual(put, rng)
    put("dark", [np.zeros((50, 60), np.uint16)], time_s=0.01)


def no_kind(put: Put, rng: np.random.Generator) -> None:
    put("grey", list(frames_at(rng, 0.0, 1)))


def no_time(put: Put, rng: np.random.Generator) -> None:
    put("dark", list(frames_at(rng, 0.0, 2)))


def unlike(put: Put, rng: np.random.Generator) -> None:
    put("dark", list(frames_at(rng, 0.0, 1)), time_s="soon")


def filtered(put: Put, rng: np.random.Generator) -> None:
    seen = np.tile(np.array([[0.4, 1.0], [1.0, 0.6]]), (SIDE // 2, SIDE // 2))
    for level in LEVELS_E:
        put("flat", list(frames_at(rng, level, 2, dark_e=level * seen)), exposure=level, time_s=0.01)
    put("dark", list(frames_at(rng, 0.0, 4)), time_s=0.01)


@pytest.mark.parametrize(
    ("mistake", "sentence"),
    [
        (no_darks, "has no darks, or one alone; take two or more with the cap on"),
        (one_exposure, "has 1 levels of light; 4 flats of different exposure or more are needed"),
        (clipped, "flats clipped by the converter; expose them less"),
        (two_sizes, "frames of two cameras; give a folder of one"),
        (no_kind, "line 2: 'grey' is no kind; give flat, dark, clipped"),
        (no_time, ".npy' does not say its exposure time; give it in index.csv, column time_s"),
        (unlike, "time_s must be a number of 1e-09 or more, not 'soon'"),
        (filtered, "as behind colour filters, and the files name none; give the array: --cfa RGGB"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(
    mistake: Callable[[Put, np.random.Generator], None],
    sentence: str,
    tmp_path: Path,
    put: Put,
    rng: np.random.Generator,
) -> None:
    mistake(put, rng)
    with pytest.raises(CamsimError) as caught:
        calibrate(read_folder(tmp_path))
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_empty_folder(tmp_path: Path) -> None:
    with pytest.raises(CamsimError, match="holds no raw file that can be read"):
        read_folder(tmp_path)
    with pytest.raises(CamsimError, match="is no folder of flats and darks"):
        read_folder(tmp_path / "none")


def test_a_profile_says_what_was_told(tmp_path: Path) -> None:
    rng = np.random.default_rng([64, 101])
    camera = draw_camera(rng)
    write_frames(camera, tmp_path, rng, side=96, levels=5)
    found = calibrate(read_folder(tmp_path, cfa="RGGB" if camera.colours else "mono"))
    path = tmp_path / "mine.yaml"
    path.write_text(profile_text(found, name='A "quoted" name', pitch_um=3.3), encoding="utf-8")
    sensor = Sensor.from_yaml(path)
    assert (sensor.name, sensor.pitch_um, sensor.rows) == ('A "quoted" name', 3.3, 96)
    for setting in found.settings:
        assert sensor.adc.electrons_per_dn_at(setting.iso) == pytest.approx(setting.electrons_per_dn.value, rel=1e-5)
    assert sensor.adc.code_step_dn == found.step_dn == camera.step_dn
    assert sensor.adc.black_level_dn == round(found.black_dn.value)
    assert sensor.read_noise is not None
    assert sensor.read_noise.sigma_e == pytest.approx(found.read_noise_e.value, rel=1e-5)


def test_images_of_both_gains_give_one_profile(tmp_path: Path, put: Put, rng: np.random.Generator) -> None:
    """One charge of each exposure, read at 2 and at 0.4 electrons per data number."""

    def shoot(kind: str, light_e: float, count: int, **stated: object) -> None:
        for _ in range(count):
            charge = rng.poisson(light_e, (SIDE, SIDE))
            for read_out, gain_e, noise_e in (("low", GAIN_E, READ_E), ("high", 0.4, 1.6)):
                read = charge + noise_e * rng.standard_normal((SIDE, SIDE))
                codes = np.clip(np.rint(read / gain_e + BLACK), 0, 16383).astype(np.uint16)
                put(kind, [codes], read_out=read_out, time_s=0.01, **stated)

    for level in LEVELS_E[:4]:
        shoot("flat", level, 2, exposure=level)
    shoot("dark", 0.0, 8)
    found = calibrated(tmp_path)
    assert found.high is not None
    path = tmp_path / "both.yaml"
    path.write_text(profile_text(found, name="Both"), encoding="utf-8")
    for one, read, gain_e, noise_e in zip(found.read_outs, ("low", "high"), (GAIN_E, 0.4), (READ_E, 1.6), strict=True):
        assert near(one.settings[0].electrons_per_dn, gain_e)
        assert near(one.read_noise_e, noise_e)
        sensor = Sensor.from_yaml(path, overrides=[f"sensor.readout.dual_gain.read={read}"])
        assert sensor.converter.electrons_per_dn == pytest.approx(gain_e, rel=0.03)
    put("dark", list(frames_at(rng, 0.0, 1)), time_s=0.01)
    with pytest.raises(CamsimError, match=r"'032.npy' does not say of which it is; give it in index.csv, column read_"):
        calibrated(tmp_path)


def test_a_law_beyond_those_that_are_fitted_has_errors(rng: np.random.Generator) -> None:
    wild = np.rint(1000.0 + 3.0 * rng.standard_cauchy((8, 64, 64)).clip(-40, 40)).astype(np.int64)
    found = fit_tails(list(wild), step_dn=1.0, normal_dn2=0.0)
    assert all(np.isfinite(error) for error in found.errors.values())
