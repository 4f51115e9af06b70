"""Every shipped scene has a twin in Python that takes the same picture, byte by byte."""

import runpy

import pytest

import camsim
from camsim.api import load
from camsim.config import library

SCENES = library.shipped("scene")
ROWS, COLS = 8, 12  # of the window that is compared; a scene's own says where it lies


@pytest.fixture
def exposed(monkeypatch):
    """What twins expose, as captures that are not yet taken."""
    captures = []

    def keep(camera, scene, *, light, exposure, **others):
        captures.append(camsim.Capture(camera=camera, scene=scene, light=light, exposure=exposure, **others))

    monkeypatch.setattr(camsim.Camera, "expose", keep)
    return captures


def test_there_are_twenty_scenes_and_each_has_a_twin():
    assert len(SCENES) >= 20
    assert {path.stem for path in next(iter(SCENES.values())).parent.glob("*.py")} == set(SCENES)


@pytest.mark.parametrize("name", list(SCENES))
def test_a_twin_says_what_its_file_says(name, exposed):
    """All that a picture depends on is equal; so its bytes are."""
    runpy.run_path(str(SCENES[name].with_suffix(".py")))
    (twin,) = exposed
    file = load(name)
    for part in ("camera", "scene", "light", "exposure", "tolerance", "method", "noise", "seed", "frame_number"):
        assert getattr(file, part) == getattr(twin, part), part
    assert file.region == twin.region
