"""The stored run, and the pages whose figures are made from it."""

import doctest
import sys
from pathlib import Path

import pytest

from bench import teller
from bench.paper import findings, pages
from bench.paper.findings import TABLE_PSF, contender, true_error
from bench.results import of_kind, read_results

ROOT = Path(__file__).parents[2]


def test_pages_say_what_the_stored_run_says(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["pages", "--check"])
    pages.main()


@pytest.mark.parametrize("module", [findings, pages, teller])
def test_examples_in_docstrings(module):
    found = doctest.testmod(module)
    assert found.attempted > 0
    assert found.failed == 0


def test_the_stored_run_is_honest():
    """Every exact engine kept its tolerance everywhere, and both truths agree."""
    lines = read_results(ROOT / "bench" / "paper" / "results.jsonl")
    points = of_kind(lines, "point")
    assert {contender(p) for p in points if p["psf"] == TABLE_PSF} >= {"auto", "boundary", "fourier", "GalSim"}
    for p in points:
        if "tolerance" in p:
            assert true_error(p) <= p["tolerance"], (p["psf"], p["label"])
    assert all(line["largest_difference"] < 2e-12 for line in of_kind(lines, "truth"))
