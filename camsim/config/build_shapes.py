"""Shapes of a scene file: each kind's table becomes the shape of the same name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from camsim import scene as shapes
from camsim.config import build_charts, schema
from camsim.config.build_sensor import curve_of
from camsim.config.lengths import SceneDocument, made, scaled
from camsim.config.tree import KeyPath
from camsim.scene import Shape
from camsim.spectra import named
from camsim.spectra.curve import Spectrum

# Placeholder for a faulty spectrum, so that its shape can still be checked; nothing is rendered then.
_ANY_SPECTRUM = 0.5

_SPECTRA = ("reflectance", "low", "high")

# Kinds that become more than one shape.
_BECOME = {"chart": build_charts.chart, "svg": build_charts.drawing}


def shape_at(scene: SceneDocument, path: KeyPath, unit_um: float) -> Shape | None:
    """Make the shape at ``path`` of a file, whose lengths are ``unit_um`` long."""
    table, written = scene.part(path, schema.Table), scene.value(path)
    if not isinstance(written, Mapping):
        return None
    if (become := _BECOME.get(str(written.get("kind")))) is not None:
        return become(scene, path, unit_um, spectrum_at)
    given: dict[str, Any] = {}
    for name in _SPECTRA:
        if name in written:
            spectrum = spectrum_at(scene, (*path, name))
            given[name] = _ANY_SPECTRUM if spectrum is None else spectrum
    inner, clip = written.get("shapes"), written.get("clip")
    if isinstance(inner, list):
        places = [(*path, "shapes", index) for index in range(len(inner))]
        given["shapes"] = [None if scene.full else shape_at(scene, place, unit_um) for place in places]
    if isinstance(clip, Mapping):
        given["clip"] = shape_at(scene, (*path, "clip"), unit_um)
    if table is None or None in given.get("shapes", ()) or (clip is not None and given.get("clip") is None):
        return None
    made_of = getattr(shapes, type(table).__name__)
    keys = [key for key in type(table).model_fields if key not in ("kind", "source")]
    lengths = {f"{key}_um": (key,) for key in keys if f"{key}_um" in made_of.__slots__}

    def make(scale: float) -> Shape:
        parts = {key: given.get(key, getattr(table, key)) for key in keys}
        for name, (key,) in lengths.items():
            parts[name] = scaled(parts.pop(key), scale)
        if parts.get("matrix") is not None:
            parts["matrix"] = (*parts["matrix"][:4], *scaled(parts["matrix"][4:], scale))
        shape: Shape = made_of(**parts)
        return shape

    return made(scene, path, make, unit_um, lengths)


def spectrum_at(scene: SceneDocument, path: KeyPath, *, names: bool = True) -> Spectrum | None:
    """Make a reflectance (which may have a name) or a transmission of whatever stands at ``path``."""
    value = scene.value(path)
    if names and isinstance(value, str):
        return scene.build(path, lambda: named.reflectance(value))
    if isinstance(value, dict):
        table = scene.part(path, schema.Fractions)
        return None if table is None else scene.build(path, lambda: curve_of(table))
    return float(value) if isinstance(value, int | float) else None
