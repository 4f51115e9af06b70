"""One judge for both roads: what a YAML file refuses a constructor refuses, and what both take is the same capture.

Random values, right and wrong ones, for every part of a capture: once as YAML (the schema, then the stages), once as
the arguments of the classes.
"""

from __future__ import annotations

import dataclasses
import functools  # noqa: F401 (makers are told by their text)
import json
import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import pytest

import camsim
from camsim.api import load
from camsim.config import schema
from camsim.config.from_record import capture_from_record
from camsim.errors import CamsimError
from camsim.sensor.cfa import PATTERNS
from tests.tables import sections

DRAWS, ENOUGH = 20, 4
STRANGE = (0, -1, 1.5, 90, 1e-300, 1e15, 1e16, 1e300, math.nan, math.inf, -math.inf, True, False, "8", None, [], [1.0])
"""What may be right for one parameter and is wrong for most."""

Changes = Callable[[Any, Mapping[str, Any]], dict[str, Any]]

SCENE = """\
camsim: scene/1
sensor: my.yaml
lens: {kind: airy, f_number: 8}
light: {illuminant: D55, illuminance_lux: 5000}
exposure: {time_s: 0.01, iso: 200}
region: {rows: 20, cols: 24}
scene: {unit: um, background: {reflectance: 0.9}}
"""
SENSOR = """\
camsim: sensor/1
name: Mine
frame: {rows: 60, cols: 80, pitch_um: 4.0}
cfa: {kind: bayer, pattern: GRBG}
quantum_efficiency: {curves: Nikon 5100 (NPL), per: energy, peak: 0.5}
charge: {full_well_e: 20000}
readout: {bit_depth: 12, black_level_dn: 100, base_iso: 100, electrons_per_dn: 5.0}
"""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part of a capture that both roads can say.

    place   : where YAML has it, and ``also`` what its kind is there
    changes : the fields of the capture for values by YAML's keys, made by the classes
    good    : for every key values that are mostly right
    needed  : keys that are always there; the others are left out at times
    whole   : YAML has a value there and no table: that of the only key
    given   : how often a key is there that need not be
    """

    place: str
    changes: Changes
    good: Mapping[str, tuple[Any, ...]]
    also: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    needed: tuple[str, ...] = ()
    whole: bool = False
    given: float = 0.8


def on_camera(**makes: Callable[[Mapping[str, Any]], Any]) -> Changes:
    def changes(base: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        return {"camera": base.camera.replace(**{name: make(values) for name, make in makes.items()})}

    return changes


def lens(make: Callable[..., Any]) -> Changes:
    return on_camera(lens=lambda v: make(**{key: curves_in(value) for key, value in v.items()}))


def curves_in(value: Any) -> Any:
    """Return a value with its curves, and the discs of a group, made by the classes."""
    if isinstance(value, list):
        return [*map(curves_in, value)]
    if value == DISC:
        return camsim.Disc(radius_um=3, centre_um=(-8, 1), reflectance=0.1)
    return camsim.Curve(**value) if isinstance(value, dict) and "values" in value else value


def renamed(values: Mapping[str, Any], **names: str) -> dict[str, Any]:
    return {names.get(key, key): curves_in(value) for key, value in values.items()}


def by_letter(value: Any) -> Any:
    return [(letter, curves_in(curve)) for letter, curve in value.items()] if isinstance(value, dict) else value


def shape(make: Callable[..., Any]) -> Changes:
    names = {key: f"{key}_um" for key in LENGTHS}
    return lambda base, v: {"scene": camsim.Scene(background=0.9, shapes=[make(**renamed(v, **names))])}


LENGTHS = (
    "width", "height", "centre", "radius", "radius_x", "radius_y", "inner_radius", "through", "points", "holes",
    "segments", "size", "at", "move", "step", "period", "finest_period", "dashes", "dash_offset",
)  # fmt: skip
DISC = {"kind": "disc", "radius": 3, "centre": [-8, 1], "reflectance": 0.1}
NUMBERS = (0.02, 0.5, 1, 3.0, 25)
FRACTIONS = (0, 0.02, 0.5, 1.0, 1)
ANGLES = (0.0, 30, -45.5)
HALF = {"wavelength_nm": [300, 900.0], "values": [0, 0.5]}
SPECTRA = (*FRACTIONS, HALF, HALF | {"outside": "zero"}, HALF | {"values": [1, 1.5]}, HALF | {"values": [1]})
WIDE = {"wavelength_nm": [250, 1200], "values": [1, 0.5]}
TABLES = (WIDE, WIDE | {"outside": "hold"}, HALF | {"wavelength_nm": [500, 600]}, HALF | {"wavelength_nm": [600, 500]})
FILTERS = (*SPECTRA, *TABLES)
POINTS = ([[0, 0], [4, 0], [0, 4.5]], [[0, 0], [1, 1], [1, 0], [0, 1]], [[0, 0], [1, 1]], [[0, 0], [1, "1"], [1, 0]])
RISING = ([0, 5, 10.0], [0.0, 1e3], [1, 0], [0, 0], [5], [-1.0, 4])
GRIDS = ([[0, 1, 0], [1, 4.0, 1], [0, 1, 0]], [[1]], [[1, 2], [3]], [[0]], [[-1, 0.5]], [[math.nan]])
OUTER = [0, 0, 0, 0, 0]
TRANSFERS = (
    [OUTER, [0, 0, 0.5, 0, 0], [0, 0.4, 1.0, 0.4, 0], [0, 0, 0.5, 0, 0], OUTER],
    [OUTER, OUTER],
    [[1, 0], OUTER],
)
KERNELS = (
    [[0, 0.1, 0], [0, 0.8, 0], [0, 0, 0]], [[0, 0, 0], [0, 1, 0], [0, 0, 0]], [[0, 0, 0], [0, 1.5, 0], [0, 0, 0]],
    [[0, 0.6, 0], [0, 0.6, 0], [0, 0, 0]], [[0, 1], [0, 0]], [[0, 0, 0], [0, -1, 0], [0, 0, 0]],
)  # fmt: skip


def valued(place: str, field: str, good: tuple[Any, ...], make: Callable[[Any], Any] = lambda value: value) -> Part:
    """Return a field of the camera that YAML says by a value and no table."""
    changes = on_camera(**{field: lambda v: make(v["x"])})
    return Part(place=place, changes=changes, good={"x": good}, needed=("x",), whole=True)


def stage(field: str, **names: str) -> Callable[[Callable[..., Any]], Changes]:
    return lambda make: on_camera(**{field: lambda v: make(**renamed(v, **names))})


def light(base: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    return {"light": camsim.Light(**renamed(values, illuminant="spectrum"))}


def square_of(pitch_um: float, fill_factor: float = 1.0) -> camsim.SquarePhotosite:
    return camsim.SquarePhotosite.from_fill_factor(pitch_um=pitch_um, fill_factor=fill_factor)


ZERNIKES = ([[4, 0.1]], [[4, 0.1], [4, 0.2]], [[231, 0.1]], [[3, 51]], [[4.0, 1]], [[4]], [])
FREQUENCIES = ([0, 0.1, 0.2], [0.1, 0.2, 0.3], [0, 0.2, 0.1])
CENTRES = ([0, 0], [1.5, -2], [1], [1, "2"])
LINES = [["move", 0, 0], ["line", 4, 0], ["line", 0, 4.5]]
BEND = [["move", -12, -8], ["cubic", 0, -20, 8, 14, 12, 2], ["arc", 9, 6, 20, 0, 1, -12, 8], ["close"]]
SEGMENTS = (LINES, BEND, [["line", 1, 1]], [["move", 0, 0], ["line", 1]], [["move", 0, 0], ["bend", 1, 1]])
DARK = {
    "dark_current_e_per_s": "e_per_s", "dcnu": "nonuniformity", "dark_current_at_c": "at_c",
    "dark_current_doubles_every_c": "doubling_c",
}  # fmt: skip
# Of parts without kinds what makes the changes, by their names.
PLAIN: dict[str, Changes] = {
    "line": light,
    "blackbody": light,
    "light": light,
    "pupil": on_camera(lens=lambda v: camsim.Wavefront(f_number=8, pupil=camsim.Pupil(**v))),
    "exposure": lambda base, v: {"exposure": camsim.Exposure(**v)},
    "region": lambda base, v: inside(base, camsim.Region(**v)),
    "background": lambda base, v: {"scene": camsim.Scene(background=curves_in(v["reflectance"]))},
    "frame": lambda base, v: {"camera": base.camera.replace(**v, photosite=square_of(v["pitch_um"]))},
    "efficiency": on_camera(
        quantum_efficiency=lambda v: camsim.QuantumEfficiency(**v | {"curves": by_letter(v["curves"])})
    ),
    "adc": stage("adc")(camsim.Adc),
    "dark current": on_camera(
        full_well=lambda v: None, dark_current=lambda v: camsim.DarkCurrent(**renamed(v, **DARK))
    ),
    "defects": stage("defects")(camsim.Defects),
    "flicker": stage("flicker_rows")(camsim.FlickerRows),
    "dual gain": stage("dual_gain", full_well_e="capacity_e")(camsim.DualGain),
    "render": lambda base, v: dict(v),
    "noise": lambda base, v: renamed(v, enabled="noise"),
    "files": lambda base, v: dict(v),
}
# Of parts with kinds, by their places, what makes the changes of a class.
OF_KINDS = {
    "lens": lens,
    "scene.shapes": shape,
    **{f"sensor.{name}": stage(name) for name in ("photosite", "olpf", "cfa")},
    "sensor.charge.nonlinearity": stage("nonlinearity"),
    "lens.falloff": stage("falloff"),
}


def told(title: str, lines: list[list[str]]) -> tuple[str, Part]:
    """Return a part of tests/data/parts-of-a-capture.txt: its name, its place, and for a kind what makes it."""
    name, place, *maker = title.split(" | ")
    return name, Part(
        place=place,
        also={"kind": name.split()[0]} if maker else {},
        changes=OF_KINDS[place](eval(maker[0])) if maker else PLAIN[name],
        good={key: eval(f"({values},)", globals()) for key, values, *_ in lines},
        needed=tuple(key for key, _, *always in lines if always),
        given=0.5 if name == "light" else 0.8,
    )


PARTS = {
    **dict(told(title, lines) for title, lines in sections("parts-of-a-capture.txt").items()),
    "magnification": valued("lens.magnification", "magnification", (0, 0.5, 1, 100, 101)),
    "glare": valued("lens.veiling_glare", "veiling_glare", (0, 0.02, 1, 1.5, *FILTERS), curves_in),
    "filters": valued("sensor.filters", "filters", ([], *([one] for one in FILTERS)), curves_in),
    "crosstalk": valued("sensor.charge.crosstalk", "crosstalk", KERNELS, camsim.Crosstalk),
}


def stages_of_a_number() -> dict[str, Part]:
    """Return the stages that one key makes, as the schema lists them."""
    parts = {}
    for name, table in (("charge", schema.Charge), ("readout", schema.Readout)):
        for key, field in table.model_fields.items():
            place = f"sensor.{name}.{key}"
            for makes in (mark for mark in field.metadata if isinstance(mark, schema.Makes)):
                if dataclasses.is_dataclass(makes.make) and not makes.also and place not in TABLES_THERE:
                    parts[key] = valued(place, makes.field, FRACTIONS, makes.make)
    return parts


TABLES_THERE = {part.place for part in PARTS.values()}
PARTS |= stages_of_a_number()


def inside(base: Any, region: camsim.Region) -> dict[str, Any]:
    base.camera.grid(region)
    return {"region": region}


def flow(value: Any) -> str:
    """Return a value as YAML in one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return json.dumps(value)


def drawn(part: Part, chance: random.Random) -> dict[str, Any]:
    """Return values of a part: mostly good ones, now and then a strange one or none."""
    values, usual = {}, 1.0 - 0.3 / len(part.good)
    for key, good in part.good.items():
        if key in part.needed or chance.random() < part.given:
            strange = [value for value in STRANGE if value is not None or not part.whole]  # there null removes
            values[key] = chance.choice(good if chance.random() < usual else strange)
    return values


def override(part: Part, values: Mapping[str, Any]) -> str:
    table = values[part.needed[0]] if part.whole else {**part.also, **values}
    return f"{part.place}={flow([table] if part.place == 'scene.shapes' else table)}"


@pytest.fixture
def base(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    (tmp_path / "good.yaml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "my.yaml").write_text(SENSOR, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return load("good.yaml")


@pytest.mark.parametrize("name", PARTS)
def test_a_file_and_a_constructor_refuse_and_take_the_same(name: str, base: Any) -> None:
    part, chance = PARTS[name], random.Random(f"{name} 15")
    taken = refused = 0
    for _ in range(10 * DRAWS):
        values = drawn(part, chance)
        text = override(part, values)
        before = ["lens={kind: wavefront, f_number: 8}"] if name == "pupil" else []
        by_yaml, by_class = made(lambda t=text, b=before: load("good.yaml", overrides=[*b, t])), None
        by_class = made(lambda v=values: dataclasses.replace(base, **part.changes(base, v)))
        assert (by_yaml is None) == (by_class is None), f"{text}: YAML {by_yaml is not None}, {by_class is not None}"
        assert by_yaml == by_class, text
        assert by_yaml is None or again(by_yaml) == by_yaml, text
        taken, refused = taken + (by_yaml is not None), refused + (by_yaml is None)
        if taken + refused >= DRAWS and min(taken, refused) >= ENOUGH:
            break
    assert min(taken, refused) >= ENOUGH


def again(capture: Any) -> Any:
    """Return the capture that its description says, which names no scene and judges nothing."""
    described = json.loads(json.dumps(capture.description(capture.frame_number)))
    return dataclasses.replace(capture_from_record(described), scene_name=capture.scene_name, strict=capture.strict)


QE = {"curves": "Nikon 5100 (NPL)", "per": "energy", "peak": 0.4, "source": "a sheet"}
READ_OUT = {"bit_depth": 12, "black_level_dn": 100, "base_iso": 100, "electrons_per_dn": 5.0}
WHOLE = {
    "sensor.quantum_efficiency": (
        QE,
        {"quantum_efficiency": camsim.QuantumEfficiency.named(QE["curves"], peak=0.4, source="a sheet")},
    ),
    "lens": ({"kind": "gaussian", "mtf50_per_um": 0.1, "f_number": 8}, {"lens": camsim.Gaussian.from_mtf50(0.1)}),
    "lens.filters": ([0.5, WIDE], {"filters": [0.5, camsim.Curve(**WIDE)]}),
    "sensor.olpf": (
        {"kind": "two-spot", "split_pitches": 0.7},
        {"olpf": camsim.TwoSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.7)},
    ),
    "sensor.charge.shot_noise": (False, {"shot_noise": None}),
    "sensor.charge.blooming": (0.5, {"blooming": camsim.Blooming(0.5)}),
    "sensor.charge.defects": (
        {"hot": [{"row": 27, "col": 38, "e_per_s": 1e5}], "dead": [[26, 37]]},
        {"defects": camsim.Defects(hot=[(27, 38, 1e5)], dead=[(26, 37)])},
    ),
    "sensor.readout.telegraph_noise": (
        {"fraction": 0.2, "amplitude_e": 90},
        {"telegraph_noise": camsim.TelegraphNoise(fraction=0.2, amplitude_e=90)},
    ),
}
READ_OUTS = (
    ({"read_noise_student_dof": 4}, {"student_dof": 4}, {}),
    ({"read_noise_tukey_lambda": 0, "read_noise_spread": 0.3}, {"tukey_lambda": 0, "spread": 0.3}, {}),
    ({"gain_at_iso": [{"iso": 150, "electrons_per_dn": 3}]}, {}, {"gain_at_iso": [(150, 3)]}),
    ({"code_step_dn": 16, "bit_depth": 16}, {}, {"code_step_dn": 16, "bit_depth": 16}),
    ({"companding": {"linear_dn": [0, 4095], "codes": [0, 900]}}, {}, {"companding": [(0, 0), (4095, 900)]}),
)


@pytest.mark.parametrize("place", WHOLE)
def test_what_else_a_file_says(place: str, base: Any) -> None:
    value, fields = WHOLE[place]
    by_yaml = load("good.yaml", overrides=[f"{place}={flow(value)}"])
    assert by_yaml == dataclasses.replace(base, camera=base.camera.replace(**fields)) == again(by_yaml)


@pytest.mark.parametrize(("table", "noise", "adc"), READ_OUTS)
def test_what_a_read_out_says(table: Any, noise: Any, adc: Any, base: Any) -> None:
    by_yaml = load("good.yaml", overrides=[f"sensor.readout={flow(READ_OUT | {'read_noise_e': 20} | table)}"])
    stages = {"read_noise": camsim.ReadNoise(20, **noise), "adc": camsim.Adc(**READ_OUT | adc)}
    assert by_yaml == dataclasses.replace(base, camera=base.camera.replace(**stages)) == again(by_yaml)


@pytest.mark.parametrize("kind", PATTERNS)
def test_every_named_array_of_filters(kind: str, base: Any) -> None:
    cfa = camsim.Cfa.named(kind)
    tables = {letter: {**WIDE, "outside": "zero"} for letter in cfa.channels}
    texts = [f"sensor.cfa={{kind: {kind}}}", f"sensor.quantum_efficiency={flow(QE | {'curves': tables})}"]
    by_yaml = load("good.yaml", overrides=texts)
    assert by_yaml.camera.cfa == cfa
    assert again(by_yaml) == by_yaml


@pytest.mark.parametrize(("unit", "um"), [("um", 1.0), ("mm", 1e3), ("pixel", 4.0)])
def test_lengths_are_in_the_unit_of_the_scene(unit: str, um: float, base: Any) -> None:
    shapes = [DISC, {"kind": "rectangle", "width": 2.5, "height": 1, "reflectance": 0.5}]
    disc = camsim.Disc(radius_um=3 * um, centre_um=(-8 * um, um), reflectance=0.1)
    box = camsim.Rectangle(width_um=2.5 * um, height_um=um, reflectance=0.5)
    found = load("good.yaml", overrides=[f"scene.unit={unit}", f"scene.shapes={flow(shapes)}"]).scene
    assert found == camsim.Scene(background=0.9, shapes=[disc, box])


def test_a_lens_of_a_file_is_that_of_python(base: Any) -> None:
    found = load("good.yaml", overrides=["lens={kind: field, file: perfect, focus_um: 90}"])
    assert found.camera.lens == dataclasses.replace(camsim.read_lens("perfect"), focus_um=90.0)
    assert again(found) == found


def made(make: Callable[[], Any]) -> Any:
    """Return what is made, None when it is refused."""
    try:
        return make()
    except CamsimError:
        return None
    except TypeError as error:
        if "required" not in str(error):  # Python's own word for an argument that must be given
            raise
        return None
