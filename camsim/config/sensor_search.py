"""Sensors by name: in the user's folders, next to a scene, and shipped with camsim."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from camsim.config.library import YAML_SUFFIXES, Kind, Located, in_folder, locate, locate_path, looks_like_path, shipped
from camsim.core.words import displayed
from camsim.errors import InvalidValueError, UnknownNameError

PATH_VARIABLE = "CAMSIM_PATH"
"""Folders with sensors, separated as in PATH; missing ones are ignored."""

_HEAD_BYTES = 65_536
_SENSOR = re.compile(r"^\s*\{?\s*['\"]?camsim['\"]?\s*:\s*['\"]?sensor/", re.MULTILINE)
_WHERE = (
    "; your own lies beside the scene, in sensors there or in ../sensors, in --sensors DIR, or is named by its path"
)


@dataclass(frozen=True, slots=True)
class SensorSearch:
    """Search order of sensors by name: the first match wins; shipped ones come last.

    given        : folders given by the user
    scene_folder : it, ``sensors`` in it and ``../sensors`` are searched, and no other place, so that a scene from
                   elsewhere reads nothing of the disk
    """

    given: tuple[Path, ...]
    scene_folder: Path

    @classmethod
    def of(cls, folders: str | os.PathLike[str] | Iterable[str | os.PathLike[str]], scene_folder: Path) -> SensorSearch:
        """Return a search of these folders, CAMSIM_PATH's and the scene's; raises InvalidValueError for a wrong one."""
        given = [folders] if isinstance(folders, str | os.PathLike) else folders
        try:
            named = [Path(folder) for folder in given]
        except TypeError:
            message = f"must be a list of folders, not {displayed(folders)}"
            raise InvalidValueError(message, key="--sensors") from None
        for folder in named:
            if not folder.is_dir():
                message = f"{str(folder)!r} is no folder; name one that holds sensor files"
                raise InvalidValueError(message, key="--sensors")
        said = os.environ.get(PATH_VARIABLE, "").split(os.pathsep)
        return cls((*named, *(Path(folder) for folder in said if folder)), scene_folder)

    def locate(self, name: str) -> Located:
        """Find a sensor by its bare name; raises UnknownNameError with the names that exist."""
        for folder in self._folders():
            for suffix in YAML_SUFFIXES:
                path = folder / f"{name}{suffix}"
                if self._holds(folder, path):
                    return Located(path, str(path))
        known = shipped("sensor")
        if name in known:
            return Located(known[name], f"sensors/{name}.yaml")
        raise UnknownNameError("sensor", name, {known for known, _ in self.all()}, hint=_WHERE)

    def locate_any(self, name: str) -> tuple[Kind, Located]:
        """Find a sensor, scene or lens by its path or its name; a path counts as a sensor until it has been read."""
        if (found := locate_path("sensor", name)) is not None:
            return "sensor", found
        known = {found for found, _ in self.all()}
        if name in known:
            return "sensor", self.locate(name)
        others: tuple[Kind, ...] = ("scene", "lens")
        for kind in others:
            if name in shipped(kind):
                return kind, locate(kind, name)
        raise UnknownNameError("sensor, scene or lens", name, known.union(*map(shipped, others)))

    def locate_path_or_name(self, name: str) -> Located:
        """Find what the user named on the command line or in Python: a path from here, or a name."""
        return locate_path("sensor", name) or self.locate(name)

    def locate_in_folder(self, name: str) -> Located:
        """Find what a scene names: a name, or a file under the scene's folder or in ``../sensors``."""
        if not looks_like_path(name):
            return self.locate(name)
        way_out = "put it there or into ../sensors, or name it with --sensor"
        path = in_folder(self.scene_folder, name, way_out=way_out, also=self.scene_folder / ".." / "sensors")
        return Located(path, str(path))

    def all(self) -> Iterator[tuple[str, Located]]:
        """Yield every sensor that can be found by name: folder by folder, in each by name."""
        seen: set[str] = set()
        for folder in self._folders():
            paths = [path for suffix in YAML_SUFFIXES for path in folder.glob(f"*{suffix}")]
            for path in sorted(paths):
                if path.stem not in seen and self._holds(folder, path):
                    seen.add(path.stem)
                    yield path.stem, Located(path, str(path))
        for name, path in shipped("sensor").items():
            if name not in seen:
                yield name, Located(path, f"sensors/{name}.yaml")

    def _folders(self) -> Iterator[Path]:
        yield from self.given
        here = self.scene_folder
        yield from (here, here / "sensors", Path(os.path.normpath(here / ".." / "sensors")))

    def _holds(self, folder: Path, path: Path) -> bool:
        """Whether a sensor is there; next to a scene, links must not leave the folder."""
        if not os.path.isfile(path):
            return False
        if folder not in self.given and not path.resolve().is_relative_to(folder.resolve()):
            return False
        try:
            with path.open("rb") as file:
                return _SENSOR.search(file.read(_HEAD_BYTES).decode("utf-8-sig", "replace")) is not None
        except OSError:
            return False
