"""``--set``: what it changes, what wins, and what it is told when it cannot."""

from pathlib import Path

import pytest

from camsim.api import load
from camsim.camera.capture import Capture
from camsim.errors import ConfigError

pytestmark = pytest.mark.usefixtures("folder")


def with_set(*texts: str, **flags: object) -> Capture:
    return load("good.yaml", overrides=texts, **flags)  # type: ignore[arg-type]


def faults(*texts: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        with_set(*texts)
    return str(caught.value).splitlines()


def test_values_follow_the_yaml_rules() -> None:
    assert with_set("exposure.iso=1e3").exposure.iso == 1000.0
    assert with_set("exposure.time_s=auto").exposure.time_s == "auto"
    assert with_set("noise.enabled=false").noise is False
    assert with_set("noise.seed=010").seed == 10
    assert with_set("region={rows: 3, cols: 4, origin: [6, 8]}").region.origin == (6, 8)
    assert with_set("scene.shapes=[]").scene.shapes == ()
    assert with_set("name='a = b'").scene_name == "a = b"


def test_items_of_a_list_have_numbers() -> None:
    assert with_set("scene.shapes.0.reflectance=0.2").scene.shapes[0].reflectance == 0.2
    assert with_set("scene.shapes.0.centre.1=7").scene.shapes[0].centre_um == (4.0, 28.0)


def test_null_removes() -> None:
    assert with_set("sensor.olpf=null").camera.olpf is None
    assert with_set("sensor.charge.prnu=").camera.prnu is None
    assert with_set("region=null").region is None
    assert len(with_set("scene.shapes.1=null").scene.shapes) == 2
    # What is not there need not be removed.
    assert with_set("sensor.olpf=null", "sensor.olpf=null").camera.olpf is None
    assert with_set("name=null").scene_name == "good"


def test_a_removed_item_moves_the_next_one_up() -> None:
    setup = with_set("scene.shapes.0=null", "scene.shapes.0=null", "scene.shapes.0.reflectance=0.5")
    assert [shape.reflectance for shape in setup.scene.shapes] == [0.5]


def test_tables_that_are_not_there_are_made() -> None:
    assert with_set("region=null", "region.rows=8", "region.cols=10").region.cols == 10
    assert with_set("sensor.olpf=null", "sensor.olpf.kind=four-spot", "sensor.olpf.split_um=1").camera.olpf


def test_one_spectrum_can_take_the_place_of_the_other() -> None:
    light = with_set("light.illuminant=null", "light.line_nm=550").light
    assert (light.spectrum, light.line_nm) == (None, 550.0)
    # What the file gives instead of it need not be removed.
    assert with_set("light.line_nm=550").light == light


def test_the_later_wins() -> None:
    assert with_set("exposure.iso=400", "exposure.iso=800").exposure.iso == 800.0


def test_precedence_is_flag_then_set_then_scene_then_default(folder: Path) -> None:
    other = (folder / "my.yaml").read_text().replace("name: Mine", "name: Other")
    (folder / "other.yaml").write_text(other)
    third = other.replace("name: Other", "name: Third").replace("serial: 7\n", "")
    (folder / "third.yaml").write_text(third)
    assert with_set().camera.name == "Mine"
    assert with_set("sensor=other.yaml").camera.name == "Other"
    assert with_set("sensor=other.yaml", sensor="third.yaml").camera.name == "Third"
    assert with_set("sensor=other.yaml", "sensor.name=Set", sensor="third.yaml").camera.name == "Set"
    assert with_set("noise.seed=5").seed == 5
    assert with_set("noise.seed=5", seed=6).seed == 6
    assert with_set("noise.seed=null").seed == 0
    assert with_set(sensor="third.yaml").camera.serial == 1


def test_a_sensor_that_is_set_is_found_from_here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert load("../good.yaml", overrides=["sensor=../my.yaml"]).camera.name == "Mine"
    assert load("../good.yaml", sensor="../my.yaml").camera.name == "Mine"


def test_all_faulty_overrides_at_once() -> None:
    found = faults("x", "exposure.iso=-1", "sensor.readout.bit_depth=0", "scene.shapes.9.radius=3")
    assert [line.split(": ")[0] for line in found] == [
        "--set x",
        "--set scene.shapes.9.radius",
        "--set exposure.iso",
        "--set sensor.readout.bit_depth",
    ]
