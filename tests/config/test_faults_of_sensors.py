"""One mistake at a time in a good sensor, and the exact sentence that it gets."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from camsim.api import load
from camsim.core.errors import ConfigError

# What is replaced in the good file of conftest.py, by what, and the messages.
FAULTS = {
    "negative pitch": (
        "pitch_um: 4.0",
        "pitch_um: -4.0",
        [
            "my.yaml:4:41: frame.pitch_um: must be a number from 0.1 to 10000, not -4.0 "
            "(distance between centres of neighbouring photosites, µm)"
        ],
    ),
    "zero pitch": (
        "pitch_um: 4.0",
        "pitch_um: 0",
        [
            "my.yaml:4:41: frame.pitch_um: must be a number from 0.1 to 10000, not 0 "
            "(distance between centres of neighbouring photosites, µm)"
        ],
    ),
    "the unit of another key": (
        "read_noise_e: 3.0",
        "read_noise_dn: 3.0",
        ["my.yaml:13:85: readout.read_noise_dn: unknown key; did you mean 'read_noise_e'? (electrons, before gain)"],
    ),
    "unknown curves": (
        "Nikon 5100 (NPL)",
        "Nikon 5100",
        [
            "my.yaml:9:11: quantum_efficiency.curves: unknown sensitivity 'Nikon 5100'; "
            "did you mean 'Nikon 5100 (NPL)'? (known: Nikon 5100 (NPL), Sigma SDMerill (NPL))"
        ],
    ),
    "curves of other letters": (
        "Nikon 5100 (NPL)",
        "{Y: {wavelength_nm: [400, 700], values: [1, 1]}}",
        ["my.yaml:9:11: quantum_efficiency.curves: no curve for R, G, B of the cfa; there are Y"],
    ),
    "a channel that is no letter": (
        "Nikon 5100 (NPL)",
        "{red: {wavelength_nm: [400, 700], values: [1, 1]}}",
        [
            "my.yaml:9:11: quantum_efficiency.curves: no curve for R, G, B of the cfa; there are red",
            "my.yaml:9:12: quantum_efficiency.curves.red: must be a channel: one letter, Gr or Gb",
        ],
    ),
    "a curve below zero": (
        "Nikon 5100 (NPL)",
        "{R: {wavelength_nm: [400, 700], values: [1, -1]}}",
        ["my.yaml:9:55: quantum_efficiency.curves.R.values.1: must be a number of 0 or more, not -1"],
    ),
    "a peak in percent": (
        "peak: 0.5",
        "peak: 50",
        [
            "my.yaml:11:9: quantum_efficiency.peak: must be a number above 0 and at most 1 or 'as given', not 50; "
            "a fraction: 50 % is 0.5 (electrons per photon at the highest point of all channels; 'as given' of curves "
            "that are absolute, A/W where they are per energy)"
        ],
    ),
    "a pattern that is none": (
        "pattern: GRBG",
        "pattern: GGRB",
        [
            "my.yaml:7:29: cfa.pattern: must be RGGB, BGGR, GRBG or GBRG, not 'GGRB' "
            "(letters of photosites (0,0) (0,1) (1,0) (1,1))"
        ],
    ),
    "black above white": (
        "black_level_dn: 100",
        "black_level_dn: 4095",
        ["my.yaml:13:42: readout.black_level_dn: must be at most 4094, below the largest code of 12 bits, not 4095"],
    ),
    "a black level that no code is": (
        "black_level_dn: 100",
        "black_level_dn: 65535",
        [
            "my.yaml:13:42: readout.black_level_dn: must be a whole number from 0 to 65534, not 65535 "
            "(data number of no charge)"
        ],
    ),
    "colder than cold": (
        "dsnu_e: 0.5",
        "dark_current_at_c: -274",
        [
            "my.yaml:12:88: charge.dark_current_at_c: must be a number from -273.15 to 1000, not -274 "
            "(temperature at which dark_current_e_per_s holds, °C)"
        ],
    ),
    "a dark current's temperature without one": (
        "dark_current_e_per_s: 1.5",
        "dark_current_at_c: 60, dcnu: 0.2, dark_current_doubles_every_c: 6, defects: {hot_fraction: 0, hot_e_per_s: 9}",
        [
            f"my.yaml:12:{column}: charge.{key}: does nothing without dark_current_e_per_s; "
            "give that too, 0 where only hot photosites gather charge"
            for column, key in ((30, "dark_current_at_c"), (53, "dcnu"), (64, "dark_current_doubles_every_c"))
        ],
    ),
    "hot photosites without heat": (
        "dsnu_e: 0.5",
        "defects: {hot_fraction: 0.01}",
        ["my.yaml:12:93: charge.defects.hot_fraction: does nothing without hot_e_per_s; give that too"],
    ),
    "heat of no photosites": (
        "dsnu_e: 0.5",
        "defects: {hot_e_per_s: 90, dead_fraction: 0.01}",
        ["my.yaml:12:92: charge.defects.hot_e_per_s: does nothing without hot_fraction; give that too"],
    ),
    "a second gain that is the first": (
        "read_noise_e: 3.0",
        "read_noise_e: 3.0, dual_gain: {from_iso: 100}",
        [
            "my.yaml:13:126: readout.dual_gain.from_iso: neither full well nor read noise is given for this mode, "
            "which then is the other's; give one"
        ],
    ),
    "a high gain that holds more": (
        "read_noise_e: 3.0",
        "read_noise_e: 3.0, dual_gain: {from_iso: 400, full_well_e: 20001}",
        [
            "my.yaml:13:115: readout.dual_gain: holds 20001 e⁻, and the full well is 20000 e⁻; "
            "a high conversion gain holds less, give it no more"
        ],
    ),
    "two laws of read noise": (
        "read_noise_e: 3.0",
        "read_noise_e: 3.0, read_noise_student_dof: 5, read_noise_tukey_lambda: 0",
        [
            "my.yaml:13:156: readout.read_noise_tukey_lambda: given together with student_dof, another law; leave one "
            "of the two out"
        ],
    ),
    "tails of no read noise": (
        "read_noise_e: 3.0",
        "read_noise_student_dof: 5",
        ["my.yaml:13:85: readout.read_noise_student_dof: does nothing without read_noise_e; give that too"],
    ),
    "a gain of the base twice": (
        "read_noise_e: 3.0",
        "gain_at_iso: [{iso: 100, electrons_per_dn: 1}]",
        [
            "my.yaml:13:98: readout.gain_at_iso: has ISO 100, which is base_iso: its gain is electrons_per_dn; leave "
            "it out here"
        ],
    ),
    "gains that fall back": (
        "read_noise_e: 3.0",
        "gain_at_iso: [{iso: 800, electrons_per_dn: 1}, {iso: 400, electrons_per_dn: 2}]",
        ["my.yaml:13:98: readout.gain_at_iso: ISO 800, 400; must increase"],
    ),
    "17 bits": (
        "bit_depth: 12",
        "bit_depth: 17",
        ["my.yaml:13:22: readout.bit_depth: must be a whole number from 1 to 16, not 17 (bits of a data number)"],
    ),
    "no photosites": (
        "rows: 200",
        "rows: 0",
        ["my.yaml:4:15: frame.rows: must be a whole number of 1 or more, not 0 (photosites from top to bottom)"],
    ),
    "a scene where a sensor is wanted": (
        "camsim: sensor/1",
        "camsim: scene/1",
        ["my.yaml:1:9: camsim: this is a scene, where a sensor (sensor/1) is wanted"],
    ),
    "an OLPF without spots": (
        "split_um: 3.0",
        "split_um: 0",
        [
            "my.yaml:6:35: olpf.split_um: must be a number above 0, not 0 "
            "(full distance between two neighbouring spots, µm)"
        ],
    ),
}


@pytest.mark.parametrize(("old", "new", "expected"), FAULTS.values(), ids=FAULTS)
def test_a_fault_in_a_sensor(
    edited: Callable[..., None],
    places_hold: Callable[[ConfigError], None],
    old: str,
    new: str,
    expected: list[str],
) -> None:
    edited(old, new, sensor=True)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml")
    assert str(caught.value).splitlines() == expected
    places_hold(caught.value)


def test_none_given_is_not_left_out(edited: Callable[..., None]) -> None:
    """A study that goes down to 0 is no contradiction."""
    given = "dark_current_e_per_s: 0, dcnu: 0.1, defects: {hot_fraction: 0, hot_e_per_s: 90}"
    edited("dark_current_e_per_s: 1.5", given, sensor=True)
    assert load("good.yaml").camera.defects is not None
