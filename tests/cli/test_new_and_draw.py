"""``camsim new`` and ``validate --draw``: a file to start from, and the scene before anything is rendered."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from camsim.api import load, load_camera
from camsim.cli.app import app
from camsim.cli.draw import lines
from camsim.cli.new import template
from camsim.config.schema import SceneFile, SensorFile
from camsim.optics import Airy
from camsim.scene import Picture

from .conftest import SCENE


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, list(words))
    return done.exit_code, done.stdout, done.stderr


def judged(kind: str, text: str) -> None:
    Path("it.yaml").write_text(text, encoding="utf-8")
    Path("it.csv").write_text("nm;R\n300;0.2\n900;0.4\n")
    if kind == "scene":
        load("it.yaml")
    else:
        load_camera("it.yaml", lens=Airy(f_number=8.0))


@pytest.mark.parametrize(("kind", "model"), [("scene", SceneFile), ("sensor", SensorFile)])
def test_templates_are_whole_with_every_choice(kind: str, model: type) -> None:
    text = template(kind)
    judged(kind, text)
    choices = re.findall(r"^ *#- .*$", text, flags=re.MULTILINE)
    assert len(choices) > 3
    for choice in choices:
        taken = choice.replace("#- ", "", 1)
        judged(kind, re.sub(r"csv: [\w-]+\.csv", "csv: it.csv", text.replace(choice, taken)))
    for key in model.model_fields:
        if key != "source":
            assert re.search(rf"^(#- )?{key}:", text, flags=re.MULTILINE), key


def test_slips_in_copying_a_data_sheet_are_remarked() -> None:
    """PRNU in per cent, and K for 1/K either way; a template has nothing to remark, and its well can be measured."""
    text = template("sensor")
    for old, new, remark in (
        ("prnu: 0.008", "prnu: 0.8", "0.8 % is 0.008"),
        ("electrons_per_dn: 2.66", "electrons_per_dn: 0.38", "electrons_per_dn is 2.632"),
        ("electrons_per_dn: 2.66", "electrons_per_dn: 6", "electrons_per_dn is 0.1667"),
        ("serial: 1", "serial: 2", ""),
    ):
        Path("it.yaml").write_text(text.replace(old, new), encoding="utf-8")
        for command in ("validate", "show"):
            code, said, _ = run(command, "./it.yaml")
            assert code == 0
            assert (remark in said) if remark else ("note" not in said)


def test_new_writes_what_can_be_captured() -> None:
    assert run("new", "sensor", "-o", "mine.yaml")[0] == 0
    code, said, _ = run("new", "scene")
    assert (code, said.split(":")[0]) == (0, "scene.yaml")
    small = ["region={rows: 8, cols: 10}", "render.tolerance=1e-2"]
    assert load("scene.yaml", sensor="mine", overrides=small).frame().mosaic.shape == (8, 10)
    for kind in ("study", "dataset"):
        assert run("new", kind)[0] == 0
        assert run("validate", f"{kind}.yaml")[0] == 0
    before = Path("scene.yaml").read_bytes()
    code, _, error = run("new", "scene")
    assert (code, error.count("\n")) == (2, 1)
    assert "'scene.yaml' exists; overwrite it with --force" in error
    assert Path("scene.yaml").read_bytes() == before


def test_a_scene_on_the_terminal() -> None:
    """What is where: the pictures' rows and columns, shares, a scale, shapes that cannot be seen."""
    scene = SCENE.replace(
        "    - {kind: rectangle, width: 6, height: 8, rotate_deg: 4, reflectance: 0.05}",
        "    - {kind: rectangle, width: 10, height: 16, centre: [-5, 0], reflectance: 0.0}\n"
        "    - {kind: disc, radius: 2, centre: [5, 4], reflectance: blue sky}\n"
        "    - {kind: disc, radius: 2, centre: [50, 4], reflectance: 0.2}",
    )
    Path("a.yaml").write_text(scene, encoding="utf-8")
    drawn = list(lines(load("a.yaml")))
    picture = [line[1:-1] for line in drawn if line.startswith("│")]
    left, right = ({row[col] for row in picture} for col in (1, -2))
    assert (left, right) == ({" "}, {"█"})
    middle = len(picture[0]) * 15 // 20
    assert picture[len(picture) * 3 // 4][middle] not in " █"
    assert picture[len(picture) // 4][middle] == "█"
    text = "\n".join(drawn)
    assert "┤ 5 photosites, 24.4 µm" in text
    assert "rows 992 to 1007, cols 1494 to 1513 of 2000 × 3008 photosites of D40-like" in text
    assert "scene.shapes.0: rectangle, reflectance 0: 50 % of the window" in text
    assert (
        "scene.shapes.1: disc, reflectance blue sky: 3." in text
        or "scene.shapes.1: disc, reflectance blue sky: 4" in text
    )
    assert "scene.shapes.2: disc, reflectance 0.2: not seen in the window" in text
    bar = next(line for line in drawn if "┤ 5 ph" in line).index("┤") + 1
    assert bar == pytest.approx(len(picture[0]) / 4, abs=1.0)


def test_what_is_drawn_can_be_changed() -> None:
    code, said, _ = run("validate", "slanted-edge", "--draw", "-", "--set", "region.rows=40", "--set", "region.cols=80")
    assert code == 0
    assert "rows 980 to 1019, cols 1464 to 1543 of 2000" in said


@pytest.mark.parametrize("name", ["slanted-edge", "colorchecker"])
def test_drawings_are_files(name: str) -> None:
    code, said, _ = run("validate", name, "--draw", "a.svg")
    assert (code, said) == (0, f"a.svg: {name}\n")
    assert "<svg" in Path("a.svg").read_text(encoding="utf-8")


def test_sensors_of_ones_own_are_listed_with_their_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CAMSIM_PATH", raising=False)
    for place, name in (("sensors/mine.yaml", "Mine"), ("far/theirs.yaml", "Theirs"), ("path/d40-like.yaml", "Other")):
        Path(place).parent.mkdir()
        Path(place).write_text(template("sensor").replace("My camera", name), encoding="utf-8")
    Path("scene.yaml").write_text(template("scene"), encoding="utf-8")
    listed = {line.split()[0]: line.rpartition(" (")[2][:-1] for line in run("list", "sensors")[1].splitlines()}
    assert (listed["mine"], listed["d40-like"]) == ("sensors/mine.yaml", "shipped")
    assert not {"theirs", "scene"} & set(listed)
    monkeypatch.setenv("CAMSIM_PATH", "path")
    listed = {
        line.split()[0]: line.rpartition(" (")[2][:-1]
        for line in run("list", "sensors", "--sensors", "far")[1].splitlines()
    }
    assert (listed["theirs"], listed["d40-like"]) == ("far/theirs.yaml", "path/d40-like.yaml")
    assert "\nname: Theirs " in run("show", "theirs", "--sensors", "far")[1]
    assert run("validate", "theirs", "--sensors", "far")[1] == "theirs: a sensor, no faults\n"
    stated = run(
        "explain", "scene.yaml", "--sensor", "theirs", "--sensors", "far", "--set", "region={rows: 8, cols: 8}"
    )
    assert "8 × 8 photosites of 3.45 µm, camera Theirs," in stated[1]
    code, _, error = run("capture", "scene.yaml", "--sensor", "theirs", "-o", "a.dng")
    assert code == 2
    assert error.startswith("--sensor: unknown sensor 'theirs'")


def photographs(count: int) -> None:
    Path("photos").mkdir()
    for number in range(count):
        samples = np.random.default_rng(number).integers(0, 256, (80 + number, 120, 3), dtype=np.uint8)
        Image.fromarray(samples).save(f"photos/no {number}.jpg")


def test_a_picture_in_a_scenes_place_gets_the_scene_that_shows_it() -> None:
    """It was ``byte 0xff is not UTF-8``. What is said can be pasted, and is what ``new scene --picture`` writes."""
    photographs(2)
    for words in (["capture"], ["explain"], ["validate"]):
        code, _, said = run(*words, "photos/no 0.jpg")
        assert code == 2
        assert said.startswith(
            "photos/no 0.jpg: is a picture, not a YAML file; a scene that shows it, which camsim new"
        )
        Path("photos/pasted.yaml").write_text(said.partition("\n\n")[2], encoding="utf-8")
    code, said, _ = run("new", "scene", "--picture", "photos/no 0.jpg")
    assert code == 0
    for file in ("photos/pasted.yaml", "no 0.yaml"):
        ready = load(file)
        (shape,) = ready.scene.shapes
        assert isinstance(shape, Picture)
        assert shape.planes.shape[1:] == (80, 120)
        assert shape.width_um == pytest.approx(0.5 * 120 * ready.camera.pitch_um)
        assert (ready.grid.rows, ready.grid.cols) == (40, 60)  # all of it, and nothing beside it
    assert run("new", "scene", "--picture", "photos/no 0.jpg")[0] == 2  # exists


def test_a_folder_of_photographs_is_a_data_set_split_by_file() -> None:
    """What is said of the folder is pasted: sizes follow each photograph's own."""
    photographs(4)
    assert run("new", "scene", "--picture", "photos/no 0.jpg", "-o", "scene.yaml")[0] == 0
    _, _, said = run("capture", "photos")
    text = said.partition("\n\n")[2].replace("rows: 128, cols: 128", "rows: 32, cols: 32").replace("64", "16")
    Path("pairs.yaml").write_text(f"{text}\nsplits: {{train: 0.5, val: 0.25, test: 0.25}}\n", encoding="utf-8")
    assert run("dataset", "pairs.yaml", "-o", "out", "-q", "--workers", "0")[0] == 0
    with Path("out/manifest.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 16
    split_of = {row["scene_shapes_0_file"]: row["split"] for row in rows}
    assert list(split_of) == [f"photos/no {number}.jpg" for number in range(4)]
    assert sorted(split_of.values()) == ["test", "train", "train", "val"]
    assert all(split_of[row["scene_shapes_0_file"]] == row["split"] for row in rows)
