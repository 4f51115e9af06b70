"""A YAML file and its Python twin give the same picture; names and overrides reach it."""

import numpy as np
import pytest

import camsim
from camsim.api import load
from camsim.config.overrides import parse

pytestmark = pytest.mark.usefixtures("folder")


def test_overrides_and_flags_reach_the_picture() -> None:
    frame = camsim.capture(
        "good.yaml", sensor="d40-like", overrides=["exposure.iso=400", "noise.enabled=false"], seed=7
    )
    assert (frame.camera_name, frame.iso, frame.seed) == ("D40-like, 4.88 µm", 400.0, 7)
    np.testing.assert_array_equal(frame.electrons, frame.mean_electrons)
    assert frame.truth is None


def test_frames_are_numbered_from_the_scenes_own() -> None:
    """A frame's temporal noise goes by its number: the third and fourth of a Python loop are these two."""
    small = ["region={rows: 8, cols: 10}", "noise.frame_number=3"]
    setup = load("good.yaml", overrides=small)
    how = {"light": setup.light, "exposure": setup.exposure, "seed": 1, "region": setup.region, "tolerance": 1e-3}
    numbered = [setup.camera.expose(setup.scene, frame_number=n, **how).mosaic for n in (3, 4)]
    assert (numbered[0] != numbered[1]).any()
    for number, frame in enumerate(setup.frames(2)):
        np.testing.assert_array_equal(frame.mosaic, numbered[number])
    np.testing.assert_array_equal(setup.frame().mosaic, numbered[0])
    rows: list[np.ndarray] = []
    setup.rows(rows.append)
    np.testing.assert_array_equal(np.concatenate(rows), numbered[0])


def test_progress_is_told() -> None:
    stated: list[tuple[str, float]] = []
    camsim.capture("good.yaml", progress=lambda stage, fraction: stated.append((stage, fraction)))
    assert stated
    assert all(stage and 0.0 <= fraction <= 1.0 for stage, fraction in stated)


def test_overrides_are_read_without_a_file() -> None:
    changes, faults = parse(["sensor.olpf=null", "noise.seed=3"])
    assert [(change.of_sensor, change.path) for change in changes] == [
        (True, ("olpf",)),
        (False, ("noise", "seed")),
    ]
    assert faults == []
