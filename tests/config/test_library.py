"""Shipped files by name, the user's own by path, and nothing outside a scene's folder."""

import shutil
from pathlib import Path

import pytest

import camsim
from camsim.api import load, load_camera
from camsim.config import library
from camsim.errors import CamsimError, ConfigError, UnknownNameError
from camsim.optics import Airy

LENS = Airy(f_number=8.0)


def test_every_shipped_file_is_without_faults() -> None:
    assert set(library.shipped("sensor")) >= {"d40-like", "mono-345"}
    assert set(library.shipped("scene")) >= {"slanted-edge", "paper-square", "flat-field", "colorchecker"}
    for name in library.shipped("sensor"):
        assert load_camera(name, lens=LENS).name
    for name in library.shipped("scene"):
        assert load(name).scene_name == name


def test_an_installed_wheel_has_them_inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "site-packages" / "camsim"
    for kind in ("sensors", "scenes"):
        shutil.copytree(Path(camsim.__path__[0]).parent / kind, package / "data" / kind)
    monkeypatch.setattr(camsim, "__path__", [str(package)])
    monkeypatch.chdir(tmp_path)
    assert library.locate("sensor", "d40-like").path.is_relative_to(package)
    assert load("slanted-edge").camera.name == "D40-like, 4.88 µm"


def test_a_file_is_called_what_the_user_called_it(folder: Path) -> None:
    assert library.locate("scene", "good.yaml").displayed == "good.yaml"
    assert library.locate("scene", "./good.yaml").displayed == "./good.yaml"
    assert library.locate("scene", str(folder / "good.yaml")).displayed == str(folder / "good.yaml")
    assert library.locate("sensor", "d40-like").displayed == "sensors/d40-like.yaml"
    (folder / "plain").write_text("camsim: scene/1")
    assert library.locate("scene", "plain").path == Path("plain")


def test_a_file_that_lies_here_is_no_name(folder: Path) -> None:
    (folder / "edge.yaml").write_text("")
    with pytest.raises(
        UnknownNameError, match=r"^unknown scene 'edge'.*; for the file that lies here write edge\.yaml$"
    ):
        load("edge")


@pytest.mark.usefixtures("folder")
def test_missing_files() -> None:
    with pytest.raises(ConfigError, match=r"^god\.yaml: no such file; did you mean 'good\.yaml'\?$"):
        load("god.yaml")
    with pytest.raises(ConfigError, match=r"^no/such/folder\.yaml: no such file$"):
        load("no/such/folder.yaml")
    message = r"^scenes/slanted-edge\.yaml: no such file; for the shipped scene write 'slanted-edge'$"
    with pytest.raises(ConfigError, match=message):
        load("scenes/slanted-edge.yaml")
    with pytest.raises(ConfigError, match=r"^nowhere\.yaml: no such file$"):
        load("good.yaml", sensor="nowhere.yaml")
    with pytest.raises(CamsimError):
        load("x" * 5000 + ".yaml")
    with pytest.raises(CamsimError):
        load("nul\0.yaml")


def test_a_link_out_of_the_folder_is_outside(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside") / "theirs.yaml"
    outside.write_text((folder / "my.yaml").read_text())
    (folder / "link.yaml").symlink_to(outside)
    (folder / "scene.yaml").write_text((folder / "good.yaml").read_text().replace("my.yaml", "link.yaml"))
    with pytest.raises(ConfigError, match=r"scene\.yaml:2:9: sensor: 'link\.yaml' lies outside this file's folder"):
        load("scene.yaml")
    # The user's own word goes anywhere.
    assert load("scene.yaml", sensor=str(outside)).camera.name == "Mine"


def test_a_sensor_lies_beside_its_scene_wherever_that_is(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "below").mkdir()
    shutil.move("my.yaml", "below/my.yaml")
    (folder / "scene.yaml").write_text((folder / "good.yaml").read_text().replace("my.yaml", "below/my.yaml"))
    monkeypatch.chdir("/")
    assert load(folder / "scene.yaml").camera.name == "Mine"
