"""The camera as a whole: what its stages make of light, exposure by exposure."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from electronics import EVERY as EXAMPLES

import camsim
from camsim.files.preview import develop
from camsim.sensor.colour_matrix import as_shot_neutral

FLAT = camsim.Curve((300.0, 1100.0), (1.0, 1.0))
ADC = camsim.Adc(bit_depth=14, black_level_dn=100, electrons_per_dn=1.0, base_iso=100.0)
LIGHT = camsim.Light(line_nm=550.0, irradiance_w_per_m2=0.1)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=100.0)
SCENE = camsim.Scene(background=0.5, shapes=[camsim.Rectangle(width_um=40.0, height_um=20.0, reflectance=0.1)])


def camera_of(letters: str = "Y", **stages: Any) -> camsim.Camera:
    cfa = camsim.Cfa((letters,))
    curves = tuple((letter, FLAT) for letter in cfa.channels)
    return camsim.Camera(
        rows=60,
        cols=80,
        pitch_um=4.0,
        lens=camsim.Airy(f_number=4.0),
        photosite=camsim.SquarePhotosite(side_um=4.0),
        cfa=cfa,
        quantum_efficiency=camsim.QuantumEfficiency(curves, per="photon", peak=0.5),
        adc=ADC,
    ).replace(**stages)


def exposed(camera: camsim.Camera, scene: camsim.Scene = SCENE, **how: Any) -> camsim.Frame:
    return camera.expose(scene, **({"light": LIGHT, "exposure": EXPOSURE, "tolerance": 1e-4} | how))


def test_a_magnified_image_is_dimmer_and_softer() -> None:
    """At 1:1 the lens works at twice its f-number: a quarter of the light, and the blur of that f-number."""
    far, near = exposed(camera_of()), exposed(camera_of(magnification=1.0))
    slow = exposed(camera_of(lens=camsim.Airy(f_number=8.0)))
    np.testing.assert_array_equal(near.mean_electrons, slow.mean_electrons)
    corner = (0, 0)
    assert near.mean_electrons[corner] == pytest.approx(far.mean_electrons[corner] / 4.0, rel=1e-3)
    assert near.f_number == 4.0
    assert "f_number=8.0" in near.report.optics[0]


def test_light_falls_off_from_the_axis_of_the_frame_not_of_the_window() -> None:
    falloff = camsim.Cos4Falloff(exit_pupil_mm=0.2)
    white = camsim.Scene(background=1.0)
    camera = camera_of("RG", falloff=falloff)
    whole = exposed(camera, white, noise=False, products=("mosaic", "truth"))
    window = exposed(camera, white, noise=False, region=camsim.Region(rows=7, cols=9, origin=(3, 51)))
    np.testing.assert_array_equal(window.mean_electrons, whole.mean_electrons[3:10, 51:60])
    even = exposed(camera.replace(falloff=None), white, noise=False).mean_electrons[0, 0]
    x_mm, y_mm = 4e-3 * (60.5 - 40), 4e-3 * (3.5 - 30)
    angle = math.atan(math.hypot(x_mm, y_mm) / 0.2)
    assert whole.mean_electrons[3, 60] == pytest.approx(even * math.cos(angle) ** 4, rel=1e-9)
    assert whole.truth is not None
    one = np.take_along_axis(whole.truth, whole.channel_index[..., None].astype(int), axis=2)[..., 0]
    np.testing.assert_allclose(one, whole.mean_electrons, rtol=1e-6)


@pytest.mark.parametrize("sensor", ["phone-080", "pi-155", "x-trans-376"])
def test_a_grey_card_has_the_white_balance_that_its_file_says(sensor: str) -> None:
    """After crosstalk: data numbers above black, channel by channel, and the preview is grey."""
    lopsided = ((0.0, 0.01, 0.0), (0.02, 0.92, 0.01), (0.0, 0.03, 0.0))
    camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=4.0))
    camera = camera.replace(crosstalk=camera.crosstalk or camsim.Crosstalk(lopsided))
    light = camsim.Light("D55", illuminance_lux=1000.0)
    frame = camera.expose(
        camsim.Scene(background=1.0),
        light=light,
        exposure=camsim.Exposure(time_s="auto", iso=camera.adc.base_iso),
        region=camsim.Region(rows=24, cols=24),
        noise=False,
        products=("mosaic", "truth"),
    )
    assert frame.truth is not None
    signal = frame.mosaic.astype(float) - frame.black_level_dn
    means = np.array([signal[frame.channel_index == k].mean() for k in range(3)])
    half_a_code = 0.5 / means.max()
    np.testing.assert_allclose(as_shot_neutral(frame.colour), means / means.max(), atol=2 * half_a_code)
    # The brightest channel is where "auto" puts it.
    white = frame.white_level_dn - frame.black_level_dn
    assert means.max() == pytest.approx(0.8 * white, abs=1.0)
    # The truth of a flat field is flat, up to what tells one row's greens from the other's.
    assert frame.truth.mean(axis=(0, 1)).max() == pytest.approx(0.8 * white * frame.electrons_per_dn, rel=1e-3)
    pixels = develop(frame)[4:-4, 4:-4].astype(int)
    assert np.ptp(pixels.reshape(-1, 3).mean(axis=0)) <= 1.0


def test_a_frames_signal_is_its_codes_less_the_black_of_each() -> None:
    """Below black the codes themselves, which are unsigned, would wrap; each photosite has its own black."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4.0))
    offsets = ((0, 3, 1), (5, 2, 4))
    camera = camera.replace(adc=dataclasses.replace(camera.adc, black_offsets_dn=offsets))
    iso = 2 * camera.adc.base_iso
    frame = camera.expose(
        camsim.Scene(background=0.0),
        light=camsim.Light("D55", illuminance_lux=1.0),
        exposure=camsim.Exposure(time_s=1e-3, iso=iso),
        region=camsim.Region(rows=41, cols=50, origin=(101, 202)),
    )
    assert frame.signal_dn.shape == frame.signal_e.shape == (41, 50)
    assert frame.signal_dn.dtype == frame.signal_e.dtype == np.float64
    for row, col in ((0, 0), (7, 8), (40, 49), (13, 2)):
        black = camera.adc.black_level_dn + offsets[(101 + row) % 2][(202 + col) % 3]
        assert frame.signal_dn[row, col] == int(frame.mosaic[row, col]) - black
    assert frame.signal_dn.min() < 0.0  # noise goes below black, and not to 65 535
    assert abs(frame.signal_dn.mean()) < 1.0
    np.testing.assert_allclose(frame.signal_e, frame.signal_dn * camera.adc.electrons_per_dn / 2, rtol=1e-15)


def test_more_frames_share_patterns_and_nothing_else() -> None:
    camera = camera_of(prnu=camsim.Prnu(0.05), dsnu=camsim.Dsnu(20.0), read_noise=camsim.ReadNoise(3.0))
    how: dict[str, Any] = {"light": LIGHT, "exposure": EXPOSURE, "tolerance": 1e-3, "seed": 5}
    frames = list(camsim.Capture(camera=camera, scene=camsim.Scene(background=0.9), **how).frames(3))
    assert [frame.frame_number for frame in frames] == [0, 1, 2]
    assert set(frames[0].report.seconds) == {"light", "render", "noise", "adc"}
    assert set(frames[1].report.seconds) == {"noise", "adc"}  # a frame's seconds are its own
    alone = camera.expose(camsim.Scene(background=0.9), frame_number=2, **how)
    np.testing.assert_array_equal(alone.mosaic, frames[2].mosaic)
    assert alone.description == frames[2].description
    first, second = (frame.electrons for frame in frames[:2])
    assert not np.array_equal(first, second)
    shared = np.cov(first.ravel(), second.ravel())[0, 1]
    pattern = (0.05 * first.mean()) ** 2 + 20.0**2
    assert shared == pytest.approx(pattern, rel=0.1)


def test_a_second_conversion_gain_takes_over_at_its_setting() -> None:
    dual = camsim.DualGain(from_iso=400.0, capacity_e=2000.0, read_noise_e=1.0)
    camera = camera_of(dual_gain=dual, read_noise=camsim.ReadNoise(9.0), full_well=camsim.FullWell(9000.0))
    low, high = camsim.Exposure(time_s=0.01, iso=399.0), camsim.Exposure(time_s=0.01, iso=400.0)
    frames = [exposed(camera, exposure=exposure) for exposure in (low, high)]
    assert [frame.read_noise_e for frame in frames] == [9.0, 1.0]
    assert camera.full_well_at(399.0) == camsim.FullWell(9000.0)
    bright = camsim.Light(line_nm=550.0, irradiance_w_per_m2=1e4)
    full = exposed(camera.replace(read_noise=None), light=bright, exposure=high)
    assert full.electrons.max() <= 2000.0 + 10.0
    assert full.white_level_dn == 100 + 8000


def test_all_noise_of_the_read_out_is_told() -> None:
    stages = {
        "read_noise": camsim.ReadNoise(3.0),
        "reset_noise": camsim.ResetNoise(4.0),
        "row_noise": camsim.RowNoise(12.0),
        "output_noise": camsim.OutputNoise(21.0),
    }
    frame = exposed(camera_of(**stages), exposure=camsim.Exposure(time_s=0.01, iso=25.0))
    # 21 DN of 4 e⁻ each; 3² + 4² + 12² + 84² = 85².
    assert frame.read_noise_e == pytest.approx(85.0, rel=1e-12)
    assert exposed(camera_of(**stages), noise=False).read_noise_e == 0.0


def test_the_report_names_the_stages_that_act() -> None:
    camera = camera_of(prnu=camsim.Prnu(0.01), full_well=camsim.FullWell(9e3), read_noise=camsim.ReadNoise(3.0))
    noisy, clean = exposed(camera).report.electronics, exposed(camera, noise=False).report.electronics
    assert noisy == ("Prnu(fraction=0.01)", "ShotNoise()", "FullWell(capacity_e=9000.0)", "ReadNoise(sigma_e=3.0)")
    assert clean == ("FullWell(capacity_e=9000.0)",)


def test_a_full_well_beyond_the_converter_is_noted() -> None:
    camera = camera_of(full_well=camsim.FullWell(40_000.0))
    (note,) = exposed(camera).report.notes
    assert note.code == "well-not-reached"
    assert note.text.startswith("the converter ends at 16283 e⁻, below the full well of 40000 e⁻")
    assert exposed(camera.replace(full_well=camsim.FullWell(16_000.0))).report.notes == ()


def test_temperature_is_the_exposures() -> None:
    camera = camera_of(dark_current=camsim.DarkCurrent(100.0, at_c=20.0, doubling_c=10.0), shot_noise=None)
    dark = camsim.Scene(background=0.0)
    warm = camsim.Exposure(time_s=10.0, iso=100.0, temperature_c=40.0)
    assert exposed(camera, dark, exposure=warm).electrons.max() == pytest.approx(4000.0, rel=1e-12)


EVERY: dict[str, Any] = EXAMPLES | {
    "offset_map": None,
    "filters": (0.9, FLAT),
    "magnification": 0.1,
    "falloff": camsim.RadialFalloff(radius_mm=(0.0, 1.0), values=(1.0, 0.5)),
    "veiling_glare": camsim.Curve((400.0, 700.0), (0.1, 0.05)),
    "defects": camsim.Defects(
        hot_fraction=0.01, hot_e_per_s=9.0, dead_fraction=0.01, hot=((1, 2, 3.0),), dead=((4, 5),)
    ),
    "dual_gain": camsim.DualGain(from_iso=800.0, capacity_e=500.0, read_noise_e=1.0),
}


@pytest.mark.parametrize(
    ("light", "exposure"),
    [
        (camsim.Light(line_nm=550.0, irradiance_w_per_m2=1e-12), camsim.Exposure(time_s=1e-6, iso=100.0)),
        (camsim.Light(line_nm=550.0, irradiance_w_per_m2=1e6), camsim.Exposure(time_s=3600.0, iso=1e6)),
        (LIGHT, camsim.Exposure(time_s=3600.0, iso=100.0, temperature_c=80.0)),
        (LIGHT, camsim.Exposure(time_s=3600.0, iso=100.0, temperature_c=-40.0)),
    ],
    ids=["nothing", "everything", "hot", "cold"],
)
@pytest.mark.parametrize(("bit_depth", "full_well_e"), [(1, 9e3), (16, 1.0)])
def test_extremes_are_right_or_clipped(light: Any, exposure: Any, bit_depth: int, full_well_e: float) -> None:
    adc = camsim.Adc(bit_depth=bit_depth, black_level_dn=0, electrons_per_dn=0.01, base_iso=100.0)
    quiet = {"read_noise": camsim.ReadNoise(0.0), "telegraph_noise": None, "dual_gain": None}
    well = {"full_well": camsim.FullWell(full_well_e), **quiet}
    frame = exposed(camera_of(**(EVERY | well), adc=adc), light=light, exposure=exposure)
    assert np.isfinite(frame.electrons).all()
    assert np.isfinite(frame.mean_electrons).all()
    assert frame.mean_electrons.min() >= 0.0
    # Only the noise of the read-out lies beyond the well.
    assert frame.electrons.max() < full_well_e + 150.0
    assert frame.mosaic.max() <= (1 << bit_depth) - 1
