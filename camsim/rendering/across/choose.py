"""How a scene behind a lens that changes over the frame is rendered: its edges bent, its tiles and places chosen."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import OpticalSystem
from camsim.optics.placed import Revolves
from camsim.optics.protocols import Rectangular, Varies
from camsim.rendering.bending import Bending
from camsim.rendering.across.field_judge import FieldJudge
from camsim.rendering.across.field_plan import FieldPlan
from camsim.rendering.across.judge import AcrossJudge
from camsim.rendering.across.lattice import SINGLY, lattice_for, one_by_one
from camsim.rendering.across.plan import AcrossPlan
from camsim.rendering.auto import FOURIER, Choice, fits, refuse_much
from camsim.rendering.budget import PLACES_PART, ErrorBudget
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job
from camsim.rendering.paper import rules
from camsim.rendering.spectral import carrying
from camsim.scene import Scene
from camsim.scene.arrange import Arrangement

SOON = 1.0  # seconds, for which no transfers are made to find out whether those take less
MANY, ALONE_SECONDS = 4096, 30.0  # photosites that may each be rendered alone if it takes no longer
DEAR = 10.0  # seconds: of a check, or of an image that is asked for, from which on another way is looked for
UNHEARD = 0.005  # of the signal at either end of the spectrum, whose patterns set no lattice


def choose_across(
    scene: Scene,
    arrangement: Arrangement,
    system: OpticalSystem,
    grid: Grid,
    *,
    response: F64,
    wavelength_nm: F64,
    tolerance: float,
    method: str,
) -> Choice:
    """Plan a rendering behind a lens with ``Varies``; arguments as in ``render_channels``."""
    lens = system.lens
    assert isinstance(lens, Varies)
    if method in rules.METHODS:
        raise UnsupportedError(
            f"{method} renders one pattern for all of the frame; use boundary, fourier or auto", key="method"
        )
    signal = np.abs(response).sum(axis=0)
    seen_nm = wavelength_nm[carrying(response)]
    if wrong := lens.lacks(seen_nm, _corners_um(grid)):
        raise UnsupportedError(f"the lens {wrong}", key="lens")
    budget = ErrorBudget(tolerance)
    bending = None
    if lens.distorts:
        blur_um = system.blur_um(float(seen_nm.min()))
        photosite, peak_per_um = system.photosite, math.inf
        if isinstance(photosite, Rectangular) and min(photosite.sides_um) > 0.0:
            # A rectangle's shadow is nowhere higher than along its diagonal.
            peak_per_um = math.hypot(*photosite.sides_um) / math.prod(photosite.sides_um)
        bending = Bending(
            lens=lens, grid=grid, blur_um=blur_um, peak_per_um=peak_per_um, allowed=budget.allowed("bent edges")
        )
        sides = bending.sides(arrangement.start_um, arrangement.end_um)
        arrangement = dataclasses.replace(
            arrangement,
            start_um=sides.start,
            end_um=sides.end,
            left=arrangement.left[sides.owner],
            right=arrangement.right[sides.owner],
        )
    axis = dataclasses.replace(system, lens=lens.at(0.0, 0.0))
    job = Job.of(
        scene, arrangement, axis, grid, response=response, wavelength_nm=wavelength_nm, tolerance=tolerance,
        bending=bending,
    )  # fmt: skip
    by_edges = job.finest is not None and tolerance >= 2.0 * job.finest and method != "fourier"
    if method == "boundary" and not by_edges:
        raise UnsupportedError(job.unknown or "it cannot keep this tolerance; use fourier", key="method")
    name = "boundary" if by_edges else "fourier"
    why = "asked for" if method != "auto" else "its places are rendered by it"
    judge = AcrossJudge(job=job, lens=lens, transforms=FOURIER)
    if by_edges and isinstance(lens, Revolves) and lens.turns and len(job.edges):
        field = FieldPlan.of_job(job, lens)
        alone = _one_by_one(job, lens, judge, name if method == "boundary" else "fourier")
        try:
            if choice := _by_edges(field, judge, alone, why, patience=DEAR if method == "boundary" else 0.0):
                return choice
            if not alone and method == "boundary":
                refuse_much(name, field)
            why = f"boundary would take {field.cost.memory_bytes / 1e9:.1f} GB"
        except UnsupportedError as unfollowed:
            if not alone and method == "boundary":
                raise
            why = f"boundary: {unfollowed.message}"
        if alone:
            return alone
        name = "fourier"
    loud = np.cumsum(signal) > UNHEARD * signal.sum()
    shortest_nm = float(wavelength_nm[int(np.argmax(loud))])
    try:
        lattice = lattice_for(lens, grid, shortest_nm, budget.allowed("between places"))
    except UnsupportedError:
        if alone := _one_by_one(job, lens, judge, name):
            return alone
        raise
    finest = FOURIER.finest * lattice.gain / PLACES_PART
    if name == "fourier" and tolerance < finest:
        raise InvalidValueError(
            f"{tolerance:g} is finer than places behind this lens are rendered to by fourier: {finest:.2g}",
            key="tolerance",
        )
    plan = AcrossPlan(job=job, lens=lens, lattice=lattice, method=name)
    if method == "auto" and name == "boundary" and tolerance >= finest and plan.cost.seconds > SOON:
        other = AcrossPlan(job=job, lens=lens, lattice=lattice, method="fourier")
        if fits(other) and (other.cost.seconds < plan.cost.seconds or not fits(plan)):
            name, why, plan = "fourier", "its places are rendered by it, which takes less", other
    refuse_much(name, plan)
    return Choice(method=name, why=why, plan=plan, judge=judge)


def _one_by_one(job: Job, lens: Varies, judge: AcrossJudge, method: str) -> Choice | None:
    """Return every photosite with a pattern of its own, where there are few or that does not take long."""
    count = job.grid.rows * job.grid.cols
    if count > MANY:
        return None
    plan = AcrossPlan(job=job, lens=lens, lattice=one_by_one(job.grid), method=method)
    if not fits(plan) or (count > SINGLY and plan.cost.seconds > ALONE_SECONDS):
        return None
    return Choice(method=method, why="so few photosites are rendered one by one", plan=plan, judge=judge)


def _by_edges(
    field: FieldPlan, judge: AcrossJudge, alone: Choice | None, why: str, *, patience: float
) -> Choice | None:
    """Return one image of all places, or what is rendered one by one where that takes less; None: too much memory.

    patience : seconds that an image of all may take, whatever photosites one by one take

    What an image of all takes at the least is known before there are transfers along the radius, which may take long.
    """
    each = alone.cost.seconds if alone else math.inf
    if alone:
        if patience < max(SOON, field.least_seconds) >= each:
            return alone
        planned = field.planned_seconds(max(each, patience))
        # Behind a lens that changes so much what comes after its transfers may be refused, after as long again.
        if patience < planned and each <= (max(planned, ALONE_SECONDS) if patience else planned):
            return alone
    if not fits(field):
        return None
    own = FieldJudge(job=field.perfect, lens=field.image.lens, transforms=FOURIER)
    seconds = own.seconds(field)
    dear = seconds > DEAR and judge.seconds(field) < seconds
    together = Choice(method="boundary", why=why, plan=field, judge=judge if dear else own)
    return alone if alone and patience < together.cost.seconds >= each else together


def _corners_um(grid: Grid) -> F64:
    """Return the centres of the window's corner photosites (4, 2)."""
    first = np.array(grid.first_centre)
    last = first + np.array([grid.cols - 1, grid.rows - 1])
    corners: F64 = grid.pitch_um * np.array([[x, y] for x in (first[0], last[0]) for y in (first[1], last[1])])
    return corners
