"""``camsim validate``: all faults of all files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from camsim.capturing import load, load_camera
from camsim.config import yaml_source
from camsim.config.sensor_search import SensorSearch
from camsim.errors import CamsimError
from camsim.optics import Airy


def validate_files(files: Sequence[str], sensors: Sequence[str] = ()) -> None:
    """Print a line for each good file; raises CamsimError with the faults of the others.

    sensors : folders to look for sensors in by name
    """
    search = SensorSearch.of(sensors, Path())
    errors: list[CamsimError] = []
    for file in files:
        try:
            print(f"{file}: {_validated(file, search)}, no faults")
        except CamsimError as error:
            errors.append(error)
    if errors:
        raise CamsimError("\n".join(str(error) for error in errors))


def _validated(file: str, search: SensorSearch) -> str:
    _, located = search.locate_any(file)
    tree = yaml_source.read(located.path, located.shown).tree
    said = tree.get("camsim") if isinstance(tree, dict) else None
    if isinstance(said, str) and said.startswith("sensor/"):
        # A sensor is whole without a lens; any will do to build the camera.
        load_camera(file, lens=Airy(f_number=8.0), sensors=search.own)
        return "a sensor"
    load(file, sensors=search.own)
    return "a scene"
