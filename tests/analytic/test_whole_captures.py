"""Whole captures of drawn scene and sensor files against first principles; ``make attack`` draws others."""

import pytest

from tests.attack.captures import judged, observer


@pytest.fixture(scope="module")
def eye():
    return observer()


@pytest.mark.parametrize("number", range(24))
def test_a_capture_is_what_its_files_ask_for(number, eye):
    _, words = judged(0, number, eye)
    assert not words
