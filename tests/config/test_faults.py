"""One mistake at a time in a good file, and the exact sentence that it gets."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from camsim.capture import load
from camsim.errors import ConfigError

REFLECTANCE = "a number from 0 to 1, a name or a table {wavelength_nm, values, outside}"
OF_REFLECTANCE = "(fraction of the light that it returns; names: camsim list reflectances)"

# What is replaced in the good scene of conftest.py, by what, and the messages.
SCENE_FAULTS = {
    "unknown key": (
        "iso: 200",
        "iso: 200, is0: 3",
        [
            "scene.yaml:5:36: exposure.is0: unknown key; did you mean 'iso'? "
            "(ISO setting; the sensor's electrons_per_dn holds at its base_iso)"
        ],
    ),
    "unknown key of near meaning": (
        "rotate_deg: 4",
        "angle: 4",
        [
            "scene.yaml:11:62: scene.shapes.0.angle: unknown key; did you mean 'rotate_deg'? "
            "(clockwise as displayed, degrees)"
        ],
    ),
    "unknown key that belongs elsewhere": (
        "camsim: scene/1\n",
        "camsim: scene/1\nf_number: 8\n",
        ["scene.yaml:2:1: f_number: unknown key here; did you mean 'lens.f_number'?"],
    ),
    "unknown key, nothing near": (
        "tolerance: 1e-3",
        "tolerance: 1e-3, zzz: 1",
        ["scene.yaml:16:27: render.zzz: unknown key; known here: tolerance"],
    ),
    "key of another shape": (
        "radius: 3,",
        "radius: 3, width: 4,",
        [
            "scene.yaml:15:31: scene.shapes.2.width: unknown key; known here: kind, radius, centre, "
            "reflectance"
        ],
    ),
    "missing key": (
        "{time_s: 0.01, iso: 200}",
        "{time_s: 0.01}",
        [
            "scene.yaml:5:1: exposure.iso: missing; a number above 0 "
            "(ISO setting; the sensor's electrons_per_dn holds at its base_iso)"
        ],
    ),
    "missing table": (
        "lens: {kind: airy, f_number: 8}\n",
        "",
        ["scene.yaml:1:1: lens: missing; a table {kind, f_number, transmission} (the lens)"],
    ),
    "missing in a list": (
        "kind: disc, radius: 3",
        "kind: disc",
        ["scene.yaml:15:7: scene.shapes.2.radius: missing; a number above 0 (in the scene's unit)"],
    ),
    "missing kind": (
        "kind: disc, radius: 3",
        "radius: 3",
        ["scene.yaml:15:7: scene.shapes.2.kind: missing; rectangle, polygon or disc"],
    ),
    "unknown kind": (
        "kind: disc",
        "kind: disk",
        [
            "scene.yaml:15:14: scene.shapes.2.kind: must be rectangle, polygon or disc, not 'disk'; "
            "did you mean 'disc'?"
        ],
    ),
    "unknown kind of lens": (
        "kind: airy",
        "kind: wavefront",
        ["scene.yaml:3:14: lens.kind: must be airy, not 'wavefront' (what blurs the image)"],
    ),
    "word for a number": (
        "iso: 200",
        "iso: fast",
        [
            "scene.yaml:5:31: exposure.iso: must be a number above 0, not 'fast' "
            "(ISO setting; the sensor's electrons_per_dn holds at its base_iso)"
        ],
    ),
    "comma for a point": (
        "f_number: 8",
        "f_number: '5,6'",
        [
            "scene.yaml:3:30: lens.f_number: must be a number above 0, not '5,6' "
            "(working f-number, focal length over aperture)"
        ],
    ),
    "quoted number": (
        "seed: 1",
        "seed: '1'",
        [
            "scene.yaml:17:30: noise.seed: must be a whole number from 0 to 2^63 − 1, not '1' "
            "(same seed, same noise)"
        ],
    ),
    "fraction for a whole number": (
        "rows: 20",
        "rows: 20.5",
        [
            "scene.yaml:6:16: region.rows: must be a whole number of 1 or more, not 20.5 "
            "(photosites from top to bottom)"
        ],
    ),
    "yes for true": (
        "enabled: true",
        "enabled: yes",
        ["scene.yaml:17:18: noise.enabled: must be true or false, not 'yes' (false records the mean signal)"],
    ),
    "true for a number": (
        "seed: 1",
        "seed: true",
        [
            "scene.yaml:17:30: noise.seed: must be a whole number from 0 to 2^63 − 1, not true "
            "(same seed, same noise)"
        ],
    ),
    "list for a table": (
        "{tolerance: 1e-3}",
        "[1e-3]",
        [
            "scene.yaml:16:9: render: must be a table {tolerance}, not a list of 1 "
            "(how accurately the image is computed)"
        ],
    ),
    "table for a list": (
        "points: [[0, 0], [4, 0], [0, 4]]",
        "points: {x: 1}",
        [
            "scene.yaml:13:15: scene.shapes.1.points: must be a list of at least 3, not a table "
            "(corners [x, y] in order, in the scene's unit)"
        ],
    ),
    "nothing for a table": (
        "{tolerance: 1e-3}",
        "",
        [
            "scene.yaml:16:8: render: must be a table {tolerance}, not empty "
            "(how accurately the image is computed)"
        ],
    ),
    "NaN": (
        "width: 5",
        "width: .nan",
        [
            "scene.yaml:11:32: scene.shapes.0.width: must be a finite number above 0, not .nan "
            "(side along x before it is turned, in the scene's unit)"
        ],
    ),
    "infinity": (
        "rotate_deg: 4",
        "rotate_deg: -.inf",
        [
            "scene.yaml:11:74: scene.shapes.0.rotate_deg: must be a finite number, not -.inf "
            "(clockwise as displayed, degrees)"
        ],
    ),
    "a number too large": (
        "[4, 0]",
        "[4, 1e999]",
        ["scene.yaml:13:28: scene.shapes.1.points.1.1: must be a finite number, not 1e999"],
    ),
    "zero exposure": (
        "time_s: 0.01",
        "time_s: 0",
        [
            "scene.yaml:5:20: exposure.time_s: must be a number above 0 or auto, not 0 "
            "(seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "a word for the time": (
        "time_s: 0.01",
        "time_s: atuo",
        [
            "scene.yaml:5:20: exposure.time_s: must be a number above 0 or auto, not 'atuo'; did you mean "
            "'auto'? "
            "(seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "a date that is none": (
        "iso: 200",
        "iso: 200, datetime: 2001-02-30 00:00:00",
        [
            "scene.yaml:5:46: exposure.datetime: must be a date and time such as 2000-01-31 23:59:59, "
            "not '2001-02-30 00:00:00' (what files carry as their date)"
        ],
    ),
    "negative light": (
        "illuminance_lux: 5000",
        "illuminance_lux: -1",
        ["scene.yaml:4:43: light.illuminance_lux: must be a number above 0, not -1 (on the scene, lux)"],
    ),
    "two spectra": (
        "illuminant: D55",
        "illuminant: D55, line_nm: 550",
        [
            "scene.yaml:4:26: light.line_nm: given together with 'illuminant'; "
            "a light has one spectrum, leave one of the two out"
        ],
    ),
    "no spectrum": (
        "illuminant: D55, ",
        "",
        [
            "scene.yaml:4:1: light.illuminant: missing; "
            "give an illuminant such as D55, or line_nm for a single wavelength"
        ],
    ),
    "an invisible line": (
        "illuminant: D55",
        "line_nm: 1064",
        [
            "scene.yaml:4:18: light.line_nm: is 1064.0; must be 360..830 nm, "
            "because a line that the eye does not see has no illuminance"
        ],
    ),
    "unknown illuminant": (
        "illuminant: D55",
        "illuminant: D56",
        [
            "scene.yaml:4:21: light.illuminant: unknown illuminant 'D56'; did you mean 'D75' or 'D65' or "
            "'D60'?"
        ],
    ),
    "unknown reflectance": (
        "reflectance: dark skin",
        "reflectance: drak skin",
        [
            "scene.yaml:14:20: scene.shapes.1.reflectance: unknown reflectance 'drak skin'; "
            "did you mean 'dark skin'?"
        ],
    ),
    "percent for a fraction": (
        "reflectance: 0.05",
        "reflectance: 18",
        [
            f"scene.yaml:11:90: scene.shapes.0.reflectance: must be {REFLECTANCE}, not 18; "
            f"a fraction: 18 % is 0.18 {OF_REFLECTANCE}"
        ],
    ),
    "a list for a reflectance": (
        "{reflectance: 0.9}",
        "{reflectance: [0.9]}",
        [
            f"scene.yaml:9:29: scene.background.reflectance: must be {REFLECTANCE}, not a list of 1 "
            f"{OF_REFLECTANCE}"
        ],
    ),
    "percent in a table": (
        "values: [0.1, 0.8]",
        "values: [10, 80]",
        [
            "scene.yaml:15:81: scene.shapes.2.reflectance.values.0: must be a number from 0 to 1, not 10; "
            "a fraction: 10 % is 0.1",
            "scene.yaml:15:85: scene.shapes.2.reflectance.values.1: must be a number from 0 to 1, not 80; "
            "a fraction: 80 % is 0.8",
        ],
    ),
    "wavelengths and values of two lengths": (
        "[0.1, 0.8]",
        "[0.1, 0.8, 0.9]",
        [
            "scene.yaml:15:44: scene.shapes.2.reflectance: 2 wavelengths but 3 values; "
            "every point has one of each"
        ],
    ),
    "wavelengths out of order": (
        "[400, 700]",
        "[700, 400]",
        [
            "scene.yaml:15:44: scene.shapes.2.reflectance: 400 nm follows 700 nm; "
            "wavelengths must increase, each given once"
        ],
    ),
    "two points": (
        "[[0, 0], [4, 0], [0, 4]]",
        "[[0, 0], [4, 0]]",
        [
            "scene.yaml:13:15: scene.shapes.1.points: must be a list of at least 3, not a list of 2 "
            "(corners [x, y] in order, in the scene's unit)"
        ],
    ),
    "two different points": (
        "[[0, 0], [4, 0], [0, 4]]",
        "[[0, 0], [4, 0], [4, 0]]",
        ["scene.yaml:13:15: scene.shapes.1.points: 2 different points make no polygon; give at least 3"],
    ),
    "a point of one number": (
        "[4, 0]",
        "[4]",
        ["scene.yaml:13:24: scene.shapes.1.points.1: must be a point [x, y], not a list of 1"],
    ),
    "a point of three numbers": (
        "[4, 0]",
        "[4, 0, 0]",
        ["scene.yaml:13:24: scene.shapes.1.points.1: must be a point [x, y], not a list of 3"],
    ),
    # In the file's own unit: the photosites of this sensor are 4 µm wide.
    "an outline that crosses itself": (
        "[[0, 0], [4, 0], [0, 4]]",
        "[[0, 0], [4, 4], [4, 0], [0, 4]]",
        [
            "scene.yaml:13:15: scene.shapes.1.points: the outline crosses itself at (2, 2); "
            "list the corners in order round the shape"
        ],
    ),
    "unknown unit": (
        "unit: pixel",
        "unit: px",
        [
            "scene.yaml:8:9: scene.unit: must be pixel, um or mm, not 'px' "
            "(of all lengths in the scene; pixel is the sensor's pitch)"
        ],
    ),
    "a tolerance out of reach": (
        "tolerance: 1e-3",
        "tolerance: 1e-20",
        [
            "scene.yaml:16:21: render.tolerance: must be a number from 1e-09 to 0.01, not 1e-20 "
            "(largest error of any photosite, a fraction of the brightest surface)"
        ],
    ),
    "a region larger than the sensor": (
        "cols: 24",
        "cols: 301",
        ["scene.yaml:6:26: region.cols: is 301; the sensor has 300 cols"],
    ),
    "a region beyond the edge": (
        "cols: 24",
        "cols: 24, origin: [190, 0]",
        ["scene.yaml:6:38: region.origin: puts the last of the rows at 209; the sensor's are 0 to 199"],
    ),
    "a negative origin": (
        "cols: 24",
        "cols: 24, origin: [-1, 0]",
        ["scene.yaml:6:39: region.origin.0: must be a whole number of 0 or more, not -1"],
    ),
    "unknown sensor": (
        "sensor: my.yaml",
        "sensor: d40like",
        [
            "scene.yaml:2:9: sensor: unknown sensor 'd40like'; did you mean 'd40-like'? "
            "(known: d40-like, mono-345); a file of your own needs its path, such as ./my.yaml"
        ],
    ),
    "missing sensor file": (
        "sensor: my.yaml",
        "sensor: mine.yaml",
        ["scene.yaml:2:9: sensor: no such file: 'mine.yaml'"],
    ),
    "a sensor outside the folder": (
        "sensor: my.yaml",
        "sensor: ../my.yaml",
        [
            "scene.yaml:2:9: sensor: '../my.yaml' lies outside this file's folder; "
            "put it there or name it with --sensor"
        ],
    ),
    "no sensor": (
        "sensor: my.yaml\n",
        "",
        ["scene.yaml:1:1: sensor: missing; name one (camsim list sensors) or use --sensor"],
    ),
    "a scene for a sensor": (
        "sensor: my.yaml",
        "sensor: good.yaml",
        ["good.yaml:1:9: camsim: this is a scene, where a sensor (sensor/1) is wanted"],
    ),
    "a newer format": (
        "camsim: scene/1",
        "camsim: scene/2",
        ["scene.yaml:1:9: camsim: scene/2 is newer than this camsim, which reads scene/1; update camsim"],
    ),
    "no format": (
        "camsim: scene/1\n",
        "",
        ["scene.yaml:1:1: camsim: missing; begin the file with 'camsim: scene/1'"],
    ),
    "another program's format": (
        "camsim: scene/1",
        "camsim: 1",
        ["scene.yaml:1:9: camsim: must be scene/1, not 1; mend the file for scene/1"],
    ),
}

SENSOR_FAULTS = {
    "negative pitch": (
        "pitch_um: 4.0",
        "pitch_um: -4.0",
        [
            "my.yaml:4:41: frame.pitch_um: must be a number above 0, not -4.0 "
            "(distance between centres of neighbouring photosites, µm)"
        ],
    ),
    "zero pitch": (
        "pitch_um: 4.0",
        "pitch_um: 0",
        [
            "my.yaml:4:41: frame.pitch_um: must be a number above 0, not 0 "
            "(distance between centres of neighbouring photosites, µm)"
        ],
    ),
    "the unit of another key": (
        "read_noise_e: 3.0",
        "read_noise_dn: 3.0",
        [
            "my.yaml:13:85: readout.read_noise_dn: unknown key; did you mean 'read_noise_e'? "
            "(electrons, before gain)"
        ],
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
            "my.yaml:11:9: quantum_efficiency.peak: must be a number above 0 and at most 1, not 50; "
            "a fraction: 50 % is 0.5 (electrons per photon at the highest point of all channels)"
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
        [
            "my.yaml:13:42: readout.black_level_dn: is 4095; must be 0..4094, below the largest code of 12 "
            "bits"
        ],
    ),
    "17 bits": (
        "bit_depth: 12",
        "bit_depth: 17",
        [
            "my.yaml:13:22: readout.bit_depth: must be a whole number from 1 to 16, not 17 "
            "(bits of a data number)"
        ],
    ),
    "no photosites": (
        "rows: 200",
        "rows: 0",
        [
            "my.yaml:4:15: frame.rows: must be a whole number of 1 or more, not 0 "
            "(photosites from top to bottom)"
        ],
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


def check_places(error: ConfigError) -> None:
    """Look at the file where a message points to: there stands the key or the value that it speaks of."""
    for fault in error.faults:
        there = Path(fault.file).read_text(encoding="utf-8").splitlines()[fault.line - 1][fault.column - 1 :]
        value = re.search(r"must be .*, not '?([^';( ]+)", fault.message)
        if "unknown key" in fault.message:
            assert there.startswith(fault.key.rpartition(".")[2]), fault
        elif value and value[1] not in ("a", "empty"):
            assert there.lstrip("'").startswith(value[1]), fault


@pytest.mark.parametrize(("old", "new", "expected"), SCENE_FAULTS.values(), ids=SCENE_FAULTS)
def test_a_fault_in_a_scene(edited: Callable[..., None], old: str, new: str, expected: list[str]) -> None:
    edited(old, new)
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml")
    assert str(caught.value).splitlines() == expected
    check_places(caught.value)


@pytest.mark.parametrize(("old", "new", "expected"), SENSOR_FAULTS.values(), ids=SENSOR_FAULTS)
def test_a_fault_in_a_sensor(edited: Callable[..., None], old: str, new: str, expected: list[str]) -> None:
    edited(old, new, sensor=True)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml")
    assert str(caught.value).splitlines() == expected
    check_places(caught.value)


def test_the_good_files_have_no_faults(folder: Path) -> None:
    assert load("good.yaml").name == "good"


@pytest.mark.parametrize("text", ["", "# nothing\n"])
def test_an_empty_file(folder: Path, text: str) -> None:
    (folder / "scene.yaml").write_text(text)
    with pytest.raises(ConfigError, match=r"the file is empty; begin it with 'camsim: scene/1'$"):
        load("scene.yaml")


@pytest.mark.parametrize("text", ["just words\n", "- 1\n", "3"])
def test_a_file_that_holds_no_table(folder: Path, text: str) -> None:
    (folder / "scene.yaml").write_text(text)
    wanted = "scene.yaml:1:1: must be a table of keys and values; begin it with 'camsim: scene/1'"
    with pytest.raises(ConfigError, match=f"^{re.escape(wanted)}$"):
        load("scene.yaml")


def test_all_faults_of_both_files_and_the_command_line_at_once(folder: Path) -> None:
    """Also what only the stages see (a crossing, unknown names) when the schema has faults of its own."""
    (folder / "scene.yaml").write_text(
        "camsim: scene/1\n"
        "sensor: my.yaml\n"
        "lens: {kind: airy, f_number: 8, transmission: {wavelength_nm: [500, 400], values: [1, 1]}}\n"
        "light: {illuminant: D99, illuminance_lux: 0}\n"
        "exposure: {time_s: &t 0.01, iso: 200}\n"
        "exposure: {}\n"
        "scene:\n"
        "  unit: pixel\n"
        "  background: {reflectance: drak skin}\n"
        "  shapes:\n"
        "    - {kind: polygon, points: [[0, 0], [1, 1], [1, 0], [0, 1]], reflectance: blue skky}\n"
        "    - {kind: disc, radius: -1, reflectance: 0}\n"
    )
    sensor = (folder / "my.yaml").read_text()
    (folder / "my.yaml").write_text(sensor.replace("(NPL)", "").replace("pitch_um: 4.0", "pitch_um: 0"))
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml", overrides=["nonsense", "noise.seed=-1"], seed=-3)
    assert [(fault.file, fault.line, fault.column, fault.key) for fault in caught.value.faults] == [
        ("--set nonsense", 0, 0, ""),
        ("--seed", 0, 0, ""),
        ("--set noise.seed", 0, 0, ""),
        ("scene.yaml", 3, 47, "lens.transmission"),
        ("scene.yaml", 4, 21, "light.illuminant"),
        ("scene.yaml", 4, 43, "light.illuminance_lux"),
        ("scene.yaml", 5, 20, "exposure.time_s"),
        ("scene.yaml", 6, 1, "exposure"),
        ("scene.yaml", 9, 29, "scene.background.reflectance"),
        ("scene.yaml", 11, 31, "scene.shapes.0.points"),
        ("scene.yaml", 11, 78, "scene.shapes.0.reflectance"),
        ("scene.yaml", 12, 28, "scene.shapes.1.radius"),
        ("my.yaml", 4, 41, "frame.pitch_um"),
        ("my.yaml", 9, 11, "quantum_efficiency.curves"),
    ]
