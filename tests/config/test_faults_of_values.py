"""Values: one mistake at a time in a good scene, and the exact sentence that it gets."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from camsim.api import load
from camsim.core.errors import ConfigError

REFLECTANCE = "a number from 0 to 1, a name or a table {wavelength_nm, values, csv, column, outside}"
OF_REFLECTANCE = "(fraction of the light that it returns; names: camsim list reflectances)"

# What is replaced in the good file of conftest.py, by what, and the messages.
FAULTS = {
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
            "scene.yaml:5:20: exposure.time_s: must be a number from 1e-09 to 1e+09 or auto, not 0 "
            "(seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "a word for the time": (
        "time_s: 0.01",
        "time_s: atuo",
        [
            "scene.yaml:5:20: exposure.time_s: must be a number from 1e-09 to 1e+09 or auto, not 'atuo'; did you mean "
            "'auto'? "
            "(seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "a table for the time": (
        "time_s: 0.01",
        "time_s: {seconds: 1}",
        [
            "scene.yaml:5:20: exposure.time_s: must be a number from 1e-09 to 1e+09 or auto, not a table "
            "(seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "a list for a transmission": (
        "f_number: 8",
        "f_number: 8, transmission: [1, 1]",
        [
            "scene.yaml:3:47: lens.transmission: must be a number from 0 to 1 "
            "or a table {wavelength_nm, values, csv, column, outside}, not a list of 2 "
            "(fraction of the light that passes)"
        ],
    ),
    "a word for a transmission": (
        "f_number: 8",
        "f_number: 8, transmission: clear",
        [
            "scene.yaml:3:47: lens.transmission: must be a number from 0 to 1 "
            "or a table {wavelength_nm, values, csv, column, outside}, not 'clear' (fraction of the light that passes)"
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
    "a date without all its digits": (
        "iso: 200",
        "iso: 200, datetime: 2001-2-3 4:05:06",
        [
            "scene.yaml:5:46: exposure.datetime: must be a date and time such as '2000-01-31 23:59:59', "
            "not '2001-2-3 4:05:06'"
        ],
    ),
    "negative light": (
        "illuminance_lux: 5000",
        "illuminance_lux: -1",
        ["scene.yaml:4:43: light.illuminance_lux: must be a number above 0, not -1 (level, lux)"],
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
            "scene.yaml:4:18: light.line_nm: must be a number from 360 to 830, not 1064, "
            "because a line that the eye does not see has no illuminance; give irradiance_w_per_m2"
        ],
    ),
    "unknown illuminant": (
        "illuminant: D55",
        "illuminant: D56",
        ["scene.yaml:4:21: light.illuminant: unknown illuminant 'D56'; did you mean 'D55' or 'D60' or 'D50'?"],
    ),
    "unknown reflectance": (
        "reflectance: dark skin",
        "reflectance: drak skin",
        ["scene.yaml:14:20: scene.shapes.1.reflectance: unknown reflectance 'drak skin'; did you mean 'dark skin'?"],
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
        [f"scene.yaml:9:29: scene.background.reflectance: must be {REFLECTANCE}, not a list of 1 {OF_REFLECTANCE}"],
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
        ["scene.yaml:15:80: scene.shapes.2.reflectance.values: 3 for 2 wavelengths; every point has one of each"],
    ),
    "wavelengths out of order": (
        "[400, 700]",
        "[700, 400]",
        [
            "scene.yaml:15:60: scene.shapes.2.reflectance.wavelength_nm: 400 nm follows 700 nm; "
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
            "scene.yaml:8:9: scene.unit: must be pixel, um, mm or frame, not 'px'; did you mean 'pixel'? "
            "(of all lengths in the scene; pixel is the sensor's pitch, frame the height of its full frame)"
        ],
    ),
    "a tolerance out of reach": (
        "tolerance: 1e-3",
        "tolerance: 1e-20",
        [
            "scene.yaml:16:21: render.tolerance: must be a number from 1e-11 to 0.01, not 1e-20 "
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
            ""
            "(known: astronomy-376, d40-like, machine-colour-345, medium-format-376, mono-345, my, paper-488, "
            "phone-080, pi-155, x-trans-376); your own lies beside the scene, in sensors there or in ../sensors, in "
            "--sensors DIR, or is named by its path"
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
            "scene.yaml:2:9: sensor: '../my.yaml' lies outside this file's folder; put it there or into ../sensors, "
            "or name it with --sensor"
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


@pytest.mark.parametrize(("old", "new", "expected"), FAULTS.values(), ids=FAULTS)
def test_a_fault_in_a_scene(
    edited: Callable[..., None],
    places_hold: Callable[[ConfigError], None],
    old: str,
    new: str,
    expected: list[str],
) -> None:
    edited(old, new)
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml")
    assert str(caught.value).splitlines() == expected
    places_hold(caught.value)
