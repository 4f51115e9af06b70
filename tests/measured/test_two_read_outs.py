"""Both conversion gains read of one exposure: two images and the merged one, by what chance alone gives."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import rawpy
from tolerances import STATISTICAL

import camsim
from camsim.config.from_record import shot_from_record
from camsim.errors import InvalidValueError
from camsim.files.reading import read_record

LOW_E, HIGH_E = 8.0, 0.5
"""Electrons per data number."""
READ_LOW_E, READ_HIGH_E = 12.0, 1.5
DUAL = camsim.DualGain(electrons_per_dn=HIGH_E, read_noise_e=READ_HIGH_E)
SENSOR = camsim.Sensor(
    rows=128, cols=192, pitch_um=4.0, cfa=camsim.Cfa.mono(), photosite=camsim.SquarePhotosite(side_um=4.0),
    quantum_efficiency=camsim.Sensor.from_yaml("mono-345").quantum_efficiency,
    adc=camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=LOW_E, base_iso=100),
    full_well=camsim.FullWell(30_000.0), read_noise=camsim.ReadNoise(READ_LOW_E), dual_gain=DUAL,
)  # fmt: skip


def image(read: str, light: float | np.ndarray, seed: int = 5, **more: object) -> camsim.Frame:
    sensor = SENSOR.replace(dual_gain=dataclasses.replace(DUAL, read=read), **more)  # type: ignore[arg-type]
    electrons = np.broadcast_to(light, (sensor.rows, sensor.cols))
    return sensor.expose(np.array(electrons), unit="electrons", seed=seed)


def test_two_images_share_the_charge_and_nothing_of_the_read_out() -> None:
    """At 1000 e⁻ photons scatter by 32 e⁻: the covariance of both is theirs, and the rest each one's own."""
    low, high = (image(read, 1000.0).signal_e.ravel() for read in ("low", "high"))
    count = low.size
    covariance = np.cov(low, high)
    rounding = LOW_E**2 / 12, HIGH_E**2 / 12
    for k, one in enumerate((READ_LOW_E**2 + rounding[0], READ_HIGH_E**2 + rounding[1])):
        variance = 1000.0 + one
        assert abs(covariance[k, k] - variance) < STATISTICAL * variance * np.sqrt(2 / count)
    assert abs(covariance[0, 1] - 1000.0) < STATISTICAL * 1100.0 * np.sqrt(2 / count)
    apart = (low - high).var()
    want = READ_LOW_E**2 + READ_HIGH_E**2 + sum(rounding)
    assert abs(apart - want) < STATISTICAL * want * np.sqrt(2 / count)
    again = image("high", 1000.0, shot_noise=None).signal_e.ravel() - 1000.0
    other = image("low", 1000.0, shot_noise=None).signal_e.ravel() - 1000.0
    assert abs(np.corrcoef(again, other)[0, 1]) < STATISTICAL / np.sqrt(count)


def test_levels_of_each_image() -> None:
    low, high, merged = (image(read, 1e6) for read in ("low", "high", "merged"))
    assert (low.bit_depth, low.electrons_per_dn, low.white_level_dn) == (12, LOW_E, 100 + 3750)
    assert (high.bit_depth, high.electrons_per_dn, high.white_level_dn) == (12, HIGH_E, 4095)
    assert (merged.bit_depth, merged.electrons_per_dn, merged.white_level_dn) == (16, HIGH_E, 100 + 60_000)
    assert (low.read_noise_e, high.read_noise_e, merged.read_noise_e) == (READ_LOW_E, READ_HIGH_E, READ_HIGH_E)
    assert image("low", 0.0).report.signal[0].mean_e == 0.0


def test_the_merged_image_is_the_high_gain_and_beyond_90_percent_the_low_one() -> None:
    """Plain NumPy takes one or the other of the two images' codes."""
    light = np.tile(np.geomspace(10.0, 40_000.0, 192), (128, 1))
    low, high, merged = (image(read, light) for read in ("low", "high", "merged"))
    white_e = (4095 - 100) * HIGH_E
    want = np.where(high.signal_e < 0.9 * white_e, high.signal_e, low.signal_e)
    np.testing.assert_array_equal(merged.signal_e, want)
    np.testing.assert_array_equal(merged.mosaic, np.rint(want / HIGH_E + 100))
    assert merged.report.work["random_numbers"] == low.report.work["random_numbers"] * 2
    clipped = merged.report.signal[0].clipped_photosites
    assert clipped == low.report.signal[0].clipped_photosites < high.report.signal[0].clipped_photosites


def test_a_range_that_16_bits_cannot_hold_is_made_coarser() -> None:
    dual = dataclasses.replace(DUAL, electrons_per_dn=0.2)
    frame = SENSOR.replace(dual_gain=dual, full_well=None).expose(np.full((8, 8), 1e6), unit="electrons")
    assert frame.electrons_per_dn == pytest.approx(3995 * LOW_E / 65435)
    assert (frame.mosaic > 65_500).all()


def test_the_gain_follows_the_iso_setting() -> None:
    sensor = SENSOR.replace(dual_gain=dataclasses.replace(DUAL, read="high"))
    frame = sensor.expose(np.full((8, 8), 100.0), unit="electrons", exposure=camsim.Exposure(time_s=0.01, iso=400))
    assert frame.electrons_per_dn == HIGH_E / 4


def test_the_merged_image_is_clipped_where_the_low_gain_is() -> None:
    """At ISO 400 its converter ends at 3995 data numbers of 2 e⁻, far below the well."""
    exposure = camsim.Exposure(time_s=0.01, iso=400)
    for well in (camsim.FullWell(30_000.0), None):
        frame = SENSOR.replace(full_well=well).expose(np.full((8, 8), 9000.0), unit="electrons", exposure=exposure)
        assert frame.white_level_dn == 100 + 3995 * 2.0 / (HIGH_E / 4)
        assert (frame.mosaic == frame.white_level_dn).all()
        assert frame.report.signal[0].clipped_photosites == 64


def test_a_smaller_well_ends_the_high_gain_alone() -> None:
    dual = dataclasses.replace(DUAL, capacity_e=1500.0)
    frames = [
        SENSOR.replace(dual_gain=dataclasses.replace(dual, read=read)).expose(
            np.full((32, 32), 9000.0), unit="electrons", noise=False
        )
        for read in ("low", "high", "merged")
    ]
    assert [frame.signal_e.mean() for frame in frames] == [9000.0, 1500.0, 9000.0]


def test_a_scene_and_its_windows_have_them_too(tmp_path: Path) -> None:
    """Row by row into a DNG, which raw programs open; and again from its record."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4.0)).replace(
        dual_gain=camsim.DualGain(electrons_per_dn=0.3, read_noise_e=1.0)
    )
    how = {"light": camsim.Light("D55", illuminance_lux=900), "exposure": camsim.Exposure(time_s=0.01, iso=100)}
    region = camsim.Region(rows=160, cols=64)
    frame = camera.expose(camsim.Scene(background=0.5), **how, region=region, seed=3)  # type: ignore[arg-type]
    assert frame.bit_depth == 16
    frame.save(tmp_path / "merged.dng")
    with rawpy.imread(str(tmp_path / "merged.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, frame.mosaic)
        assert raw.white_level == frame.white_level_dn > 4095
    with (tmp_path / "merged.dng").open("rb") as file:
        record = read_record(file, (tmp_path / "merged.dng").stat().st_size)
    assert record is not None
    np.testing.assert_array_equal(shot_from_record(record.description).frame().mosaic, frame.mosaic)


def test_noise_for_loops_takes_one_image() -> None:
    with pytest.raises(InvalidValueError, match=r"Noise.sensor: merges two read-outs; give one"):
        camsim.Noise(SENSOR)
    low, high = (
        camsim.Noise(SENSOR.replace(dual_gain=dataclasses.replace(DUAL, read=read))) for read in ("low", "high")
    )
    light = np.full((3, 128, 192), 500.0)
    apart = (low(light, seed=1) - high(light, seed=1)).var()
    want = READ_LOW_E**2 + READ_HIGH_E**2
    assert abs(apart - want) < STATISTICAL * want * np.sqrt(2 / light.size)


def test_companding_is_refused_with_it() -> None:
    adc = dataclasses.replace(SENSOR.adc, companding=((0, 0), (4095, 1023)))
    with pytest.raises(InvalidValueError, match=r"dual_gain: reads both gains, whose codes are not companded"):
        SENSOR.replace(adc=adc)
