"""One mistake at a time in a scene, its sensor or --set: the exact sentences of tests/data/wrong-files.txt."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from camsim.api import load
from camsim.errors import ConfigError
from tests.tables import rows

DRAWING = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><rect width="5" height="4" fill="navy"/></svg>'
CSV = "# of several\nnm;a;b\n900;90;0,2\n550,5;90;0,35\n300;90;0,1\n"


@pytest.fixture(autouse=True)
def beside(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    """What the files of the table name."""
    outside = tmp_path_factory.mktemp("outside") / "qe.csv"
    for path, text in (
        (folder / "drawing.svg", DRAWING),
        (folder / "qe.csv", CSV),
        (folder / "bad.csv", "nm,a\n400,x\n500,1\n"),
        (folder / "high.csv", "nm,a\n400,1\n500,1.005\n"),
        (outside, CSV),
    ):
        path.write_text(text, encoding="utf-8")
    (folder / "link.csv").symlink_to(outside)


@pytest.mark.parametrize("case", rows("wrong-files.txt", "edits of a good scene", "edits of a good sensor"))
def test_a_fault_in_a_file(edited: Callable[..., None], case: list[str]) -> None:
    (old, new), expected = (each.replace("\\n", "\n") for each in case[:2]), case[2:]
    sensor = expected[0].startswith("my.yaml")
    edited(old, new, sensor=sensor)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml" if sensor else "scene.yaml")
    assert str(caught.value).splitlines() == expected
    for fault in caught.value.faults:
        # There stands the key or the value that is spoken of.
        there = Path(fault.file).read_text(encoding="utf-8").splitlines()[fault.line - 1][fault.column - 1 :]
        value = re.match(r"must be .*, not '?([^';( ]+)", fault.message)
        if "unknown key" in fault.message:
            assert there.startswith(fault.key.rpartition(".")[2]), fault
        elif value and value[1] not in ("a", "an", "empty"):
            assert there.lstrip("'").startswith(value[1].removesuffix(".0")), fault


@pytest.mark.parametrize("case", rows("wrong-files.txt", "--set, several with &"))
def test_a_fault_names_the_override(case: list[str]) -> None:
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=case[0].split(" & "))
    assert str(caught.value).splitlines() == case[1:]


@pytest.mark.parametrize("shape", ["{kind: svg, file: /etc/passwd, width: 1}", "{kind: svg, file: ../a.svg, width: 1}"])
def test_a_drawing_lies_beside_its_scene(edited: Callable[..., None], shape: str) -> None:
    edited("{kind: disc, radius: 3, reflectance: {wavelength_nm: [400, 700], values: [0.1, 0.8]}}", shape)
    with pytest.raises(ConfigError, match=r"shapes\.2\.file: '.*' lies outside this file's folder; put it there"):
        load("scene.yaml")


def test_none_given_is_not_left_out(edited: Callable[..., None]) -> None:
    """A study that goes down to 0 is no contradiction."""
    given = "dark_current_e_per_s: 0, dcnu: 0.1, defects: {hot_fraction: 0, hot_e_per_s: 90}"
    edited("dark_current_e_per_s: 1.5", given, sensor=True)
    assert load("good.yaml").camera.defects is not None
