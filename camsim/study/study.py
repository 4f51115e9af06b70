"""A study: its captures, each a pure function of its index."""

from __future__ import annotations

import glob
import itertools
import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from camsim.config import library, yaml_source
from camsim.config.schema.study import LIGHT_FILE, DatasetFile, StudyFile, Values, Varying
from camsim.config.tree import Document, KeyPath
from camsim.config.validated import Validated
from camsim.config.yaml_text import yaml_text
from camsim.core.typed import FilePath, check
from camsim.errors import CamsimError, ConfigError, Fault, UnknownNameError
from camsim.study.mapping import plain
from camsim.study.names import Template, columns_of, field_of
from camsim.study.values import drawn, is_drawn, listed

V = TypeVar("V", bound=Varying)
StudyOrFile: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]
MOST_POINTS = 10_000_000
_FILES = ("sensor", LIGHT_FILE)
"""Keys whose values may be files in the study's folder."""

_LIGHT_ALONE = Path(library.__file__).with_name("light.yaml")
"""The scene of studies with given light."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One capture of a study.

    settings : values of the varying keys, in order
    """

    index: int
    scene: str
    settings: tuple[tuple[str, Any], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Study(Generic[V]):
    """The content of a study's or data set's file, with its scenes located.

    document, model : the file with places, and as a model
    scenes : paths, or names of shipped scenes
    """

    name: str
    document: Document
    model: V
    scenes: tuple[str, ...]

    @property
    def count(self) -> int:
        """Number of captures, each of one or more frames."""
        lengths = [len(values) for values in self._fixed]
        if not lengths:
            combinations = 1
        elif self.model.combine == "product":
            combinations = math.prod(lengths)
        else:
            combinations = max(lengths) if self.model.combine == "zip" else sum(lengths)
        return len(self.scenes) * combinations * self.model.draws

    def fault(self, fault: Fault) -> Fault:
        """Return a fault of an override, moved to the place in the study where its value stands."""
        word, _, key = fault.file.partition(" ")
        if word != "--set":
            return fault
        if key == LIGHT_FILE and self.model.light is not None:
            return self.document.fault(("light",), fault.message)
        part = "vary" if key in self.model.vary else "set"
        return self.document.fault((part, key), fault.message)

    @property
    def sensor(self) -> str | None:
        """The sensor that replaces the sensors of the scenes; None if they keep theirs."""
        return None if self.model.sensor is None else self._in_folder(self.model.sensor)

    def stated(self, point: Point) -> dict[str, Any]:
        """Return a capture's columns: its scene, and a value for each key that the study varies.

        A value is None if this capture does not set the key. Scenes are named after their files, with the folder where
        that is ambiguous.
        """
        path, here = Path(point.scene).with_suffix(""), self.document.folder
        alone = len({scene for scene in self.scenes if Path(scene).stem == path.name}) == 1
        whole = path.relative_to(here) if path.is_relative_to(here) else path
        scene = path.name if alone else whole.as_posix()
        stated: dict[str, Any] = dict.fromkeys(("scene", *map(field_of, self.model.vary))) | {"scene": scene}
        for key, value in point.settings:
            stated |= columns_of(key, value)
        return stated

    def overrides(self, point: Point) -> tuple[str, ...]:
        """Return a capture's keys as ``camsim capture --set`` takes them, after those common to all captures."""
        given = (*self.model.set.items(), *point.settings)
        return tuple(f"{key}={_in_yaml(self._in_folder(value) if key in _FILES else value)}" for key, value in given)

    def _in_folder(self, name: Any) -> Any:
        """Return the path of a file in the study's folder; other names unchanged."""
        path = self.document.folder / name if isinstance(name, str) else None
        return os.fspath(path) if path is not None and path.is_file() else name

    def points(self) -> Iterator[Point]:
        """Yield the captures in the order of their indices: scenes vary slowest, random draws fastest."""
        places = itertools.product(self.scenes, self._combinations(), range(self.model.draws))
        for index, (scene, fixed, _) in enumerate(places):
            settings = dict(fixed)
            for key, values in self.model.vary.items():
                if isinstance(values, Values) and is_drawn(values):
                    settings[key] = drawn(values, seed=self.model.seed, key=key, index=index)
            ordered = tuple((key, settings[key]) for key in self.model.vary if key in settings)
            yield Point(index=index, scene=scene, settings=ordered)

    @property
    def _fixed(self) -> list[list[tuple[str, Any]]]:
        """Listed values: (key, value) of each value of each key."""
        fixed = {key: listed(values) for key, values in self.model.vary.items() if not is_drawn(values)}
        return [[(key, value) for value in values] for key, values in fixed.items()]

    def _combinations(self) -> Iterator[tuple[tuple[str, Any], ...]]:
        """Yield combinations of listed values."""
        pairs = self._fixed
        if self.model.combine == "zip" and pairs:
            return zip(*pairs, strict=True)
        if self.model.combine == "sequential" and pairs:
            return ((pair,) for key in pairs for pair in key)
        return itertools.product(*pairs)


def read_study(study: StudyOrFile) -> tuple[Study[StudyFile], tuple[Template, ...]]:
    """Read a study, a file or its keys as a mapping, and the templates of its files. Raises ConfigError."""
    validated, stem = _validated(study, StudyFile, "study")
    files = _templates(validated)
    return _found(validated, stem), files


def read_dataset(dataset: StudyOrFile) -> Study[DatasetFile]:
    """Read a data set's file, or its keys as a mapping. Raises ConfigError with every fault."""
    return _found(*_validated(dataset, DatasetFile, "dataset"))


def _in_yaml(value: Any) -> str:
    """Return a value as JSON, with YAML's escapes: without surrogate pairs for characters beyond 2^16."""
    text = json.dumps(value, ensure_ascii=False)
    return "".join(letter if letter.isascii() else f"\\U{ord(letter):08X}" for letter in text)


def _validated(given: StudyOrFile, model: type[V], kind: str) -> tuple[Validated[V], str]:
    if isinstance(given, Mapping):
        text = yaml_text({"camsim": f"{kind}/1", **plain(given, kind)})
        return Validated.of(yaml_source.parse(text.encode(), kind, Path()), model), kind
    file = check(given, FilePath, kind)
    library.refuse_pictures(Path(file), file)
    return Validated.of(yaml_source.read(Path(file), file), model), Path(file).stem


def _found(validated: Validated[V], stem: str) -> Study[V]:
    """Return the study of a validated file; raises ConfigError with all faults."""
    scenes, model = _scenes(validated), _globbed(validated)
    if model is not None and model.combine == "zip":
        lengths = {key: len(listed(values)) for key, values in model.vary.items() if not is_drawn(values)}
        if len(set(lengths.values())) > 1:
            stated = ", ".join(f"{key} has {length}" for key, length in lengths.items())
            validated.refuse(("combine",), f"zip takes lists of one length, and {stated}; or combine: product")
    if not validated.faults and model is not None:
        found = Study(name=model.name or stem, document=validated.document, model=model, scenes=scenes)
        frames = found.count * (model.frames if isinstance(model, StudyFile) else 1)
        if frames <= MOST_POINTS:
            return found
        validated.refuse(("vary",), f"makes {frames} frames; {MOST_POINTS} are the most")
    raise ConfigError(validated.faults)


def _globbed(study: Validated[V]) -> V | None:
    """Return the model with matching file names in place of patterns."""
    if (model := study.model) is None:
        return None
    folder, vary = study.document.folder, dict(model.vary)
    if model.light is not None:
        vary = {LIGHT_FILE: Values(glob=model.light), **vary}
    for key, values in list(vary.items()):
        if isinstance(values, Values) and values.glob is not None:
            names = glob.glob(values.glob, root_dir=folder, recursive=True)
            files = sorted(Path(name).as_posix() for name in names if (folder / name).is_file())
            if not files:
                place: KeyPath = ("light",) if key == LIGHT_FILE and model.light else ("vary", key, "glob")
                study.refuse(place, f"no file of {str(folder)!r} matches {values.glob!r}")
            vary[key] = list(files)
    return model.model_copy(update={"vary": vary})


def _scenes(study: Validated[V]) -> tuple[str, ...]:
    given = study.value(("scene",))
    if given is None and study.value(("light",)) is not None:
        return (os.fspath(_LIGHT_ALONE),)
    names = given if isinstance(given, list) else [given]
    found = []
    for number, name in enumerate(names):
        if not isinstance(name, str):
            continue
        place = ("scene", number) if isinstance(given, list) else ("scene",)
        path = study.document.folder / name
        try:
            if path.is_file():
                library.refuse_pictures(path, name)
                found.append(os.fspath(path))
                continue
            found.append(os.fspath(library.locate("scene", name).path) if library.looks_like_path(name) else name)
            library.locate("scene", name)
        except UnknownNameError as error:
            study.refuse(place, error.message)
        except ConfigError as error:
            study.refuse(place, f"{name!r}: {error.faults[0].message}")
    return tuple(found)


def _templates(study: Validated[StudyFile]) -> tuple[Template, ...]:
    given, vary = study.value(("files",)), study.value(("vary",))
    if isinstance(study.value(("light",)), str):
        vary = {LIGHT_FILE: None, **(vary if isinstance(vary, Mapping) else {})}
    default = StudyFile.model_fields["files"].default
    texts = given if isinstance(given, list) else [default if given is None else given]
    keys = tuple(vary) if isinstance(vary, Mapping) else ()
    made = []
    for number, text in enumerate(texts):
        if isinstance(text, str):
            try:
                made.append(Template.of(text, keys))
            except CamsimError as error:
                study.refuse(("files", number) if isinstance(given, list) else ("files",), error.message)
    return tuple(made)
