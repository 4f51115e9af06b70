"""From lux to electrons, against anchors and against an integration of its own kind."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
import scipy.constants
import scipy.integrate
import scipy.interpolate

from camsim.api import load_camera
from camsim.config.library import shipped
from camsim.errors import InvalidValueError
from camsim.optics import Airy
from camsim.sensor.adc import Adc
from camsim.sensor.exposure import (
    auto_time_s,
    sensor_irradiance_w_per_m2_nm,
)
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light, LightSamples
from tests.truth import electrons as truth

colour = colour_science()
# A smooth hump per photon, reaching into the infrared: peak 0.64 at 530 nm.


def photons_per_um2_s(samples: LightSamples, first_nm: float, last_nm: float) -> float:
    counted = (samples.wavelength_nm >= first_nm) & (samples.wavelength_nm <= last_nm)
    return float(np.sum((samples.weight_nm * samples.photons_per_um2_s_nm)[counted]))


@pytest.mark.parametrize(("name", "photons"), [("D55", 1.407e4), ("D65", 1.391e4), ("A", 2.107e4)])
def test_one_lux_of_an_illuminant(name: str, photons: float) -> None:
    """The anchors are sums over the whole nanometres 380 to 780, each of which stands for half a one on either side."""
    samples = Light(name, illuminance_lux=1.0).samples([Curve((379.5, 780.5), (1.0, 1.0))])
    assert photons_per_um2_s(samples, 379.5, 780.5) == pytest.approx(photons, rel=5e-4)


def test_one_lux_of_a_line() -> None:
    """At 555 nm: 1/683.002 W/m² over hc/λ = 3.5792e-19 J."""
    samples = Light(line_nm=555.0, illuminance_lux=1.0).samples()
    assert len(samples.wavelength_nm) == 1
    assert photons_per_um2_s(samples, 555.0, 555.0) == pytest.approx(4090.7, rel=1e-5)


def test_a_line_where_the_eye_sees_little_needs_more_power() -> None:
    """V(650 nm) = 0.107: as many lux take 1/0.107 times the watts."""
    green = Light(line_nm=555.0, illuminance_lux=3.0).samples().irradiance_w_per_m2_nm[0]
    red = Light(line_nm=650.0, illuminance_lux=3.0).samples().irradiance_w_per_m2_nm[0]
    assert green / red == pytest.approx(0.107, rel=1e-9)


def lux_of(samples: LightSamples, irradiance: np.ndarray[Any, Any]) -> float:
    """Illuminance through the ȳ of the 1931 observer, which is V(λ) by definition, splined."""
    y_bar = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    v = scipy.interpolate.CubicSpline(y_bar.wavelengths, y_bar.values[:, 1])(samples.wavelength_nm)
    inside = (samples.wavelength_nm >= 360.0) & (samples.wavelength_nm <= 830.0)
    return 683.0 * float(np.sum((samples.weight_nm * irradiance * v)[inside]))


def test_a_grey_card_in_5000_lux_at_f8() -> None:
    samples = Light("D55", illuminance_lux=5000.0).samples()
    irradiance = sensor_irradiance_w_per_m2_nm(samples, f_number=8.0, transmission=1.0)
    assert lux_of(samples, 0.18 * irradiance) == pytest.approx(3.516, rel=2e-4)


@pytest.mark.parametrize("light", ["D50", "FL11", "LED-B3"])
def test_every_light_has_the_lux_that_were_asked_for(light: str) -> None:
    samples = Light(light, illuminance_lux=750.0).samples()
    assert lux_of(samples, samples.irradiance_w_per_m2_nm) == pytest.approx(750.0, rel=1e-4)


@pytest.mark.parametrize("f_number", [1.4, 22.0])
def test_the_sensor_sees_the_solid_angle_of_the_lens(f_number: float) -> None:
    """E = ∫ L·cosθ dΩ over the cone with sinθ = 1/2N, L = E_scene/π: integrated over the angle."""
    samples = Light(line_nm=550.0, illuminance_lux=1.0).samples()
    radiance = samples.irradiance_w_per_m2_nm[0] / math.pi
    cone, _ = scipy.integrate.quad(
        lambda theta: 2 * math.pi * math.sin(theta) * math.cos(theta), 0.0, math.asin(0.5 / f_number)
    )
    on_sensor = sensor_irradiance_w_per_m2_nm(samples, f_number=f_number, transmission=0.8)[0]
    assert on_sensor == pytest.approx(0.8 * radiance * cone, rel=1e-9)


@pytest.mark.parametrize("sensor", sorted(set(shipped("sensor")) - {"paper-488"}))
def test_electrons_of_every_profile(sensor: str) -> None:
    """6 illuminants × 2 f-numbers, 0.1 %, from the pitch in the file to electrons."""
    for f_number in (1.4, 16.0):
        camera = load_camera(sensor, lens=Airy(f_number=f_number))
        by_hand = functools.partial(
            truth.efficiency,
            {letter: (table.wavelength_nm, table.values) for letter, table in camera.quantum_efficiency.curves},
            camera.cfa.channels,
            per_energy=camera.quantum_efficiency.per == "energy",
            peak=camera.quantum_efficiency.peak,
            filters=[(table.wavelength_nm, table.values) for table in camera.filters],
        )
        for light in ("D55", "D65", "A", "E", "FL2", "LED-B3"):
            expected = truth.electrons(
                colour,
                light,
                by_hand,
                lambda nm: 0.5 * np.ones_like(nm),
                lux=320.0,
                f_number=f_number,
                area_um2=camera.pitch_um**2,
                time_s=0.02,
            )
            samples = camera.samples(Light(light, illuminance_lux=320.0))
            electrons = 0.5 * camera.electrons_per_reflectance(samples, 0.02).sum(axis=1)
            np.testing.assert_allclose(electrons, expected, rtol=1e-3, err_msg=f"{light}, f/{f_number}")


def test_the_papers_sensor_sees_one_wavelength() -> None:
    """Every photon of 550 nm and of no other: 1 nm of a flat light, counted by hand."""
    camera = load_camera("paper-488", lens=Airy(f_number=2.0))
    samples = camera.samples(Light(Curve((400.0, 700.0), (1.0, 1.0)), irradiance_w_per_m2=300.0))
    photons = 1.0 / 16.0 * 550e-9 / (scipy.constants.h * scipy.constants.c) * (4.88e-6) ** 2
    assert camera.electrons_per_reflectance(samples, 1.0).sum() == pytest.approx(photons, rel=1e-9)


@pytest.mark.parametrize("full_well_e", [None, 20_000.0])
def test_auto_puts_a_perfect_diffuser_at_80_percent_of_black_to_white(full_well_e: float | None) -> None:
    adc = Adc(bit_depth=12, black_level_dn=128, electrons_per_dn=10.0, base_iso=200.0)
    per_second = np.array([3e5, 9e5, 6e5])
    time_s = auto_time_s(per_second, level_e=0.8 * adc.saturation_e(400.0, full_well_e))
    codes = adc.quantise(per_second * time_s, iso=400.0)
    white_dn = 4095 if full_well_e is None else 128 + min(3967, 20_000 // 5)
    assert abs(float(codes.max()) - (128 + 0.8 * (white_dn - 128))) <= 0.5
    assert codes.tolist().index(codes.max()) == 1


def test_auto_without_any_signal_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="no channel of the sensor responds"):
        auto_time_s(np.zeros(3), level_e=1e4)
    for per_second, way in ((1e-6, "more"), (1e14, "less")):
        with pytest.raises(InvalidValueError, match=rf"auto would be .* s in this light, .*give {way} light"):
            auto_time_s(np.array([per_second, 0.0]), level_e=8e3)


def test_a_blackbody_has_plancks_spectrum() -> None:
    """Ratios of photon numbers by the law in frequency, n ~ ν²/(e^(hν/kT) − 1) per Hz, times c/λ² per nm."""
    samples = Light(blackbody_k=3000.0, illuminance_lux=100.0).samples()
    nu = scipy.constants.c / (samples.wavelength_nm * 1e-9)
    photons = nu**2 / np.expm1(scipy.constants.h * nu / (scipy.constants.k * 3000.0)) / samples.wavelength_nm**2
    ratio = samples.photons_per_um2_s_nm / photons
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)
    assert lux_of(samples, samples.irradiance_w_per_m2_nm) == pytest.approx(100.0, rel=1e-4)


def test_a_line_has_its_width() -> None:
    samples = Light(line_nm=632.8, width_nm=2.0, irradiance_w_per_m2=5.0).samples()
    power = samples.weight_nm * samples.irradiance_w_per_m2_nm
    assert power.sum() == pytest.approx(5.0, rel=1e-12)
    # Of a normal distribution of this half-width the variance is 4/(8 ln 2).
    variance = power @ (samples.wavelength_nm - 632.8) ** 2 / 5.0
    assert variance == pytest.approx(4.0 / (8.0 * math.log(2.0)), rel=1e-6)


def test_luminance_of_a_perfect_diffuser() -> None:
    """1000 cd/m² through f/4: π·1000/(4·16) lx on the sensor, by the camera equation in photometric units."""
    samples = Light("D65", luminance_cd_per_m2=1000.0).samples()
    on_sensor = sensor_irradiance_w_per_m2_nm(samples, f_number=4.0, transmission=1.0)
    assert lux_of(samples, on_sensor) == pytest.approx(math.pi * 1000.0 / 64.0, rel=1e-4)


@pytest.mark.parametrize("f_number", [1.0, 22.0])
def test_light_on_the_sensor_passes_no_lens(f_number: float) -> None:
    samples = Light("A", illuminance_lux=2.0, at="sensor").samples()
    on_sensor = sensor_irradiance_w_per_m2_nm(samples, f_number=f_number, transmission=0.1)
    assert lux_of(samples, on_sensor) == pytest.approx(2.0, rel=1e-4)


def test_the_coolest_blackbody() -> None:
    samples = Light(blackbody_k=500.0, irradiance_w_per_m2=1.0).samples()
    assert samples.wavelength_nm[-1] == pytest.approx(1100.0, abs=0.6)
