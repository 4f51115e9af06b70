"""The list of stiff and extreme cases (bench/extremes/rendering_cases.py): what is quick of it, right or refused."""

import re

import pytest

from bench.extremes.judging import cases

# Each takes seconds: plain quadrature on sharp patterns, the other engine on sharp photosites or thousands of tiles.
SLOW = {
    "f/0.5",
    "f/1.4",
    "pitch 50 µm",
    "λN = 0.01, photosites",
    "2500 tiles, one colour",
    "2500 tiles, three colours",
    "10 000 corners",
}
CASES = {case.name: case for case in cases()}


@pytest.mark.parametrize("name", [name for name in CASES if name not in SLOW])
def test_right_or_refused(name):
    outcome = CASES[name].run()
    if outcome.reached is None:
        assert outcome.verdict == "refused"
        assert re.fullmatch(r"[^\n]{20,}", outcome.truth)
    else:
        assert outcome.verdict == "right"
        assert outcome.reached <= outcome.asked


def test_the_list_is_whole():
    assert set(CASES) > SLOW
    assert len(CASES) == len(cases()) >= 45
    assert all(case.input for case in CASES.values())
