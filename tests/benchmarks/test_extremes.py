"""Stiff and extreme cases as a run: a table, a page of HTML, an exit code."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bench.extremes import judging, sensor_cases
from bench.results import read_results

ROOT = Path(__file__).parents[2]

BROKEN = """
import sys

from bench.extremes import judging, sensor_cases
from bench.extremes.judging import ExtremeCase, Outcome


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
judging.cases, sensor_cases.cases = lambda: CASES[:{count}], lambda: []
from bench.extremes.__main__ import main
sys.argv = ["extremes", "-o", "out"]
main()
"""


@pytest.mark.parametrize(("count", "code", "words"), [(2, 0, "all are right or refused"), (4, 1, "2 are wrong")])
def test_extremes_are_a_table_and_an_exit_code(tmp_path, count, code, words):
    done = subprocess.run(
        [sys.executable, "-c", BROKEN.replace("{count}", str(count))],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        encoding="utf-8",
        timeout=600,
        check=False,
    )
    assert done.returncode == code, done.stderr
    assert f"{count} stiff and extreme cases: {words}" in done.stdout
    assert re.search(r"good +asked 1e-06 +reached 2e-07 +0\.1 s +right", done.stdout)
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
