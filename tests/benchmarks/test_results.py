"""Stored results: which files are taken for some, and how numbers are kept."""

import json

import pytest

from bench.results import read_results
from camsim.bench.records import rounded
from camsim.errors import InputError

from .lines import head


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (json.dumps(head(format="camsim-bench/0")), "of version 'camsim-bench/0', and this camsim compares"),
        (json.dumps({"kind": "point"}), "its first line is not a run"),
        ("7", "its first line is not a run"),
        ("", "its first line is not a run"),
        ("a,b\n1,2", "it is not JSON lines"),
    ],
)
def test_other_files_are_refused(tmp_path, text, words):
    (tmp_path / "old.jsonl").write_text(text)
    with pytest.raises(InputError, match=words):
        read_results(tmp_path / "old.jsonl")


def test_numbers_are_kept_to_four_digits():
    assert rounded({"a": [1.23456e-9, 3], "b": None, "c": True}) == {"a": [1.235e-9, 3], "b": None, "c": True}
