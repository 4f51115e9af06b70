"""The error budget adds up, and the models that keep its shares are bounds: settings changed one at a time."""

import dataclasses
import math
import runpy
import typing
from pathlib import Path

import numpy as np
import pytest

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering import budget
from camsim.rendering.boundary.engine import Boundary
from camsim.rendering.boundary.settings import _panel_nodes, _piece_nodes, _step
from camsim.rendering.render import plan_render

PAGES = runpy.run_path(str(Path(__file__).parents[2] / "bench" / "budget_pages.py"))
TRIANGLE = ((-5.3, -6.1), (7.2, -3.3), (1.1, 6.4))
LENSES = [camsim.Airy(f_number=1.0 / 0.55), camsim.Gaussian(sigma_um=1.0)]


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


class Rendered:
    """One system at the finest settings, and at others."""

    def __init__(self, lens):
        scene = camsim.Scene(background=0.0, shapes=[camsim.Polygon(points_um=TRIANGLE, reflectance=1.0)])
        job = plan_render(
            scene,
            OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=0.0)]),
            camsim.Grid(rows=16, cols=16, pitch_um=1.0),
            response=np.ones((1, 1)),
            wavelength_nm=np.array([550.0]),
            tolerance=1e-7,
        ).plan.job
        self.plan = Boundary().plan(job)
        # Radii shorter than the sides, so that responses are looked up; the ringing beyond is neglected by all alike.
        self.fine = dataclasses.replace(
            self.plan.settings, near=8.0, reach=8.0, field_step=1 / 24, response_step=1 / 40, panel_nodes=14
        )
        self.reference = self.with_settings()

    def with_settings(self, **changed):
        plan = dataclasses.replace(self.plan, settings=dataclasses.replace(self.fine, **changed))
        return np.concatenate(list(plan.bands(np.zeros((16, 16), np.uint8), lambda done: None)))

    def error(self, **changed):
        return float(np.abs(self.with_settings(**changed) - self.reference).max())


@pytest.fixture(scope="module", params=LENSES, ids=["airy", "gaussian"])
def rendered(request):
    return Rendered(request.param)


@pytest.mark.parametrize("allowed", [1e-8, 1e-4])
def test_look_ups_keep_what_their_steps_were_chosen_for(rendered, allowed):
    pattern = rendered.plan.pattern
    field = _step(pattern, 8, allowed / (43.066 / math.factorial(8)))
    response = _step(pattern, 6, 0.5 * allowed / (3.5156 / math.factorial(6)))
    assert 1e-3 * allowed < rendered.error(field_step=field) < allowed
    # The next term of the look-up is a tenth where the step is coarsest.
    assert 1e-3 * allowed < rendered.error(response_step=response) < 1.15 * allowed


@pytest.mark.parametrize("allowed", [1e-7, 1e-3])
def test_panels_keep_what_their_nodes_were_chosen_for(rendered, allowed):
    pattern = rendered.plan.pattern
    nodes = _panel_nodes(pattern, allowed)
    found = rendered.error(piece_nodes=_piece_nodes(pattern, allowed, nodes))
    assert found < 0.5 * allowed
    assert rendered.error(piece_nodes=_piece_nodes(pattern, math.inf, nodes - 1)) > found
