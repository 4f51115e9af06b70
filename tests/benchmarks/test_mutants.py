"""The mutants that ``make mutants`` draws: one line each, parsed, the same again from the same seed."""

import ast
import json
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parents[2] / "bench" / "mutants"


@pytest.fixture(scope="module")
def draw():
    sys.path.insert(0, str(HERE))
    try:
        import draw

        yield draw
    finally:
        sys.path.remove(str(HERE))


@pytest.fixture(scope="module")
def mutants(draw):
    return draw.drawn(1, "test")


def test_each_changes_one_line_and_can_be_read_by_python(draw, mutants):
    for mutant in mutants:
        before = (draw.ROOT / mutant.path).read_text(encoding="utf-8").splitlines()
        after = mutant.text().splitlines()
        assert [k for k, (a, b) in enumerate(zip(before, after, strict=True)) if a != b] == [mutant.number - 1]
        assert ast.dump(ast.parse(mutant.text())) != ast.dump(ast.parse("\n".join(before)))


def test_every_kind_of_every_folder_is_drawn_and_the_seed_decides(draw, mutants):
    cells = {(mutant.folder, mutant.kind) for mutant in mutants}
    assert {folder for folder, _ in cells} == set(draw.FOLDERS)
    assert {kind for _, kind in cells} == set(draw.KINDS)
    assert draw.drawn(1, "test") == mutants
    assert draw.drawn(1, "another") != mutants
    assert set(mutants) < set(draw.drawn(2, "test"))


@pytest.mark.parametrize(
    ("line", "changed"),
    [
        ("y = 0.5 * w + h", {"y = 0.5 * w - h", "y = 0.5 * w", "y = (0.5 * w * 1.01) + h", "y = 1.0 * w + h"}),
        ("y = np.sinc(w_x * fx) + w_y * fy", {"y = np.sinc(w_y * fx) + w_y * fy", "y = np.sinc(w_x * fy) + w_y * fy"}),
        ("y = x[0] if n < 3 else x[1]", {"y = x[1] if n < 3 else x[1]", "y = x[0] if n >= 3 else x[1]"}),
        ("y = i + 0.5", {"y = i + 0.0"}),
        ("y = {'a': 1, 'b': 2}", {"y = {'a': 2, 'b': 1}"}),
        ("y = f(not a, b=True)", {"y = f(a, b=True)", "y = f(not a, b=False)"}),
    ],
)
def test_what_is_changed(draw, tmp_path, monkeypatch, line, changed):
    (tmp_path / "a.py").write_text(line + "\n", encoding="utf-8")
    monkeypatch.setattr(draw, "ROOT", tmp_path)
    assert changed <= {mutant.after for mutant in draw.mutants(tmp_path / "a.py")}


def test_every_survivor_of_the_stored_run_has_its_reason():
    lines = [json.loads(line) for line in (HERE / "results.jsonl").read_text(encoding="utf-8").splitlines()]
    outcome = {line["key"]: line["outcome"] for line in lines}
    reasons = [json.loads(line) for line in (HERE / "equivalent.jsonl").read_text(encoding="utf-8").splitlines()]
    assert {key for key, ended in outcome.items() if ended == "survived"} <= {line["key"] for line in reasons}
    assert all(line["reason"] for line in reasons)
