"""Pictures of a scene file: read from files under the scene's folder."""

from __future__ import annotations

from pathlib import Path

from camsim.config import library, schema
from camsim.config.tree import KeyPath
from camsim.config.validated import Validated
from camsim.scene import Picture


def picture(scene: Validated[schema.SceneFile], path: KeyPath, unit_um: float) -> Picture | None:
    """Make the picture at a place of a scene; None when it is wrong (the document has the faults)."""
    table = scene.part(path, schema.Picture)
    if table is None:
        return None
    return scene.build((*path, "file"), lambda: _read(table, scene.document.folder, unit_um))


def _read(table: schema.Picture, folder: Path, unit_um: float) -> Picture:
    from camsim.files.picture_file import read_picture

    return read_picture(
        library.in_folder(folder, table.file),
        encoding=table.encoding,
        scale=table.scale,
        wavelength_nm=table.wavelength_nm,
        tolerance=table.tolerance,
        layer=table.layer,
        width_um=None if table.width is None else table.width * unit_um,
        sample_um=None if table.sample is None else table.sample * unit_um,
        centre_um=(table.centre[0] * unit_um, table.centre[1] * unit_um),
        rotate_deg=table.rotate_deg,
        interpolation=table.interpolation,
    )
