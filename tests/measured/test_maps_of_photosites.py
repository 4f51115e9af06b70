"""What is known of single photosites, from files: their offsets, and how hot they are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from electronics import refused_in_a_sentence

import camsim
from camsim.errors import InputError
from camsim.files.reading import read_record
from camsim.revive import revive_shot

SENSOR = """\
camsim: sensor/1
name: Mine
frame: {rows: 12, cols: 16, pitch_um: 4.0}
cfa: {kind: mono}
quantum_efficiency: {curves: {Y: {wavelength_nm: [380, 780], values: [0.5, 0.5]}}, per: photon, peak: as given}
charge: {shot_noise: false, defects: {hot: hot.csv}}
readout: {bit_depth: 12, black_level_dn: 100, base_iso: 100, electrons_per_dn: 2.0, offset_map: {file: bias.npy}}
"""
HOT = "# of the darks of 60 s\nrow,col,e_per_s\n3,4,100\n11,15,2.5e3\n"


@pytest.fixture
def bias(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> np.ndarray:
    """A map whose mean is 250, and a sensor beside it."""
    monkeypatch.chdir(tmp_path)
    bias = np.rint(rng.normal(0.0, 6.0, (12, 16)))
    bias[0, 0] -= bias.sum()
    np.save("bias.npy", bias + 250.0)
    Path("hot.csv").write_text(HOT, encoding="utf-8")
    Path("mine.yaml").write_text(SENSOR, encoding="utf-8")
    return bias


def exposed(sensor: camsim.Sensor, iso: float = 100.0, time_s: float = 0.5, electrons: float = 80.0) -> np.ndarray:
    light = np.full((sensor.rows, sensor.cols), electrons)
    return sensor.expose(light, unit="electrons", exposure=camsim.Exposure(time_s=time_s, iso=iso)).mosaic.astype(int)


def test_codes_have_the_offsets_and_the_hot_photosites(bias: np.ndarray) -> None:
    want = 100 + 40 + bias
    want[3, 4] += 50.0 / 2.0
    want[11, 15] += 1250.0 / 2.0
    np.testing.assert_array_equal(exposed(camsim.Sensor.from_yaml("mine.yaml")), want)


def test_offsets_of_data_numbers_stay_at_every_setting_and_electrons_grow(bias: np.ndarray) -> None:
    sensor = camsim.Sensor.from_yaml("mine.yaml", overrides=["sensor.charge.defects=null"])
    np.testing.assert_array_equal(exposed(sensor, iso=400.0), 100 + 160 + bias)
    sensor = camsim.Sensor.from_yaml(
        "mine.yaml", overrides=["sensor.charge.defects=null", "sensor.readout.offset_map.unit=electrons"]
    )
    np.testing.assert_array_equal(exposed(sensor, iso=400.0), 100 + 160 + 2 * bias)


def test_a_folder_of_darks_gives_their_mean(bias: np.ndarray, rng: np.random.Generator) -> None:
    noise = rng.integers(-3, 4, (2, 12, 16))
    Path("darks").mkdir()
    for k, dark in enumerate([*(bias + noise), *(bias - noise)]):
        np.save(f"darks/{k}.npy", (dark + 500).astype(np.uint16))
    Path("mine.yaml").write_text(SENSOR.replace("bias.npy", "darks"), encoding="utf-8")
    sensor = camsim.Sensor.from_yaml("mine.yaml", overrides=["sensor.charge.defects=null"])
    np.testing.assert_array_equal(exposed(sensor), 140 + bias)


def test_a_window_has_its_own_part_and_a_larger_sensor_repeats_it(bias: np.ndarray) -> None:
    sensor = camsim.Sensor.from_yaml("mine.yaml")
    region = camsim.Region(rows=5, cols=6, origin=(4, 7))
    part = sensor.expose(np.full((5, 6), 80.0), unit="electrons", region=region).mosaic
    np.testing.assert_array_equal(part, 140 + bias[4:9, 7:13])
    large = sensor.replace(rows=30, cols=40, defects=None)
    np.testing.assert_array_equal(exposed(large), 140 + np.tile(bias, (3, 3))[:30, :40])


def test_it_is_taken_again_while_the_map_is_there(bias: np.ndarray, tmp_path: Path) -> None:
    np.save("light.npy", np.full((12, 16), 80.0))
    frame = camsim.Sensor.from_yaml("mine.yaml").expose(camsim.read_light("light.npy", unit="electrons"), seed=7)
    camsim.save(frame, "shot.dng")
    with Path("shot.dng").open("rb") as file:
        record = read_record(file, Path("shot.dng").stat().st_size)
    assert record is not None
    again = revive_shot(record.description, tmp_path).frame()
    np.testing.assert_array_equal(again.mosaic, frame.mosaic)
    np.save("bias.npy", bias.T)
    with pytest.raises(InputError, match=r"the offsets .* are others than were taken, their numbers differ"):
        revive_shot(record.description, tmp_path)
    Path("bias.npy").unlink()
    with pytest.raises(InputError, match=r"not reproducible without the offsets .bias.npy.; put them there"):
        revive_shot(record.description, tmp_path)


def no_map() -> None:
    Path("bias.npy").unlink()


def colours() -> None:
    np.save("bias.npy", np.zeros((4, 4, 3)))


def no_numbers() -> None:
    np.save("bias.npy", np.full((4, 4), np.nan))


def no_list() -> None:
    Path("hot.csv").unlink()


def other_columns() -> None:
    Path("hot.csv").write_text("x,y,rate\n1,2,3\n", encoding="utf-8")


def a_place_that_is_none() -> None:
    Path("hot.csv").write_text(HOT + "-1,2,3\n", encoding="utf-8")


def outside_the_frame() -> None:
    Path("hot.csv").write_text(HOT + "12,2,3\n", encoding="utf-8")


def outside_the_folder() -> None:
    Path("mine.yaml").write_text(SENSOR.replace("hot.csv", "../hot.csv"), encoding="utf-8")


@pytest.mark.parametrize(
    ("mistake", "sentence"),
    [
        (no_map, "mine.yaml:7:97: readout.offset_map: cannot read 'bias.npy': there is no such file"),
        (colours, "mine.yaml:7:97: readout.offset_map: 'bias.npy' has the shape (4, 4, 3); a map of offsets is "),
        (no_numbers, "readout.offset_map: 'bias.npy' has numbers that are not finite; a map of offsets is "),
        (no_list, "mine.yaml:6:38: charge.defects: cannot read 'hot.csv': there is no such file"),
        (other_columns, "charge.defects: 'hot.csv' needs the columns row, col, e_per_s: a line for each hot photosite"),
        (a_place_that_is_none, "'hot.csv', photosite 3: '-1,2,3'; give row and col, whole numbers from 0, and a dark"),
        (outside_the_frame, "charge.defects: no photosite (12, 2) in a frame of 12 × 16"),
        (outside_the_folder, "charge.defects.hot: '../hot.csv' lies outside this file's folder; put it there"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(mistake: Callable[[], None], sentence: str, bias: np.ndarray) -> None:
    mistake()
    refused_in_a_sentence("mine.yaml", sentence)
