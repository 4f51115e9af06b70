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
from camsim.core.errors import InvalidValueError, UnknownNameError
from camsim.optics import Airy
from camsim.sensor.adc import Adc
from camsim.sensor.exposure import (
    Exposure,
    auto_time_s,
    electrons_per_reflectance,
    sensor_irradiance_w_per_m2_nm,
)
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve, spectrum_at
from camsim.spectra.light import Light, LightSamples
from camsim.spectra.named import reflectance
from tests.truth import electrons as truth

colour = colour_science()
NIKON = QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.42)
# A smooth hump per photon, reaching into the infrared: peak 0.64 at 530 nm.
HUMP_NM = np.arange(350.0, 1051.0, 10.0)
HUMP = 0.64 * np.exp(-(((HUMP_NM - 530.0) / 190.0) ** 2))
MONO = QuantumEfficiency((("Y", Curve(tuple(HUMP_NM), tuple(HUMP))),), per="photon", peak=0.64)


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


@pytest.mark.parametrize("light", ["D50", "E", "FL11", "LED-B3", "HP1", "ISO 7589 Photoflood"])
def test_every_light_has_the_lux_that_were_asked_for(light: str) -> None:
    samples = Light(light, illuminance_lux=750.0).samples()
    assert lux_of(samples, samples.irradiance_w_per_m2_nm) == pytest.approx(750.0, rel=1e-4)


def test_a_narrow_peak_between_whole_nanometres_is_not_missed() -> None:
    """A triangle 0.2 nm wide at 632.8 nm is as good as a line there."""
    laser = Light(Curve((632.7, 632.8, 632.9), (0.0, 1.0, 0.0)), illuminance_lux=10.0).samples()
    line = Light(line_nm=632.8, illuminance_lux=10.0).samples()
    watts = float(np.sum(laser.weight_nm * laser.irradiance_w_per_m2_nm))
    assert watts == pytest.approx(float(line.irradiance_w_per_m2_nm[0]), rel=1e-3)


def test_infrared_that_a_table_holds_is_kept() -> None:
    """A flat table to 1100 nm: as many watts per nm there as in the green."""
    samples = Light(Curve((380.0, 1100.0), (1.0, 1.0)), illuminance_lux=10.0).samples()
    assert samples.wavelength_nm[-1] == pytest.approx(1100.0, abs=0.5)
    np.testing.assert_allclose(samples.irradiance_w_per_m2_nm, samples.irradiance_w_per_m2_nm[0], rtol=1e-12)


@pytest.mark.parametrize("f_number", [1.4, 2.0, 8.0, 22.0])
def test_the_sensor_sees_the_solid_angle_of_the_lens(f_number: float) -> None:
    """E = ∫ L·cosθ dΩ over the cone with sinθ = 1/2N, L = E_scene/π: integrated over the angle."""
    samples = Light(line_nm=550.0, illuminance_lux=1.0).samples()
    radiance = samples.irradiance_w_per_m2_nm[0] / math.pi
    cone, _ = scipy.integrate.quad(
        lambda theta: 2 * math.pi * math.sin(theta) * math.cos(theta), 0.0, math.asin(0.5 / f_number)
    )
    on_sensor = sensor_irradiance_w_per_m2_nm(samples, f_number=f_number, transmission=0.8)[0]
    assert on_sensor == pytest.approx(0.8 * radiance * cone, rel=1e-9)


@pytest.mark.parametrize("f_number", [1.4, 2.8, 8.0, 16.0])
@pytest.mark.parametrize("light", ["D55", "D65", "A", "E", "FL2", "LED-B3"])
@pytest.mark.parametrize("efficiency", [NIKON, MONO], ids=["bayer", "mono"])
@pytest.mark.parametrize("surface", [0.18, "orange"])
def test_electrons_against_an_independent_integration(
    efficiency: QuantumEfficiency, light: str, f_number: float, surface: float | str
) -> None:
    spectrum = reflectance(surface) if isinstance(surface, str) else surface
    samples = Light(light, illuminance_lux=5000.0).samples([spectrum], [curve for _, curve in efficiency.curves])
    per_reflectance = electrons_per_reflectance(
        samples,
        f_number=f_number,
        transmission=1.0,
        quantum_efficiency=efficiency,
        photosite_area_um2=4.88**2,
        time_s=0.01,
    )
    electrons = per_reflectance @ spectrum_at(spectrum, samples.wavelength_nm)
    expected = truth.electrons(
        colour,
        light,
        efficiency.at,
        lambda nm: spectrum_at(spectrum, nm),
        lux=5000.0,
        f_number=f_number,
        area_um2=4.88**2,
        time_s=0.01,
    )
    np.testing.assert_allclose(electrons, expected, rtol=1e-3)


@pytest.mark.parametrize("sensor", sorted(set(shipped("sensor")) - {"paper-488"}))
def test_electrons_of_every_profile(sensor: str) -> None:
    """6 illuminants × 4 f-numbers, 0.1 %, from the pitch in the file to electrons."""
    for f_number in (1.4, 2.8, 8.0, 16.0):
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


def test_a_transmission_curve_works_wavelength_by_wavelength() -> None:
    """A lens that is clear below 550 nm and opaque above leaves exactly the part of the sum below."""
    cut = Curve((300.0, 550.0, 550.5, 900.0), (1.0, 1.0, 0.0, 0.0))
    samples = Light("E", illuminance_lux=100.0).samples([cut])
    whole, part = (
        electrons_per_reflectance(
            samples,
            f_number=4.0,
            transmission=transmission,
            quantum_efficiency=MONO,
            photosite_area_um2=10.0,
            time_s=1.0,
        )
        for transmission in (1.0, cut)
    )
    below, above = samples.wavelength_nm <= 550.0, samples.wavelength_nm > 550.5
    np.testing.assert_array_equal(part[:, below], whole[:, below])
    assert not part[:, above].any()


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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"time_s": 0.0, "iso": 100.0}, "time_s: must be a number from 1e-09 to 1e.09 or 'auto', not 0.0"),
        ({"time_s": float("nan"), "iso": 100.0}, "time_s: .* not nan"),
        ({"time_s": "fast", "iso": 100.0}, "or 'auto'"),
        ({"time_s": 1.0, "iso": -100.0}, "iso: must be a number from 0.001 to .* not -100"),
        ({"time_s": "auto", "iso": 5e-324}, "iso: .* not 5e-324"),
        ({"time_s": 1.0, "iso": float("inf")}, "iso: .* not inf"),
        ({"time_s": 1.0, "iso": 100.0, "datetime": "yesterday"}, "datetime: .* not 'yesterday'"),
    ],
)
def test_an_impossible_exposure_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=message):
        Exposure(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"illuminance_lux": 1.0}, "give spectrum, line_nm or blackbody_k"),
        ({"spectrum": "D55"}, "a light has a level: give illuminance_lux, "),
        ({"spectrum": "D55", "illuminance_lux": 1.0, "irradiance_w_per_m2": 1.0}, "one level"),
        ({"spectrum": "D55", "blackbody_k": 3000.0, "illuminance_lux": 1.0}, "a light has one spectrum"),
        ({"blackbody_k": -5.0, "illuminance_lux": 1.0}, "blackbody_k: must be a number from 500"),
        ({"spectrum": "D55", "width_nm": 2.0, "illuminance_lux": 1.0}, "this light is no line"),
        ({"line_nm": 550.0, "width_nm": 300.0, "illuminance_lux": 1.0}, "a fifth of line_nm"),
        ({"line_nm": 5.0, "irradiance_w_per_m2": 1.0}, "line_nm: must be a number from 100 to 20000, not 5"),
        ({"spectrum": "D55", "luminance_cd_per_m2": 1.0, "at": "sensor"}, "on the sensor give illuminance_lux"),
        ({"spectrum": "D55", "line_nm": 550.0, "illuminance_lux": 1.0}, "a light has one spectrum"),
        ({"spectrum": "D55", "illuminance_lux": 0.0}, "illuminance_lux: .* not 0.0"),
        ({"spectrum": "D55", "illuminance_lux": float("inf")}, "illuminance_lux: .* not inf"),
        ({"line_nm": 1064.0, "illuminance_lux": 1.0}, "does not see has no illuminance"),
    ],
)
def test_an_impossible_light_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidValueError, match=message):
        Light(**arguments)


def test_a_light_without_anything_visible_cannot_have_lux() -> None:
    with pytest.raises(InvalidValueError, match="nothing that the eye sees"):
        Light(Curve((900.0, 1000.0), (1.0, 1.0)), illuminance_lux=1.0).samples()


def test_an_unknown_illuminant_is_told_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean"):
        Light("D555", illuminance_lux=1.0).samples()


def test_a_blackbody_has_plancks_spectrum() -> None:
    """Ratios of photon numbers by the law in frequency, n ~ ν²/(e^(hν/kT) − 1) per Hz, times c/λ² per nm."""
    samples = Light(blackbody_k=3000.0, illuminance_lux=100.0).samples()
    nu = scipy.constants.c / (samples.wavelength_nm * 1e-9)
    photons = nu**2 / np.expm1(scipy.constants.h * nu / (scipy.constants.k * 3000.0)) / samples.wavelength_nm**2
    ratio = samples.photons_per_um2_s_nm / photons
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)
    assert lux_of(samples, samples.irradiance_w_per_m2_nm) == pytest.approx(100.0, rel=1e-4)


def test_irradiance_is_the_watts_of_the_whole_table() -> None:
    table = Curve((500.0, 600.0, 1000.0), (2.0, 2.0, 2.0))
    samples = Light(table, irradiance_w_per_m2=3.0).samples()
    np.testing.assert_allclose(samples.irradiance_w_per_m2_nm, 3.0 / 500.0, rtol=1e-12)
    laser = Light(line_nm=1064.0, irradiance_w_per_m2=1e-3).samples()
    # 1 mW/m² over hc/λ = 1.867e-19 J.
    assert photons_per_um2_s(laser, 1064.0, 1064.0) == pytest.approx(1e-15 / 1.8669e-19, rel=1e-4)


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


def test_filters_multiply_wavelength_by_wavelength() -> None:
    """Two ramps: the photons that pass are the integral of their product, done here by hand on a flat light."""
    flat = Light(Curve((500.0, 600.0), (1.0, 1.0)), irradiance_w_per_m2=1.0)
    up, down = Curve((500.0, 600.0), (0.0, 1.0)), Curve((500.0, 600.0), (1.0, 0.0))
    one = QuantumEfficiency((("Y", Curve((400.0, 700.0), (1.0, 1.0))),), per="photon", peak=1.0)
    settings: dict[str, Any] = {
        "f_number": 1.0,
        "transmission": 1.0,
        "quantum_efficiency": one,
        "photosite_area_um2": 1.0,
        "time_s": 1.0,
    }
    both = electrons_per_reflectance(flat.samples([up], [down]), filters=(up, down, 0.5), **settings).sum()
    per_nm = 1.0 / 100.0 / 4.0 * 1e-21 / (scipy.constants.h * scipy.constants.c)  # × λ in nm: photons per µm²
    expected, _ = scipy.integrate.quad(lambda nm: 0.5 * (nm - 500) * (600 - nm) / 1e4 * nm * per_nm, 500, 600)
    assert both == pytest.approx(expected, rel=1e-9)

    assert both == pytest.approx(expected, rel=2e-4)


def test_a_table_that_is_held_lights_all_that_the_eye_sees() -> None:
    """1 at 500 and 600 nm is 1 from 360 to 830: equal energy, 683.002 lm/W times ∫V(λ)dλ = 106.857 nm (CIE 15)."""
    held = Light(Curve((500.0, 600.0), (1.0, 1.0), outside="hold"), illuminance_lux=683.002 * 106.857).samples()
    assert np.sum(held.weight_nm * held.irradiance_w_per_m2_nm) == pytest.approx(830.0 - 360.0, abs=1.5)
    np.testing.assert_allclose(held.irradiance_w_per_m2_nm, 1.0, rtol=1e-5)


def test_the_coolest_blackbody_and_none_below() -> None:
    samples = Light(blackbody_k=500.0, irradiance_w_per_m2=1.0).samples()
    assert samples.wavelength_nm[-1] == pytest.approx(1100.0, abs=0.6)
    with pytest.raises(InvalidValueError, match=r"blackbody_k: must be a number from 500 .* not 499.0"):
        Light(blackbody_k=499.0, irradiance_w_per_m2=1.0)
