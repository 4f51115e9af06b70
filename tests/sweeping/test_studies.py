"""What a study asks for: its points, its names, and what is wrong with it."""

from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from camsim.config import library
from camsim.errors import ConfigError
from camsim.study import read_dataset, read_study
from camsim.study.captures import captures_of


def study(**keys):
    return read_study({"scene": "slanted-edge", **keys})[0]


def settings(**keys):
    return [dict(point.settings) for point in study(**keys).points()]


A, B = "exposure.iso", "lens.f_number"


@pytest.mark.parametrize(
    ("combine", "points"),
    [
        ("product", [(100, 4), (100, 8), (200, 4), (200, 8)]),
        ("zip", [(100, 4), (200, 8)]),
        ("sequential", [(100, None), (200, None), (None, 4), (None, 8)]),
    ],
)
def test_lists_are_combined(combine, points):
    found = settings(vary={A: [100, 200], B: [4, 8]}, combine=combine)
    assert [(one.get(A), one.get(B)) for one in found] == points


def test_ranges():
    found = settings(vary={A: {"log": [100, 1600, 3]}, B: {"linear": [4, 5, 3]}}, combine="zip")
    assert [(one[A], one[B]) for one in found] == [(100.0, 4.0), (400.0, 4.5), (1600.0, 5.0)]


def test_ranges_of_whole_numbers_are_whole():
    assert [type(one[A]) for one in settings(vary={A: {"linear": [1, 5, 3]}})] == [int] * 3


@pytest.mark.parametrize(
    ("given", "values"),
    [
        (np.linspace(200, 400, 3), [200.0, 300.0, 400.0]),
        (np.array([200, 400], np.uint16), [200, 400]),
        ([np.float64(200.5), np.int64(400), np.float32(0.5)], [200.5, 400, 0.5]),
        (range(200, 500, 100), [200, 300, 400]),
        ({"linear": np.array([1, 5, 3])}, [1, 3, 5]),
        ({"log": (np.float64(100), 1600, np.int8(3))}, [100, 400, 1600]),
    ],
)
def test_numbers_and_arrays_of_numpy_are_what_they_hold(given, values):
    found = [one[A] for one in settings(vary={A: given})]
    assert (found, [type(value) for value in found]) == (values, [type(value) for value in values])


def test_what_else_python_has_is_what_a_file_would_say():
    twice = [np.int64(4), 5]  # in two places: no alias
    same = {"noise.seed": np.int64(7), "render.strict": np.True_, "exposure.datetime": datetime(2026, 1, 31)}
    found = study(scene=Path(__file__).parents[2] / "scenes" / "flat-field.yaml", set=same, vary={A: twice, B: twice})
    assert found.model.set == {"noise.seed": 7, "render.strict": True, "exposure.datetime": "2026-01-31 00:00:00"}
    assert [dict(point.settings) for point in found.points()][-1] == {A: 5, B: 5}


@pytest.mark.parametrize("read", [read_study, read_dataset])
def test_nothing_is_its_own_part(read):
    keys = {"scene": "flat-field"}
    keys["set"] = keys
    with pytest.raises(ConfigError, match="nested more than 64 deep"):
        read(keys)


def test_scenes_are_outermost_and_without_vary_there_is_one_capture_each():
    scenes = ["slanted-edge", "flat-field"]
    assert [point.scene for point in study(scene=scenes, vary={A: [1, 2]}).points()] == [
        "slanted-edge",
        "slanted-edge",
        "flat-field",
        "flat-field",
    ]
    assert study().count == 1


DRAWN = {
    "u": {"uniform": [2.0, 3.0]},
    "l": {"log_uniform": [1e-3, 1e3]},
    "n": {"normal": [5.0, 2.0]},
    "i": {"integers": [3, 5]},
    "c": {"choice": ["a", "b", None]},
}


def test_draws_are_functions_of_seed_key_and_index_and_have_their_distributions():
    found = settings(vary=DRAWN, draws=4000)
    assert settings(vary=DRAWN, draws=10) == found[:10]
    assert settings(vary=DRAWN, draws=10, seed=1) != found[:10]
    assert settings(vary={"u": DRAWN["u"], "new": [1]}, draws=10)[3]["u"] == found[3]["u"]
    of = {key: [one[key] for one in found] for key in DRAWN}
    # Means of 4000 lie within four standard errors of the distributions' own.
    assert sum(of["u"]) / 4000 == pytest.approx(2.5, abs=4 * 0.2887 / 63)
    assert sum(of["n"]) / 4000 == pytest.approx(5.0, abs=4 * 2 / 63)
    assert sum(value < 1.0 for value in of["l"]) / 4000 == pytest.approx(0.5, abs=4 * 0.5 / 63)
    for key, values in (("i", [3, 4, 5]), ("c", ["a", "b", None])):
        for value in values:
            assert of[key].count(value) / 4000 == pytest.approx(1 / 3, abs=4 * 0.4714 / 63)
    assert all(2.0 <= value < 3.0 for value in of["u"])


def test_listed_keys_of_which_one_holds_the_other_vary_one_after_another():
    found = settings(vary={A: [400], "exposure": [{"iso": 100}]}, combine="sequential")
    assert found == [{A: 400}, {"exposure": {"iso": 100}}]


def test_tables_tell_scenes_apart_and_what_each_capture_was_given(tmp_path):
    for folder in ("day", "night"):
        (tmp_path / folder).mkdir()
        text = library.shipped("scene")["flat-field"].read_text(encoding="utf-8")
        (tmp_path / folder / "street.yaml").write_text(text, encoding="utf-8")
    file = tmp_path / "study.yaml"
    file.write_text(
        "camsim: study/1\nscene: [day/street.yaml, night/street.yaml, slanted-edge]\ncombine: sequential\n"
        "vary: {exposure: [{time_s: 1, iso: 300}], exposure.iso: [400]}\n",
        encoding="utf-8",
    )
    read, _ = read_study(file)
    stated = [read.stated(point) for point in read.points()]
    assert [row["scene"] for row in stated[::2]] == ["day/street", "night/street", "slanted-edge"]
    assert [row["exposure_iso"] for row in stated[:2]] == [300, 400]


def test_files_of_a_study_lie_beside_it(tmp_path, monkeypatch):
    """Its sensors as its scenes, wherever it is taken from; the folder that one stands in comes after."""
    sensor = Path(library.shipped("sensor")["mono-345"]).read_text(encoding="utf-8")
    for place, serial in (("study", 5), ("here", 6)):
        (tmp_path / place).mkdir()
        text = sensor.replace("serial: 345", f"serial: {serial}")
        (tmp_path / place / "chip.yaml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path / "here")
    region = "set: {region: {rows: 2, cols: 2}}\n"
    for keys in ("sensor: chip.yaml\n", "vary: {sensor: [chip.yaml]}\n"):
        (tmp_path / "study" / "study.yaml").write_text(f"camsim: study/1\nscene: slanted-edge\n{keys}{region}")
        read, _ = read_study(tmp_path / "study" / "study.yaml")
        ((_, capture),) = captures_of(read, ("mosaic",), lambda stage, fraction: None)
        assert capture.camera.serial == 5


def test_any_letter_of_a_text_is_taken():
    code = {"kind": "chart", "name": "qr", "text": "µ\u2028 \N{GRINNING FACE} \\ud83d", "width": 9}
    read = study(set={"scene.shapes": [code], "region": {"rows": 2, "cols": 2}})
    ((_, capture),) = captures_of(read, ("mosaic",), lambda stage, fraction: None)
    assert capture.scene.shapes[0].parameters["text"] == code["text"]
