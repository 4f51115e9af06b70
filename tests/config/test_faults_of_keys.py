"""Keys and types: one mistake at a time in a good scene, and the exact sentence that it gets."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from camsim.capturing import load
from camsim.errors import ConfigError

KINDS = (
    "rectangle, polygon, regular-polygon, star, disc, ellipse, ring, sector, half-plane, path, line, text, group, "
    "repeat-on-grid or repeat-on-ring"
)

# What is replaced in the good file of conftest.py, by what, and the messages.
KINDS = (
    "rectangle, polygon, regular-polygon, star, disc, ellipse, ring, sector, half-plane, path, line, text, group, "
    "repeat-on-grid, repeat-on-ring, chart or svg"
)

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
        ["scene.yaml:15:31: scene.shapes.2.width: unknown key; known here: kind, radius, centre, reflectance"],
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
        [
            "scene.yaml:1:1: lens: missing; "
            "a table of kind airy, annular, gaussian, wavefront, radial-otf, measured-psf or measured-otf (the lens)"
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
            "scene.yaml:3:14: lens.kind: must be airy, annular, gaussian, wavefront, radial-otf, measured-psf or "
            "measured-otf, not 'wavefrnt'; did you mean 'wavefront'?"
        ],
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
            "(focal length over aperture, as engraved on the lens)"
        ],
    ),
    "quoted number": (
        "seed: 1",
        "seed: '1'",
        ["scene.yaml:17:30: noise.seed: must be a whole number from 0 to 2^63 − 1, not '1' (same seed, same noise)"],
    ),
    "fraction for a whole number": (
        "rows: 20",
        "rows: 20.5",
        ["scene.yaml:6:16: region.rows: must be a whole number of 1 or more, not 20.5 (photosites from top to bottom)"],
    ),
    "yes for true": (
        "enabled: true",
        "enabled: yes",
        ["scene.yaml:17:18: noise.enabled: must be true or false, not 'yes' (false records the mean signal)"],
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
