"""Keys and types: one mistake at a time in a good scene, and the exact sentence that it gets."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from camsim.api import load
from camsim.core.errors import ConfigError

KINDS = (
    "rectangle, polygon, regular-polygon, star, disc, ellipse, ring, sector, half-plane, path, line, text, group, "
    "repeat-on-grid, repeat-on-ring, chart, svg, picture, point-source, linear-gradient, radial-gradient, "
    "sine-grating, sine-star or sine-zone-plate"
)

# What is replaced in the good file of conftest.py, by what, and the messages.
FAULTS = {
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
        ["scene.yaml:16:27: render.zzz: unknown key; known here: tolerance, method, strict"],
    ),
    "key of another shape": (
        "radius: 3,",
        "radius: 3, width: 4,",
        [
            "scene.yaml:15:31: scene.shapes.2.width: unknown key of this kind; it is one of kind rectangle, line, "
            "chart, svg, picture, linear-gradient or sine-grating"
        ],
    ),
    "missing key": (
        "{time_s: 0.01, iso: 200}",
        "{time_s: 0.01}",
        [
            "scene.yaml:5:1: exposure.iso: missing; a number from 0.001 to 1e+09 "
            "(ISO setting; the sensor's electrons_per_dn holds at its base_iso)"
        ],
    ),
    "missing table": (
        "lens: {kind: airy, f_number: 8}\n",
        "",
        [
            "scene.yaml:1:1: lens: missing; "
            "a table of kind airy, annular-airy, gaussian, elliptical-gaussian, wavefront, field, radial-otf, "
            "measured-psf or measured-otf (the lens)"
        ],
    ),
    "missing in a list": (
        "kind: disc, radius: 3",
        "kind: disc",
        ["scene.yaml:15:7: scene.shapes.2.radius: missing; a number above 0 (in the scene's unit)"],
    ),
    "missing kind": (
        "kind: disc, radius: 3",
        "radius: 3",
        [f"scene.yaml:15:7: scene.shapes.2.kind: missing; {KINDS}"],
    ),
    "unknown kind": (
        "kind: disc",
        "kind: disk",
        [f"scene.yaml:15:14: scene.shapes.2.kind: must be {KINDS}, not 'disk'; did you mean 'disc'?"],
    ),
    "unknown kind of lens": (
        "kind: airy",
        "kind: wavefrnt",
        [
            "scene.yaml:3:14: lens.kind: must be airy, annular-airy, gaussian, elliptical-gaussian, wavefront, "
            "field, radial-otf, measured-psf or measured-otf, not 'wavefrnt'; did you mean 'wavefront'?"
        ],
    ),
    "word for a number": (
        "iso: 200",
        "iso: fast",
        [
            "scene.yaml:5:31: exposure.iso: must be a number from 0.001 to 1e+09, not 'fast' "
            "(ISO setting; the sensor's electrons_per_dn holds at its base_iso)"
        ],
    ),
    "comma for a point": (
        "f_number: 8",
        "f_number: '5,6'",
        [
            "scene.yaml:3:30: lens.f_number: must be a number from 0.5 to 10000, not '5,6'; write 5.6, with a point "
            "(focal length over aperture, as engraved on the lens)"
        ],
    ),
    "quoted number": (
        "seed: 1",
        "seed: '1'",
        [
            "scene.yaml:17:30: noise.seed: must be a whole number from 0 to 2^63 − 1, not '1'; write it without quotes "
            "(same seed, same noise)"
        ],
    ),
    "a decimal comma between braces": (
        "f_number: 8",
        "f_number: 2,8",
        [
            "scene.yaml:3:32: lens.8: a comma ends the value of 'f_number', so 2,8 is read as 2; "
            "write 2.8, with a point",
        ],
    ),
    "a comma between thousands": (
        "illuminance_lux: 5000",
        "illuminance_lux: 5,000",
        [
            "scene.yaml:4:45: light.000: a comma ends the value of 'illuminance_lux', so 5,000 is read as 5; "
            "write 5000, or 5.000 with a point",
        ],
    ),
    "decimal commas in a point": (
        "centre: [1, 2]",
        "centre: [1,5, 2,5]",
        [
            "scene.yaml:11:54: scene.shapes.0.centre: must be a point [x, y], not a list of 4; "
            "a decimal number has a point, such as 1.5 (from the optical axis, in the scene's unit)"
        ],
    ),
    "nothing in a list": (
        "f_number: 8",
        "f_number: []",
        [
            "scene.yaml:3:30: lens.f_number: must be a number from 0.5 to 10000, not an empty list "
            "(focal length over aperture, as engraved on the lens)"
        ],
    ),
    "a unit": (
        "time_s: 0.01",
        "time_s: 10ms",
        [
            "scene.yaml:5:20: exposure.time_s: must be a number from 1e-09 to 1e+09 or auto, not '10ms'; "
            "write the number alone, its unit is fixed (seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "a fraction of a second": (
        "time_s: 0.01",
        "time_s: 1/100",
        [
            "scene.yaml:5:20: exposure.time_s: must be a number from 1e-09 to 1e+09 or auto, not '1/100'; write 0.01 "
            "(seconds; auto puts a perfect diffuser at 80 % of black..white)"
        ],
    ),
    "another word for the key of a kind": (
        "kind: airy",
        "type: airy",
        [
            "scene.yaml:3:1: lens.kind: missing; airy, annular-airy, gaussian, elliptical-gaussian, wavefront, "
            "field, radial-otf, measured-psf or measured-otf; write kind in place of 'type'"
        ],
    ),
    "a value for its table": (
        "background: {reflectance: 0.9}",
        "background: white 9.5",
        [
            "scene.yaml:9:15: scene.background: must be a table {reflectance}, not 'white 9.5'; write {reflectance: "
            "white 9.5} (everything that no shape covers)"
        ],
    ),
    "off for a table": (
        "noise: {enabled: true, seed: 1}",
        "noise: off",
        [
            "scene.yaml:17:8: noise: must be a table {enabled, seed, frame_number}, not 'off'; write {enabled: false} "
            "(the noise of this capture)"
        ],
    ),
    "percent for a name": (
        "reflectance: dark skin",
        "reflectance: 18 %",
        [
            "scene.yaml:14:20: scene.shapes.1.reflectance: unknown reflectance '18 %'; a fraction: 18 % is 0.18",
        ],
    ),
    "a needed key under another name": (
        "iso: 200",
        "ISO: 200",
        [
            "scene.yaml:5:26: exposure.ISO: unknown key; did you mean 'iso'? "
            "(ISO setting; the sensor's electrons_per_dn holds at its base_iso)"
        ],
    ),
    "another word for a kind": (
        "kind: disc, radius: 3,",
        "kind: circle, r: 3,",
        [
            f"scene.yaml:15:14: scene.shapes.2.kind: must be {KINDS}, not 'circle'; did you mean 'disc'?",
            "scene.yaml:15:22: scene.shapes.2.r: unknown key; did you mean 'radius'? (in the scene's unit)",
        ],
    ),
    "American English": (
        "centre: [1, 2]",
        "center: [1, 2]",
        [
            "scene.yaml:11:46: scene.shapes.0.center: unknown key; did you mean 'centre'? "
            "(from the optical axis, in the scene's unit)"
        ],
    ),
    "grey": (
        "reflectance: dark skin",
        "reflectance: grey",
        [
            "scene.yaml:14:20: scene.shapes.1.reflectance: unknown reflectance 'grey'; did you mean 'neutral 5' or "
            "'neutral 8' or 'neutral 3.5'?"
        ],
    ),
    "the beginning of a name": (
        "sensor: my.yaml",
        "sensor: d40",
        [
            "scene.yaml:2:9: sensor: unknown sensor 'd40'; did you mean 'd40-like'? (known: astronomy-376, d40-like, "
            "machine-colour-345, medium-format-376, mono-345, my, paper-488, phone-080, pi-155, x-trans-376); your own "
            "lies beside the scene, in sensors there or in ../sensors, in --sensors DIR, or is named by its path"
        ],
    ),
    "fraction for a whole number": (
        "rows: 20",
        "rows: 20.5",
        ["scene.yaml:6:16: region.rows: must be a whole number of 1 or more, not 20.5 (photosites from top to bottom)"],
    ),
    "yes for true": (
        "enabled: true",
        "enabled: yes",
        [
            "scene.yaml:17:18: noise.enabled: must be true or false, not 'yes'; write true "
            "(false records the mean signal)"
        ],
    ),
    "true for a number": (
        "seed: 1",
        "seed: true",
        ["scene.yaml:17:30: noise.seed: must be a whole number from 0 to 2^63 − 1, not true (same seed, same noise)"],
    ),
    "list for a table": (
        "{tolerance: 1e-3}",
        "[1e-3]",
        [
            "scene.yaml:16:9: render: must be a table {tolerance, method, strict}, not a list of 1 "
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
            "scene.yaml:16:8: render: must be a table {tolerance, method, strict}, not empty "
            "(how accurately the image is computed)"
        ],
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
