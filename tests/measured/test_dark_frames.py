"""Real darks as the dark signal of a sensor: whose codes they are, one drawn at random, and taken again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from electronics import refused_in_a_sentence

import camsim
from camsim.errors import InputError
from camsim.files.reading import read_record
from camsim.measure.dark_frames import read_darks
from camsim.revive import revive_shot

SENSOR = """\
camsim: sensor/1
name: Mine
frame: {rows: 12, cols: 16, pitch_um: 4.0}
cfa: {kind: mono}
quantum_efficiency: {curves: {Y: {wavelength_nm: [380, 780], values: [0.5, 0.5]}}, per: photon, peak: as given}
charge: {shot_noise: false, dark_frames: darks}
readout: {bit_depth: 12, black_level_dn: 100, base_iso: 100, electrons_per_dn: 2.0}
"""


@pytest.fixture
def darks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> np.ndarray:
    """Five darks whose mean is a whole number, and a sensor beside them."""
    monkeypatch.chdir(tmp_path)
    codes = rng.integers(40, 60, (5, 12, 16)).astype(np.uint16)
    codes[0, 0] += ((50 * codes.size - int(codes.sum())) // 16 + np.zeros(16, int)).astype(np.uint16)
    codes[0, 1, 0] += np.uint16(50 * codes.size - int(codes.sum()))
    Path("darks").mkdir()
    for k, dark in enumerate(codes):
        np.save(f"darks/{k}.npy", dark)
    Path("mine.yaml").write_text(SENSOR, encoding="utf-8")
    return codes


def test_each_exposure_is_light_and_one_of_the_darks(darks: np.ndarray) -> None:
    sensor = camsim.Sensor.from_yaml("mine.yaml")
    seen = set()
    for seed in range(40):
        codes = sensor.expose(np.full((12, 16), 80.0), unit="electrons", seed=seed).mosaic.astype(int)
        match = [k for k, dark in enumerate(darks) if np.array_equal(codes, 100 + 40 + dark.astype(int) - 50)]
        assert len(match) == 1
        seen.add(match[0])
    assert seen == set(range(5))


def test_a_window_has_its_own_part_of_the_dark(darks: np.ndarray) -> None:
    sensor = camsim.Sensor.from_yaml("mine.yaml")
    whole = sensor.expose(np.zeros((12, 16)), unit="electrons", seed=3).mosaic
    region = camsim.Region(rows=5, cols=6, origin=(4, 7))
    part = sensor.expose(np.zeros((5, 6)), unit="electrons", seed=3, region=region).mosaic
    np.testing.assert_array_equal(part, whole[4:9, 7:13])


def test_it_is_taken_again_while_the_darks_are_there(darks: np.ndarray, tmp_path: Path) -> None:
    np.save("light.npy", np.full((12, 16), 80.0))
    shot = camsim.Sensor.from_yaml("mine.yaml").shot(camsim.read_light("light.npy", unit="electrons"), seed=7)
    frame = shot.frame()
    camsim.save(frame, "shot.dng")
    with Path("shot.dng").open("rb") as file:
        record = read_record(file, Path("shot.dng").stat().st_size)
    assert record is not None
    again = revive_shot(record.description, tmp_path)
    np.testing.assert_array_equal(again.frame().mosaic, frame.mosaic)  # type: ignore[union-attr]
    np.save("darks/0.npy", darks[1])
    with pytest.raises(InputError, match="are others than were taken, their numbers differ"):
        revive_shot(record.description, tmp_path)
    for path in Path("darks").iterdir():
        path.unlink()
    Path("darks").rmdir()
    with pytest.raises(InputError, match="not reproducible without the darks 'darks'; put them there"):
        revive_shot(record.description, tmp_path)


def no_folder() -> None:
    Path("mine.yaml").write_text(SENSOR.replace("darks", "night"), encoding="utf-8")


def outside() -> None:
    Path("mine.yaml").write_text(SENSOR.replace("darks", "../darks"), encoding="utf-8")


def nothing() -> None:
    for path in Path("darks").iterdir():
        path.unlink()


def another_camera() -> None:
    np.save("darks/7.npy", np.zeros((5, 5), np.uint16))


def twice() -> None:
    Path("mine.yaml").write_text(
        SENSOR.replace("dark_frames: darks", "dark_frames: darks, dsnu_e: 1"), encoding="utf-8"
    )


@pytest.mark.parametrize(
    ("mistake", "sentence"),
    [
        (no_folder, "mine.yaml:6:42: charge.dark_frames: "),
        (outside, "'../darks' lies outside this file's folder; put it there"),
        (nothing, "holds no raw file that can be read"),
        (another_camera, "has 5 × 5 photosites, and "),
        (twice, "mine.yaml:6:42: charge.dark_frames: have dsnu in them, which would be there twice; leave that out"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(mistake: Callable[[], None], sentence: str, darks: np.ndarray) -> None:
    mistake()
    refused_in_a_sentence("./mine.yaml", sentence)


def test_small_darks_are_repeated(darks: np.ndarray) -> None:
    sensor = camsim.Sensor.from_yaml("mine.yaml").replace(rows=24, cols=40)
    codes = sensor.expose(np.zeros((24, 40)), unit="electrons", seed=1).mosaic
    np.testing.assert_array_equal(codes[12:, 16:32], codes[:12, :16])
    assert read_darks(Path("darks"), "darks").shape == (12, 16)
