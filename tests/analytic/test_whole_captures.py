"""Whole captures of drawn scene and sensor files against first principles; ``make attack`` draws others."""

import pytest

from tests.attack.captures import judged


@pytest.mark.parametrize("number", range(10))
def test_a_capture_is_what_its_files_ask_for(number):
    _, words = judged(0, number)
    assert not words
