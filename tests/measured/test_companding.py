"""Companded codes: fractions, files that other programs read, levels, and noise that is measured through them."""

from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import rawpy
from maker_files import Tags, mosaic_tags, tiff_raw
from tolerances import STATISTICAL

import camsim
from camsim.api import load_camera
from camsim.cli.app import app
from camsim.config.from_record import shot_from_record
from camsim.files.reading import read_record
from camsim.measure import read_picture
from camsim.measure.calibrate import calibrate, read_folder
from camsim.measure.calibrate.likeness import side_by_side, simulated
from camsim.measure.calibrate.profile_file import profile_text
from camsim.measure.noise import measure_noise, take_shots
from camsim.measure.noise.stack import Photosites, Rounding, stack
from camsim.measure.reading import picture_of_frame
from camsim.sensor.companding import decoding, encoding

POINTS = ((0, 0), (512, 512), (1024, 640), (4095, 831))
YAML = "sensor.readout.companding={linear_dn: [0, 512, 1024, 4095], codes: [0, 512, 640, 831]}"


def straight(points: tuple[tuple[int, int], ...], at: int) -> int:
    """The nearest whole number on straight lines, of two as near the even one; by fractions."""
    (x0, y0), (x1, y1) = next(pair for pair in pairwise(points) if at <= pair[1][0])
    return round(y0 + Fraction((at - x0) * (y1 - y0), x1 - x0))


def test_codes_and_data_numbers_are_the_nearest_ones() -> None:
    back = tuple((code, dn) for dn, code in POINTS)
    assert encoding(POINTS).tolist() == [straight(POINTS, dn) for dn in range(4096)]
    assert decoding(POINTS).tolist() == [straight(back, code) for code in range(832)]
    off = decoding(POINTS)[encoding(POINTS)].astype(int) - np.arange(4096)
    assert abs(off[:513]).max() == 0
    assert abs(off).max() == 8  # half a step of 3071/191
    assert abs(off.mean()) < 0.02


def test_a_converter_compands_its_data_numbers() -> None:
    plain = camsim.Adc(bit_depth=12, black_level_dn=64, electrons_per_dn=2.5, base_iso=100)
    adc = camsim.Adc(bit_depth=12, black_level_dn=64, electrons_per_dn=2.5, base_iso=100, companding=POINTS)
    electrons = np.linspace(-500.0, 12000.0, 5001)
    codes = adc.quantise(electrons, iso=200)
    linear = plain.quantise(electrons, iso=200)
    assert codes.tolist() == [straight(POINTS, dn) for dn in linear.tolist()]
    full = adc.white_level_dn(200, 3000.0)
    assert full == adc.data_numbers(adc.quantise(np.array([3000.0]), iso=200))[0]


def shot() -> tuple[camsim.Frame, camsim.Frame]:
    """The same light and noise with companding, and without."""
    light = np.tile(np.geomspace(20.0, 40000.0, 96), (48, 1))
    exposure = camsim.Exposure(time_s=0.01, iso=200)
    frames = [
        camsim.Sensor.from_yaml("d40-like", overrides=more).expose(light, unit="electrons", exposure=exposure, seed=4)
        for more in ([YAML], [])
    ]
    return frames[0], frames[1]


def test_signals_are_those_of_the_data_numbers(tmp_path: Path) -> None:
    frame, plain = shot()
    assert frame.mosaic.max() == 831
    assert [straight(POINTS, dn) for dn in plain.mosaic.ravel().tolist()] == frame.mosaic.ravel().tolist()
    step = np.where(plain.mosaic <= 512, 0.0, np.where(plain.mosaic <= 1024, 4.0, 3071 / 191))
    assert (abs(frame.signal_dn - plain.signal_dn) <= 0.5 * step + 0.5 * (step > 0)).all()
    np.testing.assert_allclose(frame.signal_e, frame.signal_dn * 10.0)
    clipped = [signal.clipped_photosites for signal in frame.report.signal]
    assert sum(clipped) > 40
    assert clipped == [signal.clipped_photosites for signal in plain.report.signal]
    assert np.abs(frame.preview().astype(int) - plain.preview()).mean() < 2.0


@pytest.mark.parametrize("compress", [False, True])
def test_raw_programs_open_the_data_numbers(tmp_path: Path, compress: bool) -> None:
    if compress:
        pytest.importorskip("imagecodecs")
    frame, _ = shot()
    path = tmp_path / "shot.dng"
    camsim.save(frame, path, compress=compress)
    with rawpy.imread(str(path)) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, frame.linear_dn)
        assert raw.white_level == frame.white_level_dn == 4095
        assert set(raw.black_level_per_channel) == {128}


@pytest.mark.parametrize("suffix", [".dng", ".tiff", ".npz"])
def test_files_of_ours_come_back_linear(tmp_path: Path, suffix: str) -> None:
    frame, _ = shot()
    path = tmp_path / f"shot{suffix}"
    camsim.save(frame, path)
    for picture in (read_picture(path), picture_of_frame(frame)):
        for plane in picture.planes:
            row, col = plane.first
            np.testing.assert_array_equal(plane.samples, frame.linear_dn[row::2, col::2])
            assert (plane.black, plane.white) == (128.0, 4095.0)


def test_people_are_told_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    frame, _ = shot()
    camsim.save(frame, "shot.dng")
    assert not app(["info", "shot.dng"], standalone_mode=False)
    assert "companded: 0, 512, 1024, 4095 DN are the codes 0, 512, 640, 831" in capsys.readouterr().out
    small = ["--set", "region={rows: 12, cols: 12}", "--set", "render.tolerance=1e-2", "--set", YAML, "-q"]
    assert not app(["capture", "flat-field", "--pairs", "pairs", "--levels", "1", *small], standalone_mode=False)
    assert "LinearizationTable" in Path("pairs/README.md").read_text(encoding="utf-8")


def test_it_is_taken_again_from_its_record(tmp_path: Path) -> None:
    np.save(tmp_path / "light.npy", np.full((8, 8), 9000.0))
    sensor = camsim.Sensor.from_yaml("d40-like", overrides=[YAML])
    frame = sensor.expose(camsim.read_light(tmp_path / "light.npy", unit="electrons"), seed=2)
    camsim.save(frame, tmp_path / "shot.dng")
    with (tmp_path / "shot.dng").open("rb") as file:
        record = read_record(file, (tmp_path / "shot.dng").stat().st_size)
    assert record is not None
    assert record.companding == frame.companding == POINTS
    np.testing.assert_array_equal(shot_from_record(record.description, tmp_path).frame().mosaic, frame.mosaic)


def test_the_noise_of_a_camera_is_measured_through_it() -> None:
    """Steps of 32 DN have 85 DN² of rounding, which would be taken for photons' where those have 570 DN² and more."""
    overrides = [
        "sensor.readout.companding={linear_dn: [0, 255, 1535, 4095], codes: [0, 255, 415, 495]}",
        "sensor.readout.read_noise_e=8", "sensor.charge.prnu=0.02",
    ]  # fmt: skip
    camera = load_camera("mono-345", lens=camsim.Airy(f_number=8.0), overrides=overrides)
    transfer = measure_noise(take_shots(camera, side=192, frames=8, seed=3)).channels[0].transfer
    for figure, value in ((transfer.gain_dn_per_e, 1 / 2.7), (transfer.read_noise_e, 8.0), (transfer.prnu, 0.02)):
        assert abs(figure.value - value) < STATISTICAL * figure.sigma < 0.02 * value, figure


def test_a_profile_has_the_table_of_the_files(tmp_path: Path, rng: np.random.Generator) -> None:
    """Frames of plain NumPy in DNGs whose codes are the roots of data numbers; the profile takes frames alike."""
    table = np.concatenate([np.arange(256), 255 + np.cumsum(np.arange(1, 121) // 6 + 1)]).astype(np.uint16)
    encode = np.searchsorted(0.5 * (table[:-1] + table[1:].astype(float)), np.arange(table[-1] + 1))
    where = tmp_path / "frames"
    where.mkdir()
    with (where / "index.csv").open("w", encoding="utf-8") as index:
        index.write("file,kind,iso,time_s,exposure\n")
        levels = [0.0] * 8 + [each for level in (150.0, 400.0, 900.0, 1500.0, 2300.0) for each in (level, level)]
        for number, level in enumerate(levels):
            charge = rng.poisson(level, (96, 96)) + 3.0 * rng.standard_normal((96, 96))
            codes = encode[np.clip(np.rint(60 + charge / 2.0), 0, table[-1]).astype(int)].astype("<u2")
            linear = {50712: ("H", table.tolist()), 50714: ("I", 60), 50717: ("I", int(table[-1]))}
            tags: Tags = {**mosaic_tags(codes, 16), **linear}
            tiff_raw(
                where / f"{number}.dng", codes.tobytes(), tags, make="Acme", model="Root",
                first={254: ("I", 1), 50706: ("B", bytes((1, 4, 0, 0)))},
            )  # fmt: skip
            index.write(f"{number}.dng,{'flat' if level else 'dark'},100,0.01,{level}\n")
    found = calibrate(read_folder(where))
    gain = found.settings[0].electrons_per_dn
    assert abs(gain.value - 2.0) < STATISTICAL * gain.sigma < 0.2
    (tmp_path / "root.yaml").write_text(profile_text(found, name="Root"), encoding="utf-8")
    sensor = camsim.Sensor.from_yaml(tmp_path / "root.yaml")
    assert len(sensor.adc.companding) < 40
    assert sensor.adc.data_numbers(np.arange(table.size, dtype=np.uint16)).tolist() == table.tolist()
    sides = side_by_side(found.shots, simulated(found.shots, found, sensor), found)
    assert min(test.probability for side in sides for test in side.tests) > 1e-4


@pytest.mark.parametrize("mean", [1400.0, 1560.0, 1600.0, 1640.0, 1800.0])
@pytest.mark.parametrize("uneven", [0.0, 20.0])
def test_rounding_where_codes_begin_to_lie_further_apart(mean: float, uneven: float) -> None:
    """Codes 8 apart to 1600 and 32 apart from there on: their variance less that of rounding is the signal's."""
    rng = np.random.default_rng(8)
    noise = 30.0 * rng.standard_normal((8, 200, 200))
    signal = mean + uneven * rng.standard_normal((200, 200)) + noise
    codes = np.where(signal < 1600.0, 8.0 * np.rint(signal / 8.0), 1600.0 + 32.0 * np.rint((signal - 1600.0) / 32.0))
    one = stack(list(codes.astype(np.int64)), Photosites(np.ones((200, 200), bool)), Rounding(step_dn=8.0))
    assert one.variance_dn2 - one.coarser_dn2 - 64.0 / 12.0 == pytest.approx(noise.var(axis=0, ddof=1).mean(), rel=6e-3)
