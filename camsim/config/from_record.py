"""Reconstruction of stages from a description, such as that of a file."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast, get_args

import camsim
from camsim.camera.capture import Capture
from camsim.camera.description import CUSTOM_STAGES
from camsim.camera.given_light import GivenLight
from camsim.camera.shot import Shot
from camsim.core.words import both
from camsim.errors import CamsimError, InputError
from camsim.files.light_file import read_light
from camsim.files.picture_file import read_picture
from camsim.measure.dark_frames import read_darks, read_offsets
from camsim.optics.no_lens import NO_LENS
from camsim.scene import Picture
from camsim.sensor.stages.dark_frames import DarkFrames
from camsim.sensor.stages.offset_map import OffsetMap, OffsetUnit

_RESULTS = ("Frame", "Rendering", "Report", "Context")
"""Public results, which are never inputs."""

_HOW_READ = ("encoding", "scale", "wavelength_nm", "tolerance", "layer")
_PLACED = ("width_um", "centre_um", "rotate_deg", "interpolation")
"""Keys of a picture's placement in its description."""


def stages_from_record(tree: Any, folder: Path | None = None) -> Any:
    """Return the objects that ``describe`` turned into a tree; lists become tuples.

    folder : in which pictures are searched

    Only camsim's public stages are made from a tree, and each validates its parameters. Raises InputError for other
    stages, unknown parameters and invalid values.

    >>> stages_from_record({"kind": "SquarePhotosite", "side_um": 3.66})
    SquarePhotosite(side_um=3.66)
    """
    try:
        return _stage_from_record(tree, "description", folder)
    except RecursionError:
        raise InputError("it is nested too deeply", key="description") from None


def capture_from_record(description: Mapping[str, Any], folder: Path | None = None) -> Capture:
    """Return the capture of a description; ``folder``: in which pictures are searched."""
    if "image" in description:
        raise InputError("it was exposed to a custom light, and there is no scene that says what is right")
    return cast(Capture, _exposure(Capture, description, folder))


def shot_from_record(description: Mapping[str, Any], folder: Path | None = None) -> Capture | Shot:
    """Return the capture, or light on a sensor, of a description; ``folder``: of pictures and light."""
    if "image" in description:
        return cast(Shot, _exposure(Shot, description, folder))
    return capture_from_record(description, folder)


def _exposure(exposed: type, description: Mapping[str, Any], folder: Path | None) -> Any:
    if one := description.get(CUSTOM_STAGES):
        names = [ascii(name)[1:-1][:40] for name in one if isinstance(name, str)] if isinstance(one, list) else []
        taken = f"it was taken with {both(names) or 'stages'}, which camsim does not have"
        raise InputError(f"not reproducible by camsim alone: {taken}; take it again in Python, where these are there")
    parts = stages_from_record(description, folder)
    kinds = _parameters(exposed)
    for name, needed in kinds.items():
        if needed and name not in parts:
            raise InputError(f"there is no {name!r}, which a capture needs", key="description")
    if unknown := [name for name in parts if name not in kinds]:
        raise InputError(f"a capture has no {ascii(unknown[0])[:40]}", key="description")
    return _validated(exposed, parts, "description")


def _stage_from_record(tree: Any, place: str, folder: Path | None) -> Any:
    if isinstance(tree, Mapping):
        parts = {
            key: _stage_from_record(value, f"{place}.{key}", folder) for key, value in tree.items() if key != "kind"
        }
        return _make(tree["kind"], parts, place, folder) if "kind" in tree else parts
    if isinstance(tree, (list, tuple)):
        return tuple(
            _stage_from_record(value, place, folder) if isinstance(value, (Mapping, list, tuple)) else value
            for value in tree
        )
    return tree


def _make(kind: Any, parts: Mapping[str, Any], place: str, folder: Path | None) -> Any:
    if kind == "Picture":
        return _picture(parts, place, folder)
    if kind in ("DarkFrames", "OffsetMap"):
        return _dark_signal(kind, parts, place, folder)
    if kind == "NoLens":
        return NO_LENS
    if kind == "GivenLight":
        return _given_light(parts, place, folder)
    stage = _public(kind) if isinstance(kind, str) else None
    if stage is None:
        raise InputError(f"{ascii(kind)[:40]} is not a stage of this version of camsim", stage=place)
    kinds = _parameters(stage)
    if unknown := [name for name in parts if name not in kinds]:
        raise InputError(f"{kind} has no {ascii(unknown[0])[:40]}", stage=place)
    if missing := [name for name, needed in kinds.items() if needed and name not in parts]:
        raise InputError(f"{kind} lacks {missing[0]!r}", stage=place)
    return _validated(stage, parts, place)


def _picture(parts: Mapping[str, Any], place: str, folder: Path | None) -> Picture:
    """Read a picture again: descriptions have its name, reading parameters, and the hash of its samples."""
    source, how = parts.get("source") or "an array", parts.get("read")
    name = ascii(source)[:80]
    if folder is None or not isinstance(how, Mapping) or Path(str(source)).name != source:
        raise InputError(
            f"it shows the picture {name}, which such a file does not hold; capture its scene again", stage=place
        )
    if not (folder / source).is_file():
        raise InputError(
            f"it shows the picture {name}, which such a file does not hold; put that beside it", stage=place
        )
    placed = {key: value for key, value in parts.items() if key not in ("source", "read", "sha256")}
    if unknown := [*({*how} - {*_HOW_READ}), *({*placed} - {*_PLACED})]:
        raise InputError(f"a picture has no {ascii(unknown[0])[:40]}", stage=place)
    try:
        picture = read_picture(folder / source, **how, **placed)
    except CamsimError as error:
        raise InputError(str(error), stage=place) from None
    except (TypeError, ValueError):
        raise InputError(f"it does not say rightly how the picture {name} was read", stage=place) from None
    if picture.sha256 != parts.get("sha256"):
        raise InputError(
            f"the picture {name} beside it is another one than was captured: its samples differ", stage=place
        )
    return picture


def _dark_signal(kind: str, parts: Mapping[str, Any], place: str, folder: Path | None) -> DarkFrames | OffsetMap:
    """Read darks or offsets again, next to the file or in the working directory: descriptions have path and hash."""
    source, what = parts.get("source"), "darks" if kind == "DarkFrames" else "offsets"
    if not isinstance(source, str) or not source:
        message = f"not reproducible: its {what} were an array in Python, which such a file does not hold"
        raise InputError(f"{message}; expose again with them", stage=place)
    nearby = () if folder is None else (folder / source, folder / Path(source).name)
    found = next((each for each in (*nearby, Path(source)) if each.exists()), None)
    if found is None:
        message = f"not reproducible without the {what} {ascii(source)[:200]}"
        raise InputError(f"{message}; put them there, or beside this file", stage=place)
    unit = parts.get("unit")
    if kind == "OffsetMap" and unit not in get_args(OffsetUnit):
        raise InputError(f"offsets have no unit {ascii(unit)[:40]}", stage=place)
    read = read_darks(found, source) if kind == "DarkFrames" else read_offsets(found, source, cast(OffsetUnit, unit))
    if read.sha256 != parts.get("sha256"):
        message = f"not reproducible: the {what} {str(found)!r} are others than were taken, their numbers differ"
        raise InputError(message, stage=place)
    return read


def _given_light(parts: Mapping[str, Any], place: str, folder: Path | None) -> GivenLight:
    """Read given light again, next to the file or at its path: descriptions have path and hash."""
    source, how = parts.get("source"), parts.get("read")
    if not isinstance(source, str) or not source:
        message = "not reproducible: its light was an array in Python, which such a file does not hold"
        raise InputError(f"{message}; expose the array again", stage=place)
    name, path = ascii(source)[:200], Path(source)
    nearby = () if folder is None else (folder / path, folder / path.name)
    found = next((each for each in (*nearby, path) if each.is_file()), None)
    if found is None:
        raise InputError(f"not reproducible without the light {name}; put it there, or beside this file", stage=place)
    stated = {key: value for key, value in parts.items() if key not in ("source", "read", "sha256")}
    layer = how.get("layer") if isinstance(how, Mapping) else None
    if unknown := {*stated} - {"unit", "wavelength_nm", "per_photosite"}:
        raise InputError(f"light has no {ascii(min(unknown))[:40]}", stage=place)
    try:
        light = read_light(found, layer=layer, **stated)
    except CamsimError as error:
        raise InputError(str(error), stage=place) from None
    except (TypeError, ValueError):
        raise InputError(f"it does not say rightly how the light {name} was read", stage=place) from None
    if light.sha256 != parts.get("sha256"):
        message = f"not reproducible: the light {str(found)!r} is another one than was exposed, its samples differ"
        raise InputError(message, stage=place)
    return dataclasses.replace(light, source=source)


def _validated(stage: Any, parts: Mapping[str, Any], place: str) -> Any:
    """Make a stage, which validates its parameters."""
    try:
        return stage(**parts)
    except CamsimError as error:
        raise InputError(error.message, key=error.key, stage=place) from None


def _public(kind: str) -> Any:
    """Return the public dataclass of a name, or None; only this one's module is imported."""
    found = getattr(camsim, kind) if kind in camsim.__all__ and kind not in _RESULTS else None
    return found if dataclasses.is_dataclass(found) else None


@functools.cache
def _parameters(stage: Any) -> Mapping[str, bool]:
    """Return the parameters of a stage, and whether each is required."""
    nothing = dataclasses.MISSING
    return {
        field.name: field.default is nothing and field.default_factory is nothing
        for field in dataclasses.fields(stage)
        if field.init
    }
