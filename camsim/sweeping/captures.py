"""The captures of a study, loaded and judged: all that is wrong with any is said before one is taken."""

from __future__ import annotations

import dataclasses
import hashlib
import pickle
from collections.abc import Callable, Sequence
from typing import Any

from camsim.capturing import load
from camsim.errors import ConfigError, Fault
from camsim.exposing import Capture
from camsim.files.describe import canonical, software
from camsim.frame import Product
from camsim.scene import Scene
from camsim.sweeping.study import Point, Study, V

Progress = Callable[[str, float], None]
_MOST_FAULTS = 20


def captures_of(study: Study[V], products: Sequence[Product], report: Progress) -> list[tuple[Point, Capture]]:
    """Return every point with its capture; raises ConfigError with what is wrong with any of them."""
    model, faults, scenes, found = study.model, dict[str, Fault](), dict[bytes, Scene](), []
    for point in study.points():
        report("read", point.index / study.count)
        overrides = point.overrides(model.set)
        try:
            capture = load(point.scene, sensor=model.sensor, overrides=overrides, products=tuple(products))
        except ConfigError as error:
            for fault in map(study.fault, error.faults):
                faults.setdefault(str(fault), fault)
            if len(faults) >= _MOST_FAULTS:
                break
            continue
        seed = capture.seed
        if "noise.seed" not in (*model.set, *dict(point.settings)):
            seed = (seed + point.index) % 2**63  # noise of its own
        # Captures of one scene hold it once, whatever its size.
        scene = scenes.setdefault(hashlib.sha256(pickle.dumps(capture.scene)).digest(), capture.scene)
        found.append((point, dataclasses.replace(capture, scene=scene, seed=seed)))
    if faults:
        raise ConfigError(list(faults.values()))
    return found


def identity_of(capture: Capture, *asked: Any) -> str:
    """Return a name of a capture and of what is asked of it: equal for equal results."""
    made_of = [capture.description(capture.frame_number), capture.optical_key, *asked, software()]
    return hashlib.sha256(canonical(made_of).encode()).hexdigest()
