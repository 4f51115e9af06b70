"""Bent edges as chords and slivers, against the hundreds of short sides that stand for them elsewhere."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import camsim
from camsim.optics import FieldLens, OpticalSystem
from camsim.rendering.across.field_plan import FieldPlan
from camsim.rendering.across.slivers import straightened
from camsim.rendering.auto import BOUNDARY
from camsim.rendering.render import plan_render

SIDE, SIZE, ORIGIN = 4000, 80, (3300, 700)
NM = np.array([450.0, 550.0, 650.0])
RESPONSE = np.array([[0.1, 0.5, 0.4], [0.5, 0.4, 0.1]])


def plan_of(tolerance: float, f_number: float, pitch_um: float, barrel: float) -> FieldPlan:
    """Two shapes of other colours that lie over one another, some corners within the window."""
    radius_um = 0.75 * SIDE * pitch_um
    lens = FieldLens(
        f_number=f_number,
        wavelength_nm=[550.0],
        zernike=[4],
        waves=[[[0.0], [0.05]]],
        height_um=[0.0, radius_um],
        distortion_powers=[barrel],
    )
    grid = camsim.Grid(rows=SIZE, cols=SIZE, pitch_um=pitch_um, origin=ORIGIN, frame=(SIDE, SIDE))
    middle = pitch_um * (np.array(grid.first_centre) + 0.5 * SIZE)
    # Where it falls, about: the distortion draws it towards the axis.
    middle = middle / (1.0 + barrel * np.square(np.hypot(*middle) / radius_um))
    first = np.array([(-40.0, -400.0), (45.0, -380.0), (30.0, 25.0), (-300.0, 60.0)])
    second = np.array([(-20.0, -15.0), (500.0, 20.0), (480.0, 400.0), (-70.0, 300.0)])
    red, grey = camsim.reflectance("orange"), 0.3
    scene = camsim.Scene(
        background=0.8,
        shapes=[
            camsim.Polygon(points_um=middle + pitch_um * points, reflectance=reflectance)
            for points, reflectance in ((first, grey), (second, red))
        ],
    )
    system = OpticalSystem.of(
        [lens, camsim.FourSpotOlpf(split_um=0.7 * pitch_um), camsim.SquarePhotosite(side_um=pitch_um)]
    )
    plan = plan_render(scene, system, grid, response=RESPONSE, wavelength_nm=NM, tolerance=tolerance).plan
    assert isinstance(plan, FieldPlan)
    return plan


@pytest.mark.parametrize(
    ("tolerance", "f_number", "pitch_um", "barrel"),
    [(1e-5, 5.6, 4.0, -0.02), (1e-5, 2.8, 8.0, 0.02), (1e-3, 8.0, 3.0, -0.05), (1e-6, 2.8, 8.0, 0.002)],
)
def test_chords_and_slivers_show_what_short_sides_do(tolerance, f_number, pitch_um, barrel) -> None:
    plan = plan_of(tolerance, f_number, pitch_um, barrel)
    job, slivers = plan.image.job, plan.slivers
    straight = straightened(job, slivers.allowed)
    assert len(straight.points) > 2
    assert len(straight.edges) < 0.7 * len(job.edges)
    fine = dataclasses.replace(job, tolerance=max(0.02 * tolerance, 2.0 * job.round_part.finest))
    letters = (np.indices((SIZE, SIZE)).sum(axis=0) % len(RESPONSE)).astype(np.uint8)
    short, long = (
        np.concatenate(list(BOUNDARY.plan(own.round_part).bands(letters, lambda done: None)))
        for own in (fine, fine.with_edges(straight.edges))
    )
    own = np.zeros((SIZE, SIZE))
    slivers.add(letters, own)
    for channel in range(len(RESPONSE)):
        here = letters == channel
        without, left = (np.abs(each[here]).max() for each in (short - long, short - long - own))
        assert left <= slivers.allowed
        assert without > 5.0 * left


def test_an_outline_that_bends_is_left_as_it_is() -> None:
    """A disc's sides are no chord's: its rings meet in its middle, and are followed there."""
    plan = plan_of(1e-5, 5.6, 4.0, -0.02)
    job = plan.image.job
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    points = np.array(job.grid.first_centre) + 50.0 + 40.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    edges = dataclasses.replace(
        job.edges, start=points[:-1], end=points[1:], left=np.ones(399, np.int64), right=np.zeros(399, np.int64)
    )
    assert not straightened(job.with_edges(edges), 1e-6).points


@pytest.mark.parametrize("through", [(0.0, 0.0), (7.0, -3.0)])
def test_a_side_of_a_million_frames_is_laid_where_it_is_seen(through) -> None:
    """A half-plane through the axis, which distortion leaves straight, asked for 167 GiB; a large card is the same."""
    turn = math.radians(5.0)
    middle = np.array(through) * 3.45 + 30_000.0 * np.array([math.cos(turn), math.sin(turn)])
    card = f"{{kind: rectangle, width: 6e4, height: 6e4, centre: {middle.tolist()}, rotate_deg: 5, reflectance: 0.05}}"
    line = f"{{kind: half-plane, through: {[3.45 * at for at in through]}, towards_deg: 5, reflectance: 0.05}}"
    changes = ["lens={kind: field, file: double-gauss}", "region={rows: 24, cols: 24}", "render.tolerance=1e-3"]
    changes += ["light={line_nm: 550, illuminance_lux: 3000}", "scene.unit=um", "noise.enabled=false"]
    of_line, of_card = (
        camsim.capture("slanted-edge", sensor="mono-345", overrides=[*changes, f"scene.shapes=[{shape}]"])
        for shape in (line, card)
    )
    off = np.abs(of_line.mean_electrons - of_card.mean_electrons).max()
    assert off < 2e-3 * of_card.mean_electrons.max()
