"""A grey card through the finished pipeline: electrons and codes that an integration written here expects."""

import numpy as np
import pytest
from tolerances import STATISTICAL

import camsim


def test_a_fill_factor_and_a_lens_that_absorbs_take_their_share():
    overrides = ["region.rows=4", "region.cols=4", "noise.enabled=false"]
    whole = camsim.capture("flat-field", overrides=overrides)
    part = camsim.capture(
        "flat-field", overrides=[*overrides, "lens.transmission=0.8", "sensor.photosite.fill_factor=0.5"]
    )
    np.testing.assert_allclose(part.mean_electrons, 0.4 * whole.mean_electrons, rtol=1e-12)


def test_a_line_of_light_on_a_mono_sensor():
    """1 lux of 555 nm is 4090.7 photons/µm²/s (RENDERING, section 5)."""
    frame = camsim.capture(
        "flat-field",
        sensor="mono-345",
        overrides=[
            "light.illuminant=null",
            "light.line_nm=555",
            "light.illuminance_lux=1000",
            "region.rows=4",
            "region.cols=4",
            "noise.enabled=false",
        ],
    )
    # Efficiency 0.64 at the peak of 525 nm; the table gives 0.98 at 550 and 0.95 at 575 nm of it.
    efficiency = 0.64 * (0.98 + (0.95 - 0.98) * 5 / 25)
    expected_e = 4090.7 * 1000 * 0.18 / (4 * 8.0**2) * 3.45**2 * 0.01 * efficiency
    np.testing.assert_allclose(frame.mean_electrons, expected_e, rtol=1e-4)


@pytest.mark.parametrize("sensor", ["d40-like", "mono-345"])
def test_without_noise_the_codes_are_the_rounded_mean(sensor):
    frame = camsim.capture(
        "slanted-edge",
        sensor=sensor,
        overrides=["region.rows=40", "region.cols=40", "region.origin=[860, 1370]", "noise.enabled=false"]
        if sensor == "d40-like"
        else ["region.rows=40", "region.cols=40", "region.origin=[884, 1090]", "noise.enabled=false"],
    )
    step_e, black = {"d40-like": (10.0, 128), "mono-345": (2.7 * 100 / 200, 64)}[sensor]
    assert frame.black_level_dn == black
    well_e = {"d40-like": 40_000.0, "mono-345": 10_700.0}[sensor]
    codes = [black + round(min(e, well_e) / step_e) for e in frame.mean_electrons.ravel().tolist()]
    np.testing.assert_array_equal(frame.mosaic.ravel(), np.minimum(codes, 4095))
    assert np.unique(frame.mosaic).size > 100  # the corner of the square lies in the window


def test_with_noise_the_codes_scatter_about_the_mean():
    """Over the window, by the variance that shot noise, read noise, fixed patterns and rounding add up to."""
    frame = camsim.capture("flat-field", seed=5, overrides=["region.rows=120", "region.cols=160"])
    for k in range(3):
        here = frame.channel_index == k
        mean_e = frame.mean_electrons[here][0]
        electrons = (frame.mosaic[here].astype(float) - 128) * 10.0
        variance = mean_e + 0.005 + 9.0**2 + 0.4**2 + (0.006 * mean_e) ** 2 + 10.0**2 / 12
        n = electrons.size
        assert abs(electrons.mean() - mean_e) <= STATISTICAL * np.sqrt(variance / n) + 0.005
        assert abs(electrons.var() / variance - 1) <= STATISTICAL * np.sqrt(2 / n)
