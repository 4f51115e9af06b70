"""Stiff and extreme cases as a run: a table, a page of HTML, an exit code."""

import re
import sys

import pytest

from bench.extremes import judging, sensor_cases
from bench.extremes.__main__ import main
from bench.extremes.judging import ExtremeCase, Outcome
from bench.results import read_results


def breaks():
    raise RuntimeError("no")


def outcome(verdict):
    return Outcome(reached=2e-7, asked=1e-6, seconds=0.1, verdict=verdict, truth="quadrature")


CASES = [
    ExtremeCase(name="good", input="a <square>", run=lambda: outcome("right")),
    ExtremeCase(name="refused", input="a bow tie", run=lambda: outcome("refused")),
    ExtremeCase(name="bad", input="another", run=lambda: outcome("wrong")),
    ExtremeCase(name="broken", input="a third", run=breaks),
]


@pytest.mark.parametrize(("count", "code", "words"), [(2, 0, "all are right or refused"), (4, 1, "2 are wrong")])
def test_extremes_are_a_table_and_an_exit_code(tmp_path, monkeypatch, capsys, count, code, words):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(judging, "cases", lambda: CASES[:count])
    monkeypatch.setattr(sensor_cases, "cases", list)
    monkeypatch.setattr(sys, "argv", ["extremes", "-o", "out"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == code
    stated = capsys.readouterr().out
    assert f"{count} stiff and extreme cases: {words}" in stated
    assert re.search(r"good +asked 1e-06 +reached 2e-07 +0\.1 s +right", stated)
    lines = read_results(tmp_path / "out" / "extremes.jsonl")
    assert [line["name"] for line in lines if line["kind"] == "extreme"] == ["good", "refused", "bad", "broken"][:count]
    text = (tmp_path / "out" / "extremes.html").read_text(encoding="utf-8")
    assert "a &lt;square&gt;" in text
    assert ("RuntimeError: no" in text) == (count == 4)


def test_the_list_of_extremes_is_whole_and_its_names_differ():
    cases = (*judging.cases(), *sensor_cases.cases())
    assert len(cases) > 60
    assert len({case.name for case in cases}) == len(cases)


def test_every_extreme_of_the_sensor_is_right_or_refused():
    for case in sensor_cases.cases():
        found = case.run()
        assert found.verdict in ("right", "refused"), (case.name, found)
