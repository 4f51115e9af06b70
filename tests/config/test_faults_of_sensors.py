"""One mistake at a time in a good sensor, and the exact sentence that it gets."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from camsim.capturing import load
from camsim.errors import ConfigError

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
            "my.yaml:9:12: quantum_efficiency.curves.red: must be a channel, one letter",
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
