"""Pictures of scene files: the same bytes as their twins in Python, and as captured again."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import camsim
from camsim.config.from_record import capture_from_record
from camsim.errors import InputError

PICTURE = {"file": "photo.npy", "width": 30.0, "centre": [2.0, -1.0], "rotate_deg": 10.0, "scale": 0.5}


def taken(folder: Path, monkeypatch: pytest.MonkeyPatch, **shape: Any) -> camsim.Frame:
    monkeypatch.chdir(folder)
    np.save("photo.npy", np.random.default_rng(3).random((4, 5, 3)))
    scene = {
        "camsim": "scene/1",
        "sensor": "d40-like",
        "lens": {"kind": "airy", "f_number": 8},
        "light": {"illuminant": "D55", "illuminance_lux": 5000},
        "exposure": {"time_s": 0.01, "iso": 200},
        "region": {"rows": 8, "cols": 10},
        "scene": {"unit": "um", "background": {"reflectance": 0.3}, "shapes": [shape]},
        "render": {"tolerance": 1e-3},
    }
    Path("scene.yaml").write_text(json.dumps(scene), encoding="utf-8")
    return camsim.load("scene.yaml").frame()


def of_python(shape: Any) -> camsim.Frame:
    return camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0)).expose(
        camsim.Scene(background=0.3, shapes=[shape]),
        light=camsim.Light("D55", illuminance_lux=5000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=8, cols=10),
        tolerance=1e-3,
    )


def test_a_picture_and_its_twin_and_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = taken(tmp_path, monkeypatch, kind="picture", **PICTURE)
    twin = of_python(camsim.read_picture("photo.npy", width_um=30.0, centre_um=(2.0, -1.0), rotate_deg=10.0, scale=0.5))
    assert frame.mosaic.tobytes() == twin.mosaic.tobytes()
    assert frame.description == twin.description
    again = capture_from_record(json.loads(json.dumps(frame.description)), tmp_path)
    assert again.frame().mosaic.tobytes() == frame.mosaic.tobytes()
    with pytest.raises(InputError, match=r"shows the picture 'photo.npy', which such a file does not hold; capture"):
        capture_from_record(frame.description)
    with pytest.raises(InputError, match=r"which such a file does not hold; put that beside it"):
        capture_from_record(frame.description, tmp_path / "elsewhere")
    np.save("photo.npy", np.zeros((4, 5, 3)))
    with pytest.raises(InputError, match=r"the picture 'photo.npy' beside it is another one than was captured"):
        capture_from_record(frame.description, tmp_path)


def test_our_own_spectra_go_in_and_come_out(tmp_path: Path) -> None:
    """Radiances of a plain surface from our spectral EXR are its reflectance again, to single precision."""
    light, nodes = camsim.Light("D55", illuminance_lux=5000.0), (450.0, 550.0, 650.0)
    surface = camsim.reflectance("orange")

    def cube(name: str, *shapes: Any) -> np.ndarray:
        frame = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0)).expose(
            camsim.Scene(background=surface, shapes=shapes),
            light=light,
            exposure=camsim.Exposure(time_s=0.01, iso=200.0),
            region=camsim.Region(rows=4, cols=6),
            products=("spectral",),
            spectral_nm=nodes,
            tolerance=1e-5,
        )
        camsim.save(frame, tmp_path / name, product="spectral")
        assert frame.spectral is not None
        return np.stack([frame.spectral.plane(k)[0] for k in range(len(nodes))])

    first = cube("first.exr")
    # On the surface itself: a picture that is as bright as that is not seen, at its rim or anywhere.
    picture = camsim.read_picture(tmp_path / "first.exr", light=light, tolerance=0.0, width_um=20.0)
    np.testing.assert_allclose(cube("again.exr", picture), first, rtol=1e-6, atol=0)
