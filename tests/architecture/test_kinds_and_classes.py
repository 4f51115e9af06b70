"""Every kind of a YAML file has a class, and every class a kind of the same name: without the word of its place."""

import dataclasses
import re
from collections.abc import Iterator
from typing import Any, get_args

import pytest
from pydantic import BaseModel

import camsim
from camsim.config import schema
from camsim.sensor.cfa import PATTERNS

WORDS = {"lens": "Lens", "shapes": "", "photosite": "Photosite", "olpf": "Olpf", "falloff": "Falloff"}
WORDS |= {"nonlinearity": "Response"}
"""Where a table has kinds, and the word that names of its classes have more."""

KEYS = {
    "SceneFile": "Capture", "SceneContent": "Scene", "SensorFile": "Camera", "Light": "Light", "Exposure": "Exposure",
    "Region": "Region", "Pupil": "Pupil", "QuantumEfficiency": "QuantumEfficiency", "Readout": "Adc", "Curve": "Curve",
    "Fractions": "Curve", "FilterCurve": "Curve", "LightTable": "Curve", "DualGain": "DualGain", "Defects": "Defects",
    "FlickerRows": "FlickerRows", "MeasuredMatrix": "MeasuredMatrix", "TelegraphNoise": "TelegraphNoise",
    "OffsetMap": "OffsetMap",
}  # fmt: skip
"""Tables of one kind only, and their classes."""

PARTS = {"SensorFrame", "Background", "Render", "Noise", "Files", "Charge", "HotPhotosite", "GainAtIso", "Companding"}
"""Tables whose keys are parameters of a class that another table is, or stages of their own."""


def tables(declared: Any) -> Iterator[type[BaseModel]]:
    """Every table that a type speaks of."""
    if isinstance(declared, type) and issubclass(declared, BaseModel):
        yield declared
    for part in get_args(declared):
        yield from tables(part)


def walked(*files: type[BaseModel]) -> set[tuple[str, type[BaseModel]]]:
    """Every table of files with the key that it stands at."""
    found, left = set(), [("", file) for file in files]
    while left:
        place, table = left.pop()
        if (place, table) not in found:
            found.add((place, table))
            for name, field in table.fields().items():
                left += [(name, inside) for inside in tables(field.annotation)]
    return found


FOUND = walked(schema.SceneFile, schema.SensorFile)
KINDS = sorted(
    (place, kind)
    for place, table in FOUND
    if "kind" in table.model_fields and place != "cfa"
    for kind in get_args(table.model_fields["kind"].annotation)
)


def kind_of(place: str, name: str) -> str:
    """Return what a class of a place is called in YAML."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name.replace(WORDS[place], "")).lower()


def classes_of(place: str) -> list[str]:
    """Return the public classes that can stand at a place: those that have what its first one has."""
    public = [getattr(camsim, name) for name in camsim.__all__]
    classes = [kind for kind in public if isinstance(kind, type) and dataclasses.is_dataclass(kind)]
    if place in ("lens", "olpf", "photosite"):
        return [kind.__name__ for kind in classes if getattr(kind, "place", "") == place]
    if place == "shapes":
        return [
            kind.__name__
            for kind in classes
            if kind.__module__.startswith("camsim.scene.") and kind is not camsim.Scene
        ]
    ability = {"falloff": "relative", "nonlinearity": "response"}[place]
    return [kind.__name__ for kind in classes if hasattr(kind, ability)]


@pytest.mark.parametrize("place", list(WORDS))
def test_kinds_and_classes_have_the_same_names(place: str) -> None:
    classes = classes_of(place)
    assert len(classes) > 1
    assert {kind_of(place, name) for name in classes} == {kind for where, kind in KINDS if where == place}


def test_every_place_with_kinds_is_looked_at() -> None:
    assert {place for place, _ in KINDS} - {"clip"} == set(WORDS)
    # Outlines can clip; pictures and gradients are fields.
    fields = {
        "picture",
        "point-source",
        "linear-gradient",
        "radial-gradient",
        "sine-grating",
        "sine-star",
        "sine-zone-plate",
    }
    shapes = {kind for place, kind in KINDS if place == "shapes"} - fields
    assert {kind for place, kind in KINDS if place == "clip"} == shapes


def test_every_chart_is_a_function() -> None:
    charts = [table for place, table in FOUND if place == "shapes" and "name" in table.model_fields]
    names = [name for table in charts for name in get_args(table.model_fields["name"].annotation)]
    assert len(names) > 10
    assert all(callable(getattr(camsim.charts, name.replace("-", "_"))) for name in names)


def test_every_kind_of_filter_array_is_a_constructor() -> None:
    table_of = {kind: table for place, table in FOUND if place == "cfa" for kind in _kinds(table)}
    for kind in table_of:
        method = kind.replace("-", "_")
        assert kind == "letters" or kind in PATTERNS or hasattr(camsim.Cfa, method), kind
    assert set(PATTERNS) | {"bayer", "quad-bayer", "letters"} == set(table_of)


def _kinds(table: type[BaseModel]) -> tuple[str, ...]:
    kinds: tuple[str, ...] = get_args(table.model_fields["kind"].annotation)
    return kinds


def test_every_other_table_has_a_class() -> None:
    others = {table.__name__ for _, table in FOUND if "kind" not in table.model_fields}
    assert others == set(KEYS) | PARTS
    assert set(KEYS.values()) <= set(camsim.__all__)


def test_every_public_stage_is_said_by_a_table_or_a_key() -> None:
    public = {name for name in camsim.__all__ if dataclasses.is_dataclass(getattr(camsim, name))}
    results = {"Frame", "Rendering", "Report", "Note", "Context", "Grid"}
    of_arrays = {"Sensor", "GivenLight", "Noise"}  # light of one's own has no scene file
    made = {mark.make for table in (schema.Charge, schema.Readout) for mark in _marks(table)}
    by_key = {make.__name__ for make in made if dataclasses.is_dataclass(make)} | {"ShotNoise", "DarkFrames"}
    by_kind = {name for place in WORDS for name in classes_of(place)}
    assert public - results - of_arrays == by_key | by_kind | set(KEYS.values()) | {"Cfa"}


def _marks(table: type[BaseModel]) -> Iterator[Any]:
    for field in table.model_fields.values():
        yield from (mark for mark in field.metadata if isinstance(mark, schema.Makes))
