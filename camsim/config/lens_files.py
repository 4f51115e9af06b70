"""Lens files: read, validated, and converted to a ``FieldLens``."""

from __future__ import annotations

from typing import Any

from camsim.config import library, yaml_source
from camsim.config.library import Located
from camsim.config.tree import Document
from camsim.config.validated import Validated
from camsim.errors import ConfigError
from camsim.optics import FieldLens
from camsim.spectra.curve import Spectrum

ABOUT = ("camsim", "name", "source", "residual_waves", "residual_mtf")  # informative keys without effect


def read_lens_file(located: Located, *, focus_um: float = 0.0, transmission: Spectrum = 1.0) -> FieldLens:
    """Return the lens of a file; raises ConfigError with all of its faults."""
    return lens_of(yaml_source.read(located.path, located.displayed), focus_um=focus_um, transmission=transmission)


def lens_of(source: Document, *, focus_um: float = 0.0, transmission: Spectrum = 1.0) -> FieldLens:
    """Return the lens of a file's content; raises ConfigError with all of its faults."""
    from camsim.config.schema.lens_file import LensFile  # imported here, as few captures need it

    document = Validated.of(source, LensFile)
    table = document.model
    lens = None
    if table is not None:
        given: dict[str, Any] = {key: getattr(table, key) for key in LensFile.model_fields if key not in ABOUT}
        lens = document.build((), lambda: FieldLens(**given, focus_um=focus_um, transmission=transmission))
    if lens is None:
        raise ConfigError(document.faults)
    return lens


def locate_lens(name: str, scene: Validated[Any]) -> Located:
    """Find a lens named by a scene: a shipped one, or a file under the scene's folder (for overrides: any path)."""
    node = scene.document.find(("lens", "file"))
    if not library.looks_like_path(name) or node is None or not node.place.line:
        return library.locate("lens", name)
    path = library.in_folder(scene.document.folder, name)
    return Located(path, str(path))
