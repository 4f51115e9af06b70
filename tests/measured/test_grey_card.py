"""A grey card through the finished pipeline: electrons and codes that an integration written here expects."""

import numpy as np
import pytest
from scipy import constants, integrate, interpolate
from tolerances import STATISTICAL

import camsim
from camsim.spectra.colour_science import colour_science

LUMENS_PER_WATT = 683.002  # at 555 nm in air


def spline(distribution):
    """Return colour-science's own table as a function: smooth and without overshoot, 0 outside."""
    curve = interpolate.PchipInterpolator(distribution.wavelengths, distribution.values, extrapolate=False)
    return lambda nm: np.nan_to_num(curve(nm))


def card_electrons(light, efficiency, *, reflectance, lux, f_number, area_um2, time_s):
    """Mean electrons: watts from lux, a Lambertian card, the camera equation, photons from watts, efficiency."""
    colour = colour_science()
    power = spline(colour.SDS_ILLUMINANTS[light])
    eye = spline(colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"])
    nm = np.linspace(300.0, 830.0, 5301)
    watts_per_m2_nm = power(nm) * lux / (LUMENS_PER_WATT * integrate.simpson(power(nm) * eye(nm), x=nm))
    radiance = reflectance * watts_per_m2_nm / np.pi
    on_sensor = radiance * np.pi / (4 * f_number**2)
    photons_per_m2_nm = on_sensor * time_s * nm * 1e-9 / (constants.h * constants.c)
    return integrate.simpson(photons_per_m2_nm * efficiency(nm), x=nm) * area_um2 * 1e-12


def nikon_efficiency(channel):
    """Electrons per photon from a relative response per energy; 0.42 at the highest point of all channels."""
    table = colour_science().MSDS_CAMERA_SENSITIVITIES["Nikon 5100 (NPL)"]
    per_photon = table.values / table.wavelengths[:, None]
    curve = interpolate.PchipInterpolator(
        table.wavelengths, 0.42 / per_photon.max() * table.values[:, channel], extrapolate=False
    )
    return lambda nm: np.nan_to_num(curve(nm)) / nm


@pytest.mark.parametrize(
    ("light", "lux", "f_number"), [("D55", 5000.0, 8.0), ("D65", 12_000.0, 2.0), ("A", 800.0, 8.0)]
)
def test_mean_electrons_of_every_channel(light, lux, f_number):
    frame = camsim.capture(
        "flat-field",
        sensor="d40-like",
        overrides=[
            f"light.illuminant={light}",
            f"light.illuminance_lux={lux}",
            f"lens.f_number={f_number}",
            "region.rows=6",
            "region.cols=8",
            "noise.enabled=false",
        ],
    )
    assert frame.channels == ("R", "G", "B")
    for k, signal in enumerate(frame.report.signal):
        expected_e = card_electrons(
            light,
            nikon_efficiency(k),
            reflectance=0.18,
            lux=lux,
            f_number=f_number,
            area_um2=4.88**2,
            time_s=0.01,
        )
        one = frame.mean_electrons[frame.channel_index == k]
        np.testing.assert_allclose(one, expected_e, rtol=1e-3)
        assert signal.mean_e == pytest.approx(expected_e, rel=1e-3)


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
