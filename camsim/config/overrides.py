"""``--set a.b=v``: single values of a document, changed from the command line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from camsim.config.expect import Expected
from camsim.config.schema import SceneFile, SensorFile, Table
from camsim.config.tree import Document, KeyPath, Node, Place, dotted
from camsim.config.yaml_source import parse_value
from camsim.errors import ConfigError, Fault

_SENSOR = "sensor"


@dataclass(frozen=True, slots=True)
class Override:
    """One change.

    of_sensor  it concerns the sensor profile, not the scene
    path       in its own document, without the leading ``sensor``
    value      the new value; None removes what is there
    place      what messages name as its place
    """

    of_sensor: bool
    path: tuple[str, ...]
    value: Node | None
    place: Place


def parse(texts: Iterable[str]) -> tuple[list[Override], list[Fault]]:
    """Read overrides; invalid ones are returned as faults."""
    overrides: list[Override] = []
    faults: list[Fault] = []
    for text in texts:
        key, equals, value = text.partition("=")
        parts = tuple(key.strip().split("."))
        if not equals or not all(parts):
            faults.append(Fault(f"--set {text}", 0, 0, "", "must be KEY=VALUE, such as exposure.iso=800"))
            continue
        of_sensor = parts[0] == _SENSOR and len(parts) > 1
        path = parts[1:] if of_sensor else parts
        if not of_sensor and path[0] in SensorFile.model_fields and path[0] not in SceneFile.model_fields:
            message = f"unknown key; the sensor's begin with 'sensor.': did you mean 'sensor.{dotted(path)}'?"
            faults.append(Fault(f"--set {dotted(path)}", 0, 0, "", message))
            continue
        place = Place(f"--set {dotted(parts)}", key=dotted(path))
        try:
            node = parse_value(value, place)
        except ConfigError as error:
            faults.extend(error.faults)
            continue
        overrides.append(Override(of_sensor, path, None if node.content is None else node, place))
    return overrides, faults


def apply(document: Document, overrides: Iterable[Override], model: type[Table]) -> Document:
    """Return the document with the overrides in it, in order; later ones act on the results of earlier ones."""
    root, faults, removed = document.root, list(document.faults), dict(document.removed)
    for override in overrides:
        try:
            root = _changed(root, override.path, override, Expected.of(model), ())
        except ConfigError as error:
            faults.extend(error.faults)
        if override.value is None:
            removed[override.path] = override.place
    return replace(document, root=root, faults=tuple(faults), removed=removed)


def _changed(node: Node, rest: tuple[str, ...], override: Override, expected: Expected | None, done: KeyPath) -> Node:
    """Return ``node`` with the value at ``rest`` set or removed."""
    key: str | int = rest[0]
    if node.content is None:
        node = replace(node, content={})
    if isinstance(node.content, tuple):
        key = _index(str(key), node.content, override, done)
    elif not isinstance(node.content, Mapping):
        raise _error(override, f"{dotted(done)} is {node.text}, which has no {key!r} inside")
    inside = expected.inside(node, key) if expected is not None else None
    child = node.child(key)
    new = override.value
    if len(rest) > 1:
        holder = child or Node({}, override.place, override.place)
        new = _changed(holder, rest[1:], override, inside, (*done, key))
    elif new is None and child is None and inside is None:
        # Nothing to remove, and no such key: stored as an empty value, so that the schema reports the fault.
        new = Node(None, override.place, override.place)
    if len(rest) == 1 and new is not None and expected is not None and isinstance(node.content, Mapping):
        content = _without_the_others(node, node.content, str(key), expected)
        return replace(node, content={**content, str(key): new})
    return replace(node, content=_with(node.content, key, new))


def _without_the_others(node: Node, content: Mapping[str, Node], key: str, expected: Expected) -> dict[str, Node]:
    """Return a table without the file's alternatives to ``key``; those of other overrides stay."""
    table = expected.table(node)
    groups = table.alternatives if table is not None else ()
    others = {other for group in groups if key in group for other in group if other != key}
    return {name: one for name, one in content.items() if name not in others or not one.place.line}


def _with(content: Any, key: str | int, new: Node | None) -> tuple[Node, ...] | dict[str, Node]:
    if isinstance(key, int):
        return (*content[:key], *(() if new is None else (new,)), *content[key + 1 :])
    entries = {name: node for name, node in content.items() if name != key or new is not None}
    return entries if new is None else {**entries, key: new}


def _index(key: str, items: tuple[Node, ...], override: Override, done: KeyPath) -> int:
    if key in map(str, range(len(items))):
        return int(key)
    there = f"there are 0 to {len(items) - 1}" if items else "the list is empty"
    raise _error(override, f"no item {key} in {dotted(done)}; {there}")


def _error(override: Override, message: str) -> ConfigError:
    return ConfigError([Fault(override.place.file, 0, 0, "", message)])
