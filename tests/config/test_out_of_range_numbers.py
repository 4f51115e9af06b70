"""Every number of every example of a lens, a light, an exposure and a sensor, far off: judged, and never a crash.

What is a billion times too large or too small is a length in another unit; before it is rendered it is refused, or it
is of a size that engines follow.
"""

import copy
import json
import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from camsim.api import load
from camsim.config.reference import examples
from camsim.config.schema import SceneFile, SensorFile
from camsim.errors import CamsimError
from camsim.rendering.scales import LEAST_BLUR, MOST_BLUR, check_scales
from tests.blocks import SCENE, SENSOR

OWN = {"lens", "light", "exposure"}
Path_ = tuple[str | int, ...]


def leaves(tree: Any, path: Path_ = ()) -> Iterator[tuple[Path_, float]]:
    """Every number of a tree with its path; of lists the first one."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from leaves(value, (*path, key))
    elif isinstance(tree, list) and tree:
        yield from leaves(tree[0], (*path, 0))
    elif isinstance(tree, int | float) and not isinstance(tree, bool):
        yield path, tree


def cases() -> Iterator[tuple[str, Path_, float]]:
    """Yield a part of a file as JSON, with the path and the value of each of its numbers, each key once."""
    seen = set()
    for parts in examples().values():
        for text in parts:
            tree = yaml.safe_load(text)
            keys, mine = tree.keys(), tree.keys() & OWN
            if (
                "camsim" in tree
                or tree.get("lens") == "none"
                or not (mine == keys or keys <= SensorFile.model_fields.keys() - {"filters"})
            ):
                continue
            for path, value in leaves(tree):
                place = tree[path[0]]
                kind = place.get("kind") if isinstance(place, dict) else None
                key = (kind, tuple(part for part in path if isinstance(part, str)))
                if key not in seen:
                    seen.add(key)
                    yield json.dumps(tree), path, value


CASES = list(cases())


def with_value(tree: Any, path: Path_, value: float) -> Any:
    """Return a tree with another number at a path."""
    changed = copy.deepcopy(tree)
    here = changed
    for key in path[:-1]:
        here = here[key]
    here[path[-1]] = value
    return changed


def test_there_are_all_kinds() -> None:
    assert len(CASES) > 80
    assert {path[0] for _, path, _ in CASES} >= {*OWN, "frame", "photosite", "olpf", "charge", "readout"}


@pytest.mark.parametrize(("part", "path", "value"), CASES, ids=[".".join(map(str, path)) for _, path, _ in CASES])
def test_it_is_refused_or_of_a_size_that_engines_follow(
    part: str, path: Path_, value: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tree = json.loads(part)
    (tmp_path / "qe.csv").write_text("nm,R,G,B\n380,0,0,0\n480,0.05,0.2,0.5\n700,0,0,0\n", encoding="utf-8")
    np.save("psf.npy", np.outer(np.hanning(9), np.hanning(9)))
    np.save("otf.npy", np.outer(np.bartlett(9), np.bartlett(9)))
    for number in (1e-9 * value, 1e-300, 1e9 * value, 1e300, -value, 0, math.nan):
        changed = with_value(tree, path, number)
        whole = [SCENE | {"sensor": "sensor.yaml"}, dict(SENSOR)]
        whole[not tree.keys() <= SceneFile.model_fields.keys()] |= changed
        for name, content in zip(("scene.yaml", "sensor.yaml"), whole, strict=True):
            (tmp_path / name).write_text(json.dumps(content).replace("NaN", ".nan"), encoding="utf-8")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                ready = load("scene.yaml")
                check_scales(ready.camera.optics, ready.grid, np.array([400.0, 700.0]))
            except CamsimError:
                continue
        blur_pitches = ready.camera.optics.blur_um(550.0) / ready.camera.pitch_um
        assert LEAST_BLUR / 2 < blur_pitches < MOST_BLUR * 2
        assert 0.5 <= ready.camera.lens.f_number <= 10_000
