"""Charts and drawings of scene files to shapes; a chart's keys are the parameters of its function."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from camsim.config import schema
from camsim.config.lengths import SceneDocument, made, scaled
from camsim.config.library import in_folder
from camsim.config.schema.charts import LENGTH, is_of_reflectances, key_of
from camsim.config.tree import KeyPath
from camsim.scene.charts import KNOWN, Chart, parameters
from camsim.scene.svg import Svg, read_svg
from camsim.spectra.curve import Spectrum

MakeSpectrum: TypeAlias = Callable[[SceneDocument, KeyPath], Spectrum | None]


def chart(scene: SceneDocument, path: KeyPath, unit_um: float, spectrum: MakeSpectrum) -> Chart | None:
    """Return the chart at ``path``; None when it is wrong (the document has the faults)."""
    name = str(scene.value((*path, "name")))
    draw = KNOWN.get(name)
    if draw is None:
        return None
    given = scene.value(path)
    spectra = {
        key: _spectra(scene, (*path, key_of(key)), given[key_of(key)], spectrum)
        for key, kind in parameters(draw).items()
        if is_of_reflectances(kind) and given.get(key_of(key)) is not None
    }
    table = scene.part(path, schema.Table)
    if table is None or None in spectra.values():
        return None
    values: Mapping[str, Any] = {key: getattr(table, key_of(key)) for key in parameters(draw)} | spectra

    def make(scale: float) -> Chart:
        lengths = {key: scaled(value, scale) for key, value in values.items() if key.endswith(LENGTH)}
        return Chart(name=name, parameters={**values, **lengths})

    keys: dict[str, KeyPath] = {key: (key_of(key),) for key in values}
    return made(scene, path, make, unit_um, keys)


def drawing(scene: SceneDocument, path: KeyPath, unit_um: float, spectrum: MakeSpectrum) -> Svg | None:
    """Return the drawing at ``path``; None when it is wrong (the document has the faults)."""
    given = scene.value(path)
    colours = given.get("palette") if isinstance(given.get("palette"), Mapping) else {}
    palette: dict[str, Any] = {colour: spectrum(scene, (*path, "palette", colour)) for colour in colours}
    table = scene.part(path, schema.Svg)
    if table is None or None in palette.values() or any(schema.Svg.contradictions(given)):
        return None
    file = scene.build((*path, "file"), lambda: in_folder(scene.document.folder, table.file))
    if file is None:
        return None
    return scene.build(
        path,
        lambda: read_svg(
            file,
            width_um=scaled(table.width, unit_um),
            height_um=scaled(table.height, unit_um),
            centre_um=scaled(table.centre, unit_um),
            rotate_deg=table.rotate_deg,
            palette=palette,
        ),
        keys={"width_um": ("width",), "height_um": ("height",), "centre_um": ("centre",)},
    )


def _spectra(
    scene: SceneDocument, path: KeyPath, given: Any, spectrum: MakeSpectrum
) -> Spectrum | tuple[Spectrum, ...] | None:
    """Make the reflectance at a place, or the list of them."""
    if not isinstance(given, list):
        return spectrum(scene, path)
    spectra = [spectrum(scene, (*path, index)) for index in range(len(given))]
    whole = tuple(one for one in spectra if one is not None)
    return whole if len(whole) == len(given) else None
