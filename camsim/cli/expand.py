"""``camsim show --expand``: the shapes of a scene, with charts expanded, as YAML in µm."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from camsim.core.words import kebab
from camsim.spectra.curve import Curve

_IN_ITS_FILE = ("planes", "spectra", "source", "read")
"""Keys of a picture that are in its file."""


def expanded(name: str, sensors: Sequence[str] = ()) -> Iterator[str]:
    """Return the lines of a scene's ``scene`` table with ordinary shapes only."""
    from camsim.api import load

    scene = load(name, sensors=sensors).scene
    yield from ("scene:", "  unit: um", f"  background: {{reflectance: {_text(_plain(scene.background))}}}")
    shapes = [f"    - {_text(shape)}" for shape in _ordinary(scene.shapes)]
    yield from ("  shapes:", *shapes) if shapes else ()


def _ordinary(shapes: Iterable[Any]) -> Iterator[dict[str, Any]]:
    """Yield shapes as tables; charts and drawings are expanded."""
    from camsim.scene import Chart, Svg

    for shape in shapes:
        if isinstance(shape, Chart | Svg):
            yield from _ordinary(shape.shapes)
        else:
            yield _table(shape)


def _table(shape: Any) -> dict[str, Any]:
    from camsim.scene import Picture

    table: dict[str, Any] = {"kind": kebab(type(shape))}
    if isinstance(shape, Picture):
        table |= {"file": shape.source, **(shape.read or {})}
    for field in dataclasses.fields(shape):
        value = getattr(shape, field.name)
        if field.name in _IN_ITS_FILE or not field.init or value == field.default:
            continue
        key = field.name.removesuffix("_um")
        if key == "shapes":
            table[key] = list(_ordinary(value))
        else:
            table[key] = _table(value) if hasattr(value, "primitives") else _plain(value)
    return table


def _plain(value: Any) -> Any:
    """Return a spectrum by its name or as a table, and lists for tuples."""
    if isinstance(value, Curve):
        from camsim.spectra import named

        if value.name in named.reflectance_names() and named.reflectance(value.name) == value:
            return value.name
        return {"wavelength_nm": list(value.wavelength_nm), "values": list(value.values), "outside": value.outside}
    return [_plain(part) for part in value] if isinstance(value, list | tuple) else value


def _text(value: Any) -> str:
    """Return a value in YAML's flow style."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_text(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_text, value)) + "]"
    word = (
        isinstance(value, str) and value.replace("-", "").isalpha() and value.lower() not in ("true", "false", "null")
    )
    return value if word else json.dumps(value, ensure_ascii=False)
