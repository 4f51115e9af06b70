"""The schema as JSON Schema for editors, and as a page for people: ``python -m camsim.config.reference``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.resources import files
from typing import Any, Literal, TypeAlias, get_args, get_origin

import yaml
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from camsim.config.expect import Expected, expected_of_field, words_of
from camsim.config.faults import format_of
from camsim.config.schema import SceneFile, SensorFile, ShotFile, Table
from camsim.config.schema.lens_file import LensFile
from camsim.config.schema.study import DatasetFile, StudyFile

Kind: TypeAlias = Literal["scene", "sensor", "lens", "study", "dataset"]

FILES: dict[str, type[Table]] = {
    "scene": SceneFile,
    "shot": ShotFile,
    "sensor": SensorFile,
    "lens": LensFile,
    "study": StudyFile,
    "dataset": DatasetFile,
}


def json_schema(kind: Kind) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a scene, sensor or study file, descriptions and units included."""
    model = FILES[kind]
    stated = {key: value for key, value in model.model_json_schema().items() if key != "title"}
    if model is SceneFile:
        stated = _with_or_without_a_lens(stated, ShotFile.model_json_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": f"camsim {format_of(model)}", **stated}


def _with_or_without_a_lens(scene: dict[str, Any], shot: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a scene file; with ``lens: none`` it is another one."""
    parts = {**scene.pop("$defs"), **shot.pop("$defs")}
    without = {"properties": {"lens": {"const": "none"}}, "required": ["lens"]}
    return {"$defs": parts, "if": without, "then": shot, "else": scene}


def examples() -> dict[str, list[str]]:
    """Return examples, by the name of the schema's table that each of them shows; together they have every key."""
    found: dict[str, list[str]] = yaml.safe_load(files("camsim.config").joinpath("examples.yaml").read_text("utf-8"))
    return found


def markdown() -> str:
    """Return the reference of all keys as a page in Markdown."""
    lines = [
        "# YAML reference",
        "",
        "Made from the schema by `python -m camsim.config.reference`; do not edit. Every table may also hold `source`,",
        "a text for people. Numbers follow YAML 1.2; anchors, tags and duplicate keys are refused. Editors can use the",
        "same as JSON Schema: `camsim schema scene`, `sensor`, `lens`, `study`, `dataset`. Examples show parts of",
        "files as at the top level; only `shapes` belongs under `scene`. Files named in them are your own.",
        "",
    ]
    displayed = examples()
    for name, model in FILES.items():
        lines += [f"## {name.capitalize()} files", "", f"{_sentence(model)}", ""]
        places: dict[type[Table], list[str]] = {}
        for path, table in _tables(model, ""):
            places.setdefault(table, []).append(path)
        for table, paths in places.items():
            if paths != [""]:
                lines += [f"### {', '.join(f'`{path}`' for path in _short(paths))}", "", _sentence(table), ""]
            lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
            lines += [_row(key, field) for key, field in table.fields().items() if key != "source"]
            lines.append("")
            for example in displayed.get(table.__name__, ()):
                lines += ["```yaml", example.rstrip(), "```", ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def _tables(table: type[Table], path: str, above: tuple[type[Table], ...] = ()) -> Iterator[tuple[str, type[Table]]]:
    """Yield a table and all tables inside it, with their paths; kinds are distinguished.

    above : enclosing tables; recursive ones are listed once
    """
    yield path, table
    for key, field in table.fields().items():
        inside = f"{path}.{key}" if path else key
        if set(expected_of_field(field).holds()) & {*above, table}:
            continue
        for member, place in _members(expected_of_field(field), inside):
            words = [f"{key} {', '.join(words_of(member, key))}" for key in ("kind", "name") if words_of(member, key)]
            yield from _tables(member, f"{place} ({', '.join(words)})" if words else place, (*above, table))


def _short(paths: list[str]) -> list[str]:
    """Merge places that are equal in several kinds of a table, without the kinds.

    >>> _short(["lens (kind airy).falloff (kind cos4)", "lens (kind gaussian).falloff (kind cos4)"])
    ['lens.falloff (kind cos4)']
    """
    same: dict[str, list[str]] = {}
    for path in paths:
        same.setdefault(re.sub(r" \(kind [^)]*\)(?=[.[])", "", path), []).append(path)
    return [short if len(whole) > 1 else whole[0] for short, whole in same.items()]


def _members(expected: Expected, path: str) -> Iterator[tuple[type[Table], str]]:
    """Yield the tables that may stand at a place, in lists (``path[]``) and under letters (``path.LETTER``) too."""
    for member in expected.alternatives():
        origin, items = get_origin(member.kind), get_args(member.kind)
        if len(member.alternatives()) > 1:  # charts are distinguished by name
            yield from _members(member, path)
        elif origin is list:
            yield from _members(Expected.of(items[0]), f"{path}[]")
        elif origin is dict:
            yield from _members(Expected.of(items[1]), f"{path}.LETTER")
        elif isinstance(member.kind, type) and issubclass(member.kind, Table):
            yield member.kind, path


def _row(key: str, field: FieldInfo) -> str:
    words = expected_of_field(field).words()
    return f"| `{key}` | {words} | {_default(field)} | {field.description or ''} |".replace("||", "| |")


def _default(field: FieldInfo) -> str:
    default = field.default
    if default is PydanticUndefined:
        return "required"
    if default is None or default == []:
        return "none"
    if isinstance(default, Table):
        return "as below"
    if isinstance(default, bool):
        return f"`{str(default).lower()}`"
    if isinstance(default, float):
        return f"`{default:g}`"
    return f"`{list(default) if isinstance(default, tuple) else default}`"


def _sentence(table: type[Table]) -> str:
    return (table.__doc__ or "").strip().split("\n\n")[0].replace("\n    ", " ")


if __name__ == "__main__":
    print(markdown(), end="")
