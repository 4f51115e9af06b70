"""Check that every curve of the sensor covers the light, or declares values outside its table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from camsim.camera.camera import Camera
from camsim.config import schema
from camsim.config.build_sensor import curve_of
from camsim.config.tree import KeyPath
from camsim.config.validated import Validated
from camsim.spectra.light import Light

_Found = tuple[Validated[Any], KeyPath, "schema.Curve | schema.FilterCurve"]


def refuse_what_light_lies_beyond(scene: Validated[Any], sensor: Validated[Any], camera: Camera, light: Light) -> None:
    """Add a fault for every table that does not cover the light, unless it has ``outside``."""
    for document, path, table in _tables(scene, sensor, camera):
        if table.outside is None and (missing := light.beyond(curve_of(table))):
            document.refuse(path, f"{missing}; extend the table, or say outside: zero (or hold)")


def _tables(scene: Validated[Any], sensor: Validated[Any], camera: Camera) -> Iterator[_Found]:
    places: list[tuple[Validated[Any], KeyPath]] = [
        (sensor, ("quantum_efficiency", "curves", letter)) for letter in camera.cfa.channels
    ]
    stacks: tuple[tuple[Validated[Any], KeyPath], ...] = ((scene, ("lens", "filters")), (sensor, ("filters",)))
    for document, stack in stacks:
        given = document.value(stack)
        places += [(document, (*stack, index)) for index in range(len(given) if isinstance(given, list) else 0)]
    for document, path in places:
        if not isinstance(document.value(path), dict):
            continue
        table = document.part(path, schema.Curve) or document.part(path, schema.FilterCurve)
        if table is not None:
            yield document, path, table
