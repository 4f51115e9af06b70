"""Sensors by name: the user's folders, those beside a scene, the shipped ones; and nothing else of the disk."""

from pathlib import Path

import pytest

import camsim
from camsim.api import load, load_camera
from camsim.config.sensor_search import SensorSearch
from camsim.errors import CamsimError, ConfigError
from camsim.optics import Airy

from .conftest import SCENE, SENSOR


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project with a scene that names the sensor ``mine``, which is nowhere yet."""
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes/a.yaml").write_text(SCENE.replace("my.yaml", "mine"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CAMSIM_PATH", raising=False)
    return tmp_path


def put(file: str, name: str) -> None:
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    Path(file).write_text(SENSOR.replace("name: Mine", f"name: {name}"), encoding="utf-8")


# From the last place that is looked into to the first.
PLACES = ("sensors/mine.yaml", "scenes/sensors/mine.yml", "scenes/mine.yaml", "path/mine.yaml", "flag/mine.yaml")


@pytest.mark.usefixtures("project")
def test_the_first_place_wins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CAMSIM_PATH", "gone:path")
    with pytest.raises(
        ConfigError, match=r"a\.yaml:2:9: sensor: unknown sensor 'mine' .*; your own lies beside the scene"
    ):
        load("scenes/a.yaml")
    Path("flag").mkdir()
    for place in PLACES:
        put(place, place)
        assert load("scenes/a.yaml", sensors=["flag"]).camera.name == place
    assert load("scenes/a.yaml").camera.name == "path/mine.yaml"
    # The flag and Python know the same names.
    assert (
        load("slanted-edge", sensor="mine", sensors=["flag"], overrides=["region=null"]).camera.name == "flag/mine.yaml"
    )
    assert camsim.Camera.from_yaml("mine", lens=Airy(f_number=8.0)).name == "path/mine.yaml"


@pytest.mark.usefixtures("project")
def test_ones_own_comes_before_a_shipped_one_and_a_scene_is_no_sensor() -> None:
    Path("scenes/d40-like.yaml").write_text(Path("scenes/a.yaml").read_text().replace("mine", "d40-like"))
    assert load("scenes/d40-like.yaml").camera.name == "D40-like, 4.88 µm"
    put("sensors/d40-like.yaml", "Mine of that name")
    assert load("scenes/d40-like.yaml").camera.name == "Mine of that name"
    names = dict(SensorSearch.of((), Path("scenes")).all())
    assert names["d40-like"].displayed == "sensors/d40-like.yaml"
    assert "a" not in names


@pytest.mark.usefixtures("project")
def test_a_scene_from_elsewhere_cannot_read_the_disk(tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside") / "mine.yaml"
    put(str(outside), "Outside")
    for place in ("scenes", "scenes/sensors", "sensors"):
        Path(place).mkdir(exist_ok=True)
        Path(place, "mine.yaml").symlink_to(outside)
    with pytest.raises(ConfigError, match="unknown sensor 'mine'"):
        load("scenes/a.yaml")
    text = Path("scenes/a.yaml").read_text()
    put("elsewhere/mine.yaml", "Elsewhere")
    for name in (
        "../elsewhere/mine.yaml",
        str(outside),
        "../sensors/mine.yaml",
        "../sensors/../elsewhere/mine.yaml",
    ):
        Path("scenes/b.yaml").write_text(text.replace("mine", f"'{name}'", 1))
        with pytest.raises(ConfigError, match=r"lies outside this file's folder; put it there or into ../sensors"):
            load("scenes/b.yaml")
    # A folder that the user names may hold links, and a path in ../sensors is as good as its name.
    assert load("scenes/a.yaml", sensors=["sensors"]).camera.name == "Outside"
    put("sensors/real.yaml", "Real")
    Path("scenes/b.yaml").write_text(text.replace("mine", "../sensors/real.yaml", 1))
    assert load("scenes/b.yaml").camera.name == "Real"


@pytest.mark.usefixtures("project")
def test_a_folder_that_is_none() -> None:
    put("one/alone.yaml", "Alone")
    assert load_camera("alone", lens=Airy(f_number=8.0), sensors="one").name == "Alone"
    with pytest.raises(CamsimError, match=r"^sensors: must be a list of folders, not 5$"):
        load("slanted-edge", sensors=5)  # type: ignore[arg-type]
    for wrong in ("gone", "scenes/a.yaml"):
        with pytest.raises(CamsimError, match=f"^--sensors: '{wrong}' is no folder; name one that holds sensor files$"):
            load("slanted-edge", sensors=[wrong])
        with pytest.raises(CamsimError, match="is no folder"):
            load_camera("d40-like", lens=Airy(f_number=8.0), sensors=[wrong])
