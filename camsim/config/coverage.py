"""Whether every curve of the sensor covers the light, or its file says what lies beyond."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from camsim.camera import Camera
from camsim.config import schema
from camsim.config.judged import Judged
from camsim.config.tree import KeyPath
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light

# Less light than this outside a table is nobody's concern.
_NEGLIGIBLE = 1e-3

_Found = tuple[Judged[Any], KeyPath, "schema.Curve | schema.FilterCurve"]


def refuse_what_light_lies_beyond(scene: Judged[Any], sensor: Judged[Any], camera: Camera, light: Light) -> None:
    """Add a fault for every table that ends where light goes on, unless it says ``outside``."""
    for document, path, table in _tables(scene, sensor, camera):
        if table.outside is None:
            message = _missing(table.wavelength_nm[0], table.wavelength_nm[-1], light)
            if message:
                document.refuse(path, f"{message} of {light.name}; extend the table, or say outside: zero (or hold)")


def _tables(scene: Judged[Any], sensor: Judged[Any], camera: Camera) -> Iterator[_Found]:
    places: list[tuple[Judged[Any], KeyPath]] = [
        (sensor, ("quantum_efficiency", "curves", letter)) for letter in camera.cfa.channels
    ]
    stacks: tuple[tuple[Judged[Any], KeyPath], ...] = ((scene, ("lens", "filters")), (sensor, ("filters",)))
    for document, stack in stacks:
        given = document.value(stack)
        places += [(document, (*stack, index)) for index in range(len(given) if isinstance(given, list) else 0)]
    for document, path in places:
        if not isinstance(document.value(path), dict):
            continue
        table = document.part(path, schema.Curve) or document.part(path, schema.FilterCurve)
        if table is not None:
            yield document, path, table


def _missing(first_nm: float, last_nm: float, light: Light) -> str:
    """Return which intervals of the light are missing and how much they hold, in words; empty if next to nothing."""
    samples = light.samples([Curve((first_nm, last_nm), (1.0, 1.0))])
    photons, lit_nm, parts = samples.weight_nm * samples.photons_per_um2_s_nm, light.ends_nm, []
    for outside, ends in (
        (samples.wavelength_nm < first_nm, (lit_nm[0], first_nm)),
        (samples.wavelength_nm > last_nm, (last_nm, lit_nm[1])),
    ):
        share = float(photons[outside].sum() / photons.sum())
        if share > 0.5 * _NEGLIGIBLE:
            parts.append((share, f"{ends[0]:g}..{ends[1]:g} nm is missing, with {100.0 * share:.2g} % of the photons"))
    return " and ".join(words for _, words in parts) if sum(share for share, _ in parts) > _NEGLIGIBLE else ""
