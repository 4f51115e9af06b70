"""What is known of single photosites, from files: offsets, hot ones, and real darks of which each exposure has one."""

from pathlib import Path

import numpy as np
import pytest
from electronics import refused_in_a_sentence

import camsim
from camsim.config.from_record import shot_from_record
from camsim.errors import InputError
from camsim.files.reading import read_file
from tests.tables import rows

SENSOR = """\
camsim: sensor/1
name: Mine
frame: {rows: 12, cols: 16, pitch_um: 4.0}
cfa: {kind: mono}
quantum_efficiency: {curves: {Y: {wavelength_nm: [380, 780], values: [0.5, 0.5]}}, per: photon, peak: as given}
charge: {shot_noise: false, defects: {hot: hot.csv}}
readout: {bit_depth: 12, black_level_dn: 100, base_iso: 100, electrons_per_dn: 2.0, offset_map: {file: bias.npy}}
"""
DARKS = SENSOR.replace("defects: {hot: hot.csv}", "dark_frames: darks").replace(", offset_map: {file: bias.npy}", "")
HOT = "# of the darks of 60 s\nrow,col,e_per_s\n3,4,100\n11,15,2.5e3\n"
ALIKE = "sensor.charge.defects=null"


def put(file: str, text: str) -> None:
    Path(file).write_text(text, encoding="utf-8")


@pytest.fixture
def bias(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> np.ndarray:
    """A map whose mean is 250, and a sensor beside it."""
    monkeypatch.chdir(tmp_path)
    bias = np.rint(rng.normal(0.0, 6.0, (12, 16)))
    bias[0, 0] -= bias.sum()
    np.save("bias.npy", bias + 250.0)
    put("hot.csv", HOT)
    put("mine.yaml", SENSOR)
    return bias


@pytest.fixture
def darks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> np.ndarray:
    """Five darks of a mean of 50, and a sensor beside them."""
    monkeypatch.chdir(tmp_path)
    codes = rng.integers(40, 60, (5, 12, 16))
    codes[0, 0] += (50 * codes.size - codes.sum()) // 16
    codes[0, 1, 0] += 50 * codes.size - codes.sum()
    Path("darks").mkdir()
    for k, dark in enumerate(codes):
        np.save(f"darks/{k}.npy", dark.astype(np.uint16))
    put("mine.yaml", DARKS)
    return codes


def exposed(sensor: camsim.Sensor, iso: float = 100.0, seed: int = 1, electrons: float = 80.0) -> np.ndarray:
    light, exposure = np.full((sensor.rows, sensor.cols), electrons), camsim.Exposure(time_s=0.5, iso=iso)
    return sensor.expose(light, unit="electrons", exposure=exposure, seed=seed).mosaic.astype(int)


def test_codes_have_the_offsets_and_the_hot_photosites(bias: np.ndarray) -> None:
    want = 100 + 40 + bias
    want[3, 4] += 50.0 / 2.0
    want[11, 15] += 1250.0 / 2.0
    np.testing.assert_array_equal(exposed(camsim.Sensor.from_yaml("mine.yaml")), want)


def test_offsets_of_data_numbers_stay_at_every_setting_and_electrons_grow(bias: np.ndarray) -> None:
    sensor = camsim.Sensor.from_yaml("mine.yaml", overrides=[ALIKE])
    np.testing.assert_array_equal(exposed(sensor, iso=400.0), 100 + 160 + bias)
    sensor = camsim.Sensor.from_yaml("mine.yaml", overrides=[ALIKE, "sensor.readout.offset_map.unit=electrons"])
    np.testing.assert_array_equal(exposed(sensor, iso=400.0), 100 + 160 + 2 * bias)


def test_a_folder_of_darks_gives_their_mean(bias: np.ndarray, rng: np.random.Generator) -> None:
    noise = rng.integers(-3, 4, (2, 12, 16))
    Path("darks").mkdir()
    for k, dark in enumerate([*(bias + noise), *(bias - noise)]):
        np.save(f"darks/{k}.npy", (dark + 500).astype(np.uint16))
    put("mine.yaml", SENSOR.replace("bias.npy", "darks"))
    np.testing.assert_array_equal(exposed(camsim.Sensor.from_yaml("mine.yaml", overrides=[ALIKE])), 140 + bias)


def test_each_exposure_is_light_and_one_of_the_darks(darks: np.ndarray) -> None:
    sensor, seen = camsim.Sensor.from_yaml("mine.yaml"), set()
    for seed in range(40):
        codes = exposed(sensor, seed=seed)
        (match,) = (k for k, dark in enumerate(darks) if np.array_equal(codes, 100 + 40 + dark - 50))
        seen.add(match)
    assert seen == set(range(5))


@pytest.mark.parametrize("known", ["bias", "darks"])
def test_a_window_has_its_own_part_and_a_larger_sensor_repeats_it(known: str, request: pytest.FixtureRequest) -> None:
    request.getfixturevalue(known)
    sensor = camsim.Sensor.from_yaml("mine.yaml", overrides=[ALIKE])
    region = camsim.Region(rows=5, cols=6, origin=(4, 7))
    part = sensor.expose(np.full((5, 6), 80.0), unit="electrons", region=region, seed=1).mosaic
    whole = exposed(sensor)
    np.testing.assert_array_equal(part, whole[4:9, 7:13])
    np.testing.assert_array_equal(exposed(sensor.replace(rows=30, cols=40)), np.tile(whole, (3, 3))[:30, :40])


@pytest.mark.parametrize(("known", "what"), [("bias", "the offsets"), ("darks", "the darks")])
def test_it_is_taken_again_while_the_files_are_there(
    known: str, what: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    request.getfixturevalue(known)
    np.save("light.npy", np.full((12, 16), 80.0))
    frame = camsim.Sensor.from_yaml("mine.yaml").expose(camsim.read_light("light.npy", unit="electrons"), seed=7)
    camsim.save(frame, "shot.dng")
    description = read_file("shot.dng").description
    np.testing.assert_array_equal(shot_from_record(description, tmp_path).frame().mosaic, frame.mosaic)  # type: ignore[union-attr]
    file = Path("bias.npy" if known == "bias" else "darks/0.npy")
    np.save(file, np.load(file).T if known == "bias" else np.load("darks/1.npy"))
    with pytest.raises(InputError, match=rf"{what} .*are others than were taken, their numbers differ"):
        shot_from_record(description, tmp_path)
    Path(known if known == "darks" else "bias.npy").rename("gone")
    with pytest.raises(InputError, match=rf"not reproducible without {what} .*; put them there"):
        shot_from_record(description, tmp_path)


@pytest.mark.parametrize(("mistake", "sentence"), rows("wrong-contents.txt", "maps of photosites"))
def test_a_mistake_is_told_in_one_sentence(mistake: str, sentence: str, bias: np.ndarray) -> None:
    eval(mistake)()
    refused_in_a_sentence("./mine.yaml", sentence)


def test_darks_of_another_size_and_what_they_hold_besides(darks: np.ndarray) -> None:
    put("mine.yaml", DARKS.replace("darks", "darks, dsnu_e: 1"))
    refused_in_a_sentence("./mine.yaml", "mine.yaml:6:42: charge.dark_frames: have dsnu in them, which would be there ")
    np.save("darks/7.npy", np.zeros((5, 5), np.uint16))
    refused_in_a_sentence("./mine.yaml", "has 5 × 5 photosites, and ")
