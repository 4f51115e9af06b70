"""A YAML file and its Python twin give the same picture; names and overrides reach it."""

from pathlib import Path

import numpy as np
import pytest

import camsim
from camsim.api import load
from camsim.config.overrides import parse
from camsim.files import save
from camsim.spectra.named import sensitivities

pytestmark = pytest.mark.usefixtures("folder")


def test_a_yaml_file_and_its_python_twin_give_the_same_bytes() -> None:
    frame = camsim.capture("good.yaml", seed=5, products=("mosaic", "truth"))
    curves = sensitivities("Nikon 5100 (NPL)")
    camera = camsim.Camera(
        name="Mine",
        serial=7,
        rows=200,
        cols=300,
        pitch_um=4.0,
        lens=camsim.Airy(f_number=8.0),
        olpf=camsim.FourSpotOlpf(split_um=3.0),
        photosite=camsim.SquarePhotosite.from_fill_factor(pitch_um=4.0, fill_factor=0.81),
        cfa=camsim.Cfa.bayer("GRBG"),
        quantum_efficiency=camsim.QuantumEfficiency(
            curves=tuple((letter, curves[letter]) for letter in "RGB"), per="energy", peak=0.5
        ),
        prnu=camsim.Prnu(0.01),
        dark_current=camsim.DarkCurrent(1.5),
        full_well=camsim.FullWell(20000),
        dsnu=camsim.Dsnu(0.5),
        read_noise=camsim.ReadNoise(3.0),
        adc=camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=5.0, base_iso=100.0),
    )
    scene = camsim.Scene(
        background=0.9,
        shapes=[
            camsim.Rectangle(width_um=20.0, height_um=16.0, centre_um=(4.0, 8.0), rotate_deg=4.0, reflectance=0.05),
            camsim.Polygon(points_um=[(0, 0), (16, 0), (0, 16)], reflectance=camsim.reflectance("dark skin")),
            camsim.Disc(radius_um=12.0, reflectance=camsim.Curve((400.0, 700.0), (0.1, 0.8), outside="hold")),
        ],
    )
    twin = camera.expose(
        scene,
        light=camsim.Light("D55", illuminance_lux=5000),
        exposure=camsim.Exposure(time_s=0.01, iso=200),
        seed=5,
        region=camsim.Region(rows=20, cols=24),
        products=("mosaic", "truth"),
        tolerance=1e-3,
        scene_name="good",
    )
    np.testing.assert_array_equal(frame.mosaic, twin.mosaic)
    np.testing.assert_array_equal(frame.truth, twin.truth)
    for name in ("a.dng", "b.exr", "c.tiff", "d.png", "e.npy"):
        save(frame, name)
        save(twin, "twin-" + name)
        assert Path(name).read_bytes() == Path("twin-" + name).read_bytes(), name


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
