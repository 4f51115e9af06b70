"""``camsim new``: a commented file to start from."""

from __future__ import annotations

from pathlib import Path

from camsim.config.library import YAML_SUFFIXES
from camsim.config.pictured import is_picture, scene_of, way_out_of
from camsim.errors import InvalidValueError, OutputError
from camsim.files.atomic import write_whole

_NEXT = {
    "scene": "camsim validate {0} --draw - shows it, camsim capture {0} takes its picture",
    "sensor": "camsim show {0} says what follows from it, camsim capture SCENE --sensor {0} uses it",
    "dataset": "camsim dataset {0} -o FOLDER makes its samples",
    "study": "camsim sweep {0} -o FOLDER takes its captures, --dry-run says what that takes",
}


def template(kind: str) -> str:
    """Return the text of a scene, a sensor or a study, with a comment to every line."""
    return (Path(__file__).parent / "templates" / f"{kind}.yaml").read_text(encoding="utf-8")


def check_yaml_output(path: str, *, force: bool) -> None:
    """Raise early for a YAML file that cannot be written."""
    if not path.endswith(YAML_SUFFIXES):
        raise OutputError(f"cannot write {path!r}: it is YAML, give a name that ends in .yaml")
    if Path(path).exists() and not force:
        raise OutputError(f"{path!r} exists; overwrite it with --force, or write elsewhere with -o")
    if not Path(path).resolve().parent.is_dir():
        raise OutputError(f"cannot write {path!r}: its folder does not exist; make it first")


def write_template(kind: str, path: str | None, *, picture: str | None = None, force: bool) -> str:
    """Write the template, and return a text on the next step; raises OutputError if the file cannot be written.

    path    : KIND.yaml when None, or a picture's name
    picture : for the scene
    """
    if picture is not None and kind != "scene":
        raise InvalidValueError("is in a scene; write camsim new scene --picture FILE", key="--picture")
    path = path or f"{kind if picture is None else Path(picture).stem}.yaml"
    check_yaml_output(path, force=force)
    if picture is not None and not is_picture(Path(picture)):
        said = way_out_of(Path(picture)) if Path(picture).exists() else ""
        raise InvalidValueError(f"{picture!r} {said or 'is no picture that can be read'}", key="--picture")
    text = template(kind) if picture is None else scene_of(Path(picture), Path(path).parent)
    write_whole(path, text.encode("utf-8"))
    return f"{path}: a {kind} to start from; {_NEXT[kind].format(path)}"
