"""The captures of a study, loaded and validated: all faults are reported before any is taken."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from camsim.api import Exposed, load_any
from camsim.camera.frame import Product
from camsim.camera.given_light import GivenLight
from camsim.camera.shot import Shot
from camsim.errors import ConfigError, Fault
from camsim.files.describe import canonical, software
from camsim.scene import Picture, Scene
from camsim.study.study import MOST_POINTS, Point, Study, V
from camsim.study.values import is_drawn

Progress = Callable[[str, float], None]
_MOST_FAULTS = 20


def captures_of(study: Study[V], products: Sequence[Product], report: Progress) -> list[tuple[Point, Exposed]]:
    """Return every point with its capture; raises ConfigError with all faults."""
    model, faults, found = study.model, _Faults(), list[tuple[Point, Exposed]]()
    scenes, lights = dict[bytes, Scene](), dict[str, GivenLight]()
    seeds = set[int]()
    for point in study.points():
        report("read", point.index / study.count)
        capture = _loaded(study, point, products, faults)
        if capture is None:
            if len(faults.of) >= _MOST_FAULTS:
                break
            continue
        seed = capture.seed
        if not _says_its_seed({**model.set, **dict(point.settings)}):
            seed = (seed + point.index + model.seed * MOST_POINTS) % 2**63  # independent noise
            while seed in seeds:  # of another scene with a smaller seed
                seed = (seed + study.count) % 2**63
        seeds.add(seed)
        if isinstance(capture, Shot):
            light = lights.setdefault(capture.image.sha256, capture.image)
            found.append((point, dataclasses.replace(capture, image=light, seed=seed)))
            continue
        # Captures of one scene share it, to save memory.
        scene = scenes.setdefault(checksum(capture.scene), capture.scene)
        found.append((point, dataclasses.replace(capture, scene=scene, seed=seed)))
    faults.say()
    return found


def checksum(scene: Scene) -> bytes:
    """Return a checksum of a scene, reproducible between runs."""
    content = io.BytesIO()
    _Pickler(content).dump(scene)
    return hashlib.sha256(content.getbuffer()).digest()


class _Pickler(pickle.Pickler):
    """Pickles a picture with the checksum of its samples in their place: they may be many megabytes."""

    def reducer_override(self, value: Any) -> Any:
        """Return what stands for a picture."""
        if not isinstance(value, Picture):
            return NotImplemented
        inside = ("planes", "spectra")
        rest = (getattr(value, one.name) for one in dataclasses.fields(value) if one.name not in inside)
        return Picture, (value.planes.shape, *rest)


def _says_its_seed(settings: Mapping[str, Any]) -> bool:
    """Return whether a study sets the noise's seed, by its key or in a table."""
    noise = settings.get("noise")
    return "noise.seed" in settings or (isinstance(noise, Mapping) and "seed" in noise)


def validate_values(study: Study[V], products: Sequence[Product]) -> list[Exposed]:
    """Load, in every scene, captures with each listed value and with drawn ones; raises ConfigError with all faults."""
    faults = _Faults()
    found = [_loaded(study, point, products, faults) for point in _telling(study)]
    faults.say()
    return [capture for capture in found if capture is not None]


def _telling(study: Study[V]) -> Iterator[Point]:
    """Yield the first point of every scene, and of every listed value within it."""
    seen = set[tuple[str, str, str]]()
    drawn = {key for key, values in study.model.vary.items() if is_drawn(values)}
    for point in study.points():
        stated = {(point.scene, key, json.dumps(value)) for key, value in point.settings if key not in drawn}
        stated.add((point.scene, "", ""))
        if not stated <= seen:
            seen |= stated
            yield point


class _Faults:
    """Faults, and their scenes."""

    def __init__(self) -> None:
        self.of: dict[str, tuple[Fault, dict[str, None]]] = {}
        self.tried: dict[str, None] = {}

    def add(self, fault: Fault, scene: str) -> None:
        """Note a fault of a scene."""
        self.of.setdefault(str(fault), (fault, {}))[1][scene] = None

    def say(self) -> None:
        """Raise ConfigError if there are faults; one that is not in all scenes names the scenes that have it."""
        if not self.of:
            return
        said = []
        for fault, scenes in self.of.values():
            those = f"in {', '.join(Path(scene).stem for scene in scenes)}: " if len(scenes) < len(self.tried) else ""
            said.append(dataclasses.replace(fault, message=those + fault.message))
        raise ConfigError(said)


def _loaded(study: Study[V], point: Point, products: Sequence[Product], faults: _Faults) -> Exposed | None:
    faults.tried[point.scene] = None
    try:
        return load_any(point.scene, sensor=study.sensor, overrides=study.overrides(point), products=tuple(products))
    except ConfigError as error:
        for fault in error.faults:
            faults.add(study.fault(fault), point.scene)
        return None


def identity_of(capture: Exposed, *asked: Any) -> str:
    """Return a key of a capture and its requested results: equal for equal results."""
    made_of = [capture.description(capture.frame_number), capture.optical_key, *asked, software()]
    return hashlib.sha256(canonical(made_of).encode()).hexdigest()
