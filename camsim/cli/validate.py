"""``camsim validate``: all faults of all files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from camsim.api import load, load_any, load_camera
from camsim.camera.capture import Capture
from camsim.camera.notes import notes_of_sensor
from camsim.cli.draw import lines, picture
from camsim.cli.plot import check_drawing
from camsim.config import yaml_source
from camsim.config.lens_files import read_lens_file
from camsim.config.sensor_search import SensorSearch
from camsim.core.note import Note
from camsim.errors import CamsimError, InvalidValueError
from camsim.files.atomic import write_whole
from camsim.optics import Airy
from camsim.study import check_dataset, check_study

TERMINAL = "-"
A_SCENE = "a scene"


def validate_files(files: Sequence[str], sensors: Sequence[str] = ()) -> None:
    """Print a line for each good file; raises CamsimError with the faults of the others.

    sensors : folders in which sensors are searched by name
    """
    search = SensorSearch.of(sensors, Path())
    errors: list[CamsimError] = []
    for file in files:
        try:
            said, notes = _validated(file, search)
            print(f"{file}: {said}, no faults")
            for note in notes:
                print(f"{file}: note: {note}")
        except CamsimError as error:
            errors.append(error)
    if errors:
        raise CamsimError("\n".join(str(error) for error in errors))


def draw_scene(
    files: Sequence[str], drawing: str, sensors: Sequence[str], overrides: Sequence[str], *, force: bool
) -> None:
    """Draw a scene with its overrides: into a file, or on the terminal when that is -."""
    if len(files) != 1:
        raise InvalidValueError(f"draws one scene, and {len(files)} files are given", key="--draw")
    search = SensorSearch.of(sensors, Path())
    if drawing != TERMINAL:
        check_drawing(drawing, force=force, option="--draw")
    said, _ = _validated(files[0], search, overrides)
    if said != A_SCENE:
        raise InvalidValueError(f"{files[0]!r} is {said}; give a scene, such as one that uses it", key="--draw")
    capture = load(files[0], overrides=overrides, sensors=search.given)
    if drawing == TERMINAL:
        print("\n".join(lines(capture)))
    else:
        write_whole(drawing, picture(capture, Path(drawing).suffix.lower()[1:]))
        print(f"{drawing}: {capture.scene_name}")


def _validated(file: str, search: SensorSearch, overrides: Sequence[str] = ()) -> tuple[str, Sequence[Note]]:
    """Return the kind of a file, and notes on it."""
    _, located = search.locate_any(file)
    tree = yaml_source.read(located.path, located.displayed).tree
    said = tree.get("camsim") if isinstance(tree, dict) else None
    if isinstance(said, str) and said.startswith("sensor/"):
        # A sensor is valid without a lens; any one serves to build the camera.
        camera = load_camera(file, lens=Airy(f_number=8.0), sensors=search.given)
        return "a sensor", tuple(notes_of_sensor(camera))
    if isinstance(said, str) and said.startswith("lens/"):
        read_lens_file(located)
        return "a lens", ()
    if isinstance(said, str) and said.startswith("study/"):
        check_study(file)
        return "a study", ()
    if isinstance(said, str) and said.startswith("dataset/"):
        check_dataset(file)
        return "a data set", ()
    ready = load_any(file, overrides=overrides, sensors=search.given)
    return (A_SCENE if isinstance(ready, Capture) else "light on a sensor"), ()
