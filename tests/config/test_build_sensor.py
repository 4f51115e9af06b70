"""Every key of a sensor and of what is before it reaches its stage, and what is wrong there is told."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import camsim
from camsim.api import load
from camsim.core.errors import ConfigError

pytestmark = pytest.mark.usefixtures("folder")

CHARGE = """sensor.charge={
  prnu: 0.01, crosstalk: [[0, 0.01, 0], [0.01, 0.96, 0.01], [0, 0.01, 0]],
  defects: {hot_fraction: 0.001, hot_e_per_s: 50, dead_fraction: 0.002, hot: [{row: 1, col: 2, e_per_s: 3}],
            dead: [[4, 5]]},
  dark_current_e_per_s: 2, dark_current_at_c: -10, dark_current_doubles_every_c: 6, dcnu: 0.3,
  shot_noise: false, full_well_e: 20000, blooming: 0.5,
  nonlinearity: {kind: polynomial, coefficients: [-0.01, 0.002], scale_e: 20000}, dsnu_e: 0.5}"""
READOUT = """sensor.readout={
  bit_depth: 14, black_level_dn: 100, base_iso: 100, electrons_per_dn: 2,
  reset_noise_e: 1, read_noise_e: 2, read_noise_student_dof: 6,
  read_noise_spread: 0.2, telegraph_noise: {fraction: 0.01, amplitude_e: 7},
  row_noise_e: 3, flicker_rows: {sigma_e: 4, exponent: 1.5}, column_noise_e: 5,
  dual_gain: {from_iso: 800, full_well_e: 5000, read_noise_e: 1}, output_noise_dn: 0.5}"""


def override(text: str) -> str:
    return " ".join(text.split())


def test_every_electronic_stage_arrives() -> None:
    camera = load("good.yaml", overrides=[override(CHARGE), override(READOUT)]).camera
    expected = {
        "prnu": camsim.Prnu(0.01),
        "crosstalk": camsim.Crosstalk(((0, 0.01, 0), (0.01, 0.96, 0.01), (0, 0.01, 0))),
        "defects": camsim.Defects(
            hot_fraction=0.001, hot_e_per_s=50.0, dead_fraction=0.002, hot=((1, 2, 3.0),), dead=((4, 5),)
        ),
        "dark_current": camsim.DarkCurrent(2.0, 0.3, -10.0, 6.0),
        "shot_noise": None,
        "full_well": camsim.FullWell(20000.0),
        "blooming": camsim.Blooming(0.5),
        "nonlinearity": camsim.PolynomialResponse((-0.01, 0.002), 20000.0),
        "dsnu": camsim.Dsnu(0.5),
        "reset_noise": camsim.ResetNoise(1.0),
        "read_noise": camsim.ReadNoise(2.0, student_dof=6.0, spread=0.2),
        "telegraph_noise": camsim.TelegraphNoise(fraction=0.01, amplitude_e=7.0),
        "row_noise": camsim.RowNoise(3.0),
        "flicker_rows": camsim.FlickerRows(4.0, 1.5),
        "column_noise": camsim.ColumnNoise(5.0),
        "dual_gain": camsim.DualGain(from_iso=800.0, capacity_e=5000.0, read_noise_e=1.0),
        "output_noise": camsim.OutputNoise(0.5),
    }
    assert {name: getattr(camera, name) for name in expected} == expected


def test_a_table_of_responses() -> None:
    table = "{kind: table, electrons_in: [0, 10000, 20000], electrons_out: [0, 9900, 19500]}"
    camera = load("good.yaml", overrides=[f"sensor.charge.nonlinearity={table}"]).camera
    assert camera.nonlinearity == camsim.ResponseTable((0.0, 1e4, 2e4), (0.0, 9900.0, 19500.0))


ONE = "{wavelength_nm: [300, 1100], values: [1, 1]}"


@pytest.mark.parametrize(
    ("cfa", "pattern"),
    [
        ("{kind: quad-bayer, pattern: GBRG}", ("GGBB", "GGBB", "RRGG", "RRGG")),
        ("{kind: quad-bayer, pattern: RGGB, group: 4}", ("RRRRGGGG",) * 4 + ("GGGGBBBB",) * 4),
        ("{kind: x-trans}", ("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG")),
        ("{kind: rgbw}", ("WBWG", "BWGW", "WGWR", "GWRW")),
        ("{kind: ryyb}", ("RY", "YB")),
        ("{kind: cygm}", ("CY", "GM")),
        ("{kind: letters, pattern: [RGB, eab]}", ("RGB", "eab")),
    ],
)
def test_every_array(cfa: str, pattern: tuple[str, ...]) -> None:
    letters = sorted(set("".join(pattern)))
    curves = "{" + ", ".join(f"{letter}: {ONE}" for letter in letters) + "}"
    overrides = [f"sensor.cfa={cfa}", f"sensor.quantum_efficiency={{curves: {curves}, per: photon, peak: 0.5}}"]
    assert load("good.yaml", overrides=overrides).camera.cfa.pattern == pattern


def test_what_is_before_the_sensor() -> None:
    setup = load(
        "good.yaml",
        overrides=[
            "lens.magnification=0.5",
            f"lens.filters=[0.5, {ONE}]",
            "lens.falloff={kind: cos4, exit_pupil_mm: 50}",
            "sensor.filters=[0.25]",
            "exposure.temperature_c=-10",
            "noise.frame_number=3",
        ],
    )
    camera = setup.camera
    assert (camera.magnification, camera.working_f_number) == (0.5, 12.0)
    assert camera.filters == (0.5, camsim.Curve((300.0, 1100.0), (1.0, 1.0), outside="zero"), 0.25)
    assert camera.falloff == camsim.Cos4Falloff(exit_pupil_mm=50.0)
    assert (setup.exposure.temperature_c, setup.frame_number) == (-10.0, 3)
    radial = "lens.falloff={kind: radial, radius_mm: [0, 10], values: [1, 0.5]}"
    expected = camsim.RadialFalloff(radius_mm=(0.0, 10.0), values=(1.0, 0.5))
    assert load("good.yaml", overrides=[radial]).camera.falloff == expected


@pytest.mark.parametrize(
    ("light", "expected"),
    [
        ("{blackbody_k: 3000, illuminance_lux: 10}", camsim.Light(blackbody_k=3000.0, illuminance_lux=10.0)),
        (
            "{line_nm: 532, width_nm: 2, irradiance_w_per_m2: 0.1}",
            camsim.Light(line_nm=532.0, width_nm=2.0, irradiance_w_per_m2=0.1),
        ),
        ("{illuminant: A, luminance_cd_per_m2: 100}", camsim.Light("A", luminance_cd_per_m2=100.0)),
        ("{illuminant: A, illuminance_lux: 5, at: sensor}", camsim.Light("A", illuminance_lux=5.0, at="sensor")),
        (
            "{table: {wavelength_nm: [400, 700], values: [1, 2]}, irradiance_w_per_m2: 3}",
            camsim.Light(camsim.Curve((400.0, 700.0), (1.0, 2.0)), irradiance_w_per_m2=3.0),
        ),
    ],
)
def test_every_light(light: str, expected: camsim.Light) -> None:
    assert load("good.yaml", overrides=[f"light={light}"]).light == expected


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (
            ["light={illuminant: D55}"],
            "--set light: light.illuminance_lux: missing; "
            "give illuminance_lux, irradiance_w_per_m2 or luminance_cd_per_m2",
        ),
        (
            ["light.irradiance_w_per_m2=1", "light.illuminance_lux=1"],
            "--set light.irradiance_w_per_m2: given together with 'illuminance_lux'; a light has one level, "
            "leave one of the two out",
        ),
        (
            ["light.blackbody_k=3000", "light.illuminant=A"],
            "--set light.blackbody_k: given together with 'illuminant'; a light has one spectrum, "
            "leave one of the two out",
        ),
        (["light.width_nm=3"], "--set light.width_nm: is a line's; there is no line_nm here"),
        (
            ["light={table: {wavelength_nm: [500, 400], values: [1, 1]}, illuminance_lux: 1}"],
            "--set light: light.table.wavelength_nm: 400 nm follows 500 nm; wavelengths must increase, each given once",
        ),
        (
            ["exposure.temperature_c=-300"],
            "--set exposure.temperature_c: must be a number from -273.15 to 1000, not -300 "
            "(of the sensor, °C; the one of its dark current when left out)",
        ),
        (
            ["lens.magnification=-1"],
            "--set lens.magnification: must be a number from 0 to 100, not -1 (image size over object size; "
            "the working f-number is f_number · (1 + magnification))",
        ),
        (
            ["sensor.filters=[60]"],
            "--set sensor.filters: filters.0: must be a number from 0 to 1 or a table "
            "{wavelength_nm, values, csv, column, outside}, not 60; a fraction: 60 % is 0.6",
        ),
        (
            ["sensor.charge.full_well_e=null", "sensor.charge.blooming=1"],
            "--set sensor.charge.blooming: there is no full_well_e that charge could spill over; give one",
        ),
        (
            ["sensor.charge.crosstalk=[[0, 0.1, 0], [0.1, 0.9, 0.1], [0, 0.1, 0]]"],
            "--set sensor.charge.crosstalk: adds up to 1.3; a photosite cannot give away more than it gets, at most 1",
        ),
        (
            ["sensor.charge.nonlinearity={kind: polynomial, coefficients: [-0.9], scale_e: 20000}"],
            "--set sensor.charge.nonlinearity: charge.nonlinearity.coefficients: [-0.9]; more charge must give more "
            "signal up to scale_e, but the response falls at 20000 e⁻",
        ),
        (
            ["sensor.cfa={kind: letters, pattern: [RG, B]}"],
            "--set sensor.cfa: cfa.pattern: rows of [1, 2] letters; all rows of a pattern are equally long",
        ),
        (
            ["sensor.cfa={kind: letters, pattern: [RG, GX]}"],
            "my.yaml:9:11: quantum_efficiency.curves: no curve for X of the cfa; there are R, G, B",
        ),
        (
            ["sensor.cfa={kind: letters, pattern: [R1, GB]}"],
            "--set sensor.cfa: cfa.pattern.0: must be letters, not 'R1'",
        ),
        (
            ["lens.falloff={kind: radial, radius_mm: [1, 2], values: [1, 0.5]}"],
            "--set lens.falloff: lens.falloff.radius_mm: [1.0, 2.0]; must begin at 0 and increase",
        ),
    ],
)
def test_a_fault_is_told_in_one_sentence(overrides: list[str], expected: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=overrides)
    assert str(caught.value).splitlines() == [expected]


def test_curves_must_cover_the_light(edited: Callable[..., None]) -> None:
    """D55 goes on from 700 nm to 830 nm, at about 72 (of 100 at 560 nm): 30 % of its photons."""
    curves = "{" + ", ".join(f"{c}: {{wavelength_nm: [300, 700], values: [1, 1]}}" for c in "RG")
    edited("Nikon 5100 (NPL)", curves + ", B: {wavelength_nm: [300, 700], values: [1, 1], outside: zero}}", sensor=True)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=["sensor.quantum_efficiency.per=photon"])
    first, second = str(caught.value).splitlines()
    assert first == (
        "my.yaml:9:15: quantum_efficiency.curves.R: 700..830 nm is missing, with 30 % of the photons of D55; "
        "extend the table, or say outside: zero (or hold)"
    )
    assert second.startswith("my.yaml:9:63: quantum_efficiency.curves.G: 700..830 nm is missing")
    # Behind an infrared cut nothing is missing any more.
    load("good.yaml", overrides=["light={line_nm: 550, illuminance_lux: 1}"])


def test_filters_must_cover_the_light() -> None:
    filters = "[{wavelength_nm: [400, 830], values: [1, 1]}]"
    with pytest.raises(ConfigError, match=r"lens.filters.0: 300..400 nm is missing, with 3.9 % of the photons"):
        load("good.yaml", overrides=[f"lens.filters={filters}"])
