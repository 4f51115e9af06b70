"""Whole files: none wrong, all wrong, nothing in them."""

import random
import re
from pathlib import Path
from typing import Any

import pytest

from camsim.api import load
from camsim.config.tree import MOST_FAULTS, Document
from camsim.errors import ConfigError, Fault

VALUES = """\
null | true | 0 | -1 | 1e400 | .nan | [] | {} | [1, 2] | '' | auto | mono | disc | pixel |
[[0, 0], [1, 1], [1, 0]] | {kind: disc} | {wavelength_nm: [1], values: []} | 99999999999999999999999 | {x: 1} |
[[[[]]]] | {kind: [1]} | {Y: 3} | dark skin | {[1]: 2} | *a | &b 3 | !c 4 | sensor/1"""
KEYS = """\
camsim | sensor | lens | lens.kind | lens.transmission.wavelength_nm | light | light.illuminant | light.line_nm |
exposure.time_s | exposure.datetime | region | region.origin | region.rows | scene | scene.unit | scene.shapes |
scene.shapes.0 | scene.shapes.1.points | scene.shapes.1.points.0 | scene.shapes.2 | scene.shapes.2.reflectance |
scene.shapes.2.reflectance.values | scene.shapes.2.kind | render | noise.seed | scene.background |
scene.background.reflectance | name | zzz | sensor.frame | sensor.frame.rows | sensor.photosite | sensor.olpf |
sensor.cfa | sensor.cfa.kind | sensor.charge | sensor.quantum_efficiency | sensor.quantum_efficiency.curves |
sensor.quantum_efficiency.curves.R | sensor.readout | sensor.readout.black_level_dn | sensor.camsim |
sensor.name | sensor.zzz"""


def test_the_good_files_have_no_faults(folder: Path) -> None:
    assert load("good.yaml").scene_name == "good"


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


def test_a_region_is_not_judged_by_a_frame_that_is_unknown(folder: Path) -> None:
    sensor = (folder / "my.yaml").read_text()
    (folder / "my.yaml").write_text(sensor.replace("rows: 200,", "rows: none,"))
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=["region={rows: 400, cols: 24}"])
    assert [fault.key for fault in caught.value.faults] == ["frame.rows"]


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
        ("scene.yaml", 3, 63, "lens.transmission.wavelength_nm"),
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


def test_whatever_is_changed_the_answer_is_a_setup_or_sentences(folder: Path) -> None:
    """Values swapped, dropped and put in at random places of both files: never another exception."""
    rng = random.Random(11)
    values, keys = ([each.strip() for each in text.split("|")] for text in (VALUES, KEYS))
    outcomes = set()
    for _ in range(400):
        overrides = [f"{rng.choice(keys)}={rng.choice(values)}" for _ in range(rng.randint(1, 4))]
        faults: tuple[Fault, ...] = ()
        try:
            load("good.yaml", overrides=overrides)
        except ConfigError as error:
            faults = error.faults
        outcomes.add(bool(faults))
        for fault in faults:
            assert fault.message, overrides
            assert "\n" not in str(fault), overrides
    assert outcomes == {True, False}


def test_a_misspelt_kind_does_not_hide_what_is_wrong_beside_it(folder: Path) -> None:
    text = (folder / "good.yaml").read_text()
    shapes = text[text.index("  shapes:") :].splitlines()
    kept = text[: text.index("  shapes:")] + "  shapes:\n    - {kind: disk, radius: -1, colour: red}\n"
    after = [line for line in shapes[1:] if line and not line.startswith(" ")]
    (folder / "scene.yaml").write_text(kept + "\n".join(shapes[shapes.index(after[0]) :] if after else []) + "\n")
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml")
    said = {fault.key: fault.message for fault in caught.value.faults}
    # The reflectance, which stands there as a colour, is not missing too.
    assert set(said) == {"scene.shapes.0.kind", "scene.shapes.0.radius", "scene.shapes.0.colour"}
    assert said["scene.shapes.0.kind"].endswith(" or sine-zone-plate, not 'disk'; did you mean 'disc'?")


@pytest.mark.parametrize(
    "many",
    [
        "".join(f"key{k}: 1\n" for k in range(2000)),
        "name: &a x\n" * 2000,
        "".join(f"? [a{k}]\n: 1\n" for k in range(2000)),
    ],
    ids=["keys", "anchors", "key tables"],
)
def test_of_thousands_of_faults_a_hundred_are_told(folder: Path, many: str) -> None:
    (folder / "scene.yaml").write_text("camsim: scene/1\n" + many)
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml")
    *faults, last = str(caught.value).splitlines()
    assert len(faults) in (MOST_FAULTS, MOST_FAULTS + 1)  # that no sensor is named is found later
    assert last == f"scene.yaml: more than {MOST_FAULTS - 1} faults; mend these first, there may be more"


@pytest.mark.parametrize(
    "shape",
    [
        "{kind: rectangle, widht: 6, height: 8, reflectance: 0.05}",
        "{kind: polygn, points: [[0, 0], [4, 0], [0, 4]], reflectance: nope}",
        "{kind: polygon, points: [[0, 0], [2, 2], [2, 0], [0, 2]], reflectance: 0.05}",
    ],
)
def test_of_thousands_of_faulty_shapes_a_hundred_faults_are_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch, shape: str
) -> None:
    """Counted, not clocked: sixty thousand took three minutes when each was put into words."""
    put_into_words = 0
    of_document = Document.fault

    def counted(*arguments: Any, **how: Any) -> Fault:
        nonlocal put_into_words
        put_into_words += 1
        return of_document(*arguments, **how)

    monkeypatch.setattr(Document, "fault", counted)
    head, _, rest = (folder / "good.yaml").read_text().partition("  shapes:\n")
    tail = rest[rest.index("render:") :]
    (folder / "scene.yaml").write_text(f"{head}  shapes:\n" + f"    - {shape}\n" * 3000 + tail)
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml")
    assert len(str(caught.value).splitlines()) == MOST_FAULTS + 1
    assert put_into_words <= MOST_FAULTS
