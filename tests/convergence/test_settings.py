"""The error budget adds up, and pages show it."""

import runpy
import typing
from pathlib import Path

import pytest

from camsim.rendering import budget

PAGES = runpy.run_path(str(Path(__file__).parents[2] / "bench" / "budget_pages.py"))


def test_shares_add_to_one():
    spiked = {source: share for source, share in budget.FREQUENCIES.items() if source != "bent edges"}
    for engine in (budget.BOUNDARY, spiked):
        assert sum(share.part for share in (budget.SCENE | engine).values()) == pytest.approx(1.0, abs=1e-12)
    assert budget.FREQUENCIES["bent edges"].part < budget.FREQUENCIES["spikes"].part  # of lenses that bend none spikes
    assert set(budget.SCENE | budget.BOUNDARY | budget.FREQUENCIES) == set(typing.get_args(budget.Source))


@pytest.mark.parametrize("page", list(PAGES["TABLES"]))
def test_pages_show_the_budget(page):
    text = (PAGES["DOCS"] / page).read_text(encoding="utf-8")
    assert PAGES["written"](text, PAGES["TABLES"][page]) == text
