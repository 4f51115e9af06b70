"""``camsim show --expand``: what it prints is a scene of ordinary shapes that paints the same."""

from pathlib import Path

import numpy as np
import pytest

from camsim.api import load
from camsim.camera.description import describe
from camsim.cli.expand import expanded
from camsim.config import library
from camsim.scene import flattened


@pytest.mark.parametrize("name", ["bars", "colorchecker-card", "drawing", "groups", "qr-code", "shapes", "usaf-1951"])
def test_the_shapes_of_a_scene_paint_the_same(name, tmp_path):
    text = "\n".join(expanded(name))
    assert "kind: chart" not in text
    assert "kind: svg" not in text
    whole = library.shipped("scene")[name].read_text(encoding="utf-8")
    head, tail = whole.split("scene:\n")[0], "render:" + whole.split("render:")[1]
    (tmp_path / "scene.yaml").write_text(f"{head}{text}\n{tail}", encoding="utf-8")
    stated, again = load(name).scene, load(tmp_path / "scene.yaml").scene
    assert again.background == stated.background
    for one, two in zip(flattened(stated.shapes), flattened(again.shapes), strict=True):
        assert one.reflectance == two.reflectance or one.reflectance.values == two.reflectance.values
        for fill, other in zip(one.fills, two.fills, strict=True):
            np.testing.assert_allclose(fill.curves.points, other.curves.points, rtol=0, atol=1e-9)


def test_pictures_stay_in_their_files_and_no_shapes_are_none(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("photo.npy", np.linspace(0.0, 1.0, 36).reshape(3, 4, 3))
    picture = (
        "{kind: picture, file: photo.npy, width: 9, centre: [1, 2], encoding: 2.2, scale: 0.5, interpolation: cubic}"
    )
    for shapes in (f"[{picture}, {{kind: disc, radius: 2, reflectance: 0.1}}]", "[]"):
        head = library.shipped("scene")["flat-field"].read_text(encoding="utf-8").split("scene:\n")[0]
        scene = f"scene: {{unit: um, background: {{reflectance: 0.3}}, shapes: {shapes}}}\n"
        Path("one.yaml").write_text(head + scene, encoding="utf-8")
        Path("two.yaml").write_text(head + "\n".join(expanded("one.yaml")) + "\n", encoding="utf-8")
        assert describe(load("two.yaml").scene) == describe(load("one.yaml").scene)
