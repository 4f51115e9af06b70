"""Decisions made before a rendering, each with its reason, for reports."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from camsim.rendering.auto import Choice
from camsim.rendering.budget import SCENE
from camsim.rendering.engine import Decision
from camsim.rendering.job import Job
from camsim.scene.point_source import NOTHING

MOST_STATED = 20  # shapes up to which each is reported separately


class Stated(NamedTuple):
    """Numbers reported of a shape: outlines, their sides and curves, and outlines hidden by later ones."""

    outlines: int
    sides: int
    bent: int
    hidden: int


def rendering_decisions(choice: Choice, *, light_samples: int, shapes: int) -> Iterator[Decision]:
    """Yield the decisions about a rendering.

    light_samples : number of wavelengths of the light;  shapes: number of shapes in the scene
    """
    job = choice.plan.job
    yield from _stages(job)
    yield from _shapes(job)
    yield from _edges(job, shapes)
    yield from _wavelengths(choice, light_samples)
    yield Decision(topic="engine", decision=choice.method, reason=choice.why)
    yield from choice.plan.decisions()


def _stages(job: Job) -> Iterator[Decision]:
    system = job.system
    if system.olpf is None:
        yield Decision(topic="OLPF", decision="left out", reason="the camera has none: one spot")
    footprint = job.footprint
    if footprint is not None and footprint.side == 0.0:
        yield Decision(topic="photosite", decision="a point", reason="its sides are 0: nothing to average over")
    if any(job.grid.moved_um):
        x, y = job.grid.moved_um
        moves = f"it moves the pattern of every wavelength by {x:.6g} µm along x and {y:.6g} µm along y"
        yield Decision(topic="tilt", decision="left out", reason=f"{moves}: photosites look as far the other way")


def _shapes(job: Job) -> Iterator[Decision]:
    """Yield a decision for each shape, or for each kind of shape if there are many."""
    stated: dict[str, list[Stated]] = {}
    made_of: dict[str, Counter[str]] = {}
    first = 0
    for number, shape in enumerate(job.scene.shapes):
        if shape is NOTHING:
            continue  # a point source, which has no outline
        primitives = list(shape.primitives())
        last = first + len(primitives)
        bent = sum(int(np.count_nonzero(fill.curves.kind)) for one in primitives for fill in one.fills)
        hidden = int(job.left_out.hidden[first:last].sum())
        kind = getattr(shape, "name", type(shape).__name__)  # a chart has a name
        name = kind if len(job.scene.shapes) > MOST_STATED else f"{kind} {number}"
        stated.setdefault(name, []).append(
            Stated(len(primitives), int(job.left_out.sides[first:last].sum()), bent, hidden)
        )
        first = last
        made_of.setdefault(name, Counter()).update(_leaves(shape) if hasattr(shape, "name") else ())
    for name, parts in stated.items():
        outlines, sides, bent, hidden = (sum(column) for column in zip(*parts, strict=True))
        drawn = "".join(f"{count} × {kind}, " for kind, count in made_of[name].most_common())
        many = f"{len(parts)} × " if len(parts) > 1 else ""
        curves = f", {bent} curves among them cut for the tolerance" if bent else ""
        plural = "s" if outlines != 1 else ""
        cover = f"; {hidden} left out: wholly under a later one" if hidden else ""
        yield Decision(
            topic="shape",
            decision=f"{many}{name}: {sides} sides",
            reason=f"{drawn}{outlines} outline{plural}{curves}{cover}",
        )


def _leaves(shape: Any) -> Iterator[str]:
    """Yield the class names of the shapes in a chart, a drawing or a group."""
    inner = getattr(shape, "shapes", None)
    if inner is None:
        yield type(shape).__name__
    for each in inner or ():
        yield from _leaves(each)


def _edges(job: Job, shapes: int) -> Iterator[Decision]:
    out = job.left_out
    arranged = len(job.edges) + out.equal + out.far
    if not shapes:
        yield Decision(topic="scene", decision="nothing to render", reason="there is no shape: all is background")
        return
    word = f"{shapes} shape{'s' if shapes != 1 else ''}"
    if arranged == out.outline_edges:
        yield Decision(topic="scene", decision=f"{arranged} edges", reason=f"of {word}; none hides or joins another")
    else:
        yield Decision(
            topic="scene",
            decision=f"{arranged} edges from {out.outline_edges}",
            reason=f"of {word}: what is covered is cut away, regions of one colour and shared edges are joined",
        )
    if out.equal:
        yield Decision(
            topic="edges",
            decision=f"{out.equal} dropped",
            reason="no channel sees a difference between their sides at any wavelength of this light",
        )
    if out.far:
        yield Decision(
            topic="edges",
            decision=f"{out.far} dropped",
            reason=f"far outside the window: all of them together add less than {out.bound:.1g} to any photosite",
        )
    elif len(job.edges):
        share = 100.0 * SCENE["dropped"].part
        yield Decision(
            topic="edges",
            decision="none dropped for being far",
            reason="how far this lens spreads light is not bounded by a formula"
            if job.pattern is None
            else f"inside the window, or their light in it may be more than {share:.0f} % of the tolerance",
        )


def _wavelengths(choice: Choice, light_samples: int) -> Iterator[Decision]:
    job = choice.plan.job
    seen = job.signals.wavelength_nm.size
    if seen < light_samples:
        yield Decision(
            topic="wavelengths",
            decision=f"{light_samples - seen} of {light_samples} dropped",
            reason="no channel responds there",
        )
    nodes = choice.plan.wavelengths
    if not nodes:
        return
    if nodes == 1:
        yield Decision(topic="wavelengths", decision="one", reason="the light is a line")
    elif nodes < seen:
        yield Decision(
            topic="wavelengths",
            decision=f"{seen} fused to {nodes} nodes",
            reason="the optics change slowly with wavelength; light and colours keep every sample in the weights",
        )
    else:
        yield Decision(topic="wavelengths", decision=f"{seen}", reason="so few that each is computed")


def expectation(choice: Choice) -> dict[str, Any]:
    """Return the expected seconds of one core, bytes of memory, and error of the rendering."""
    cost, plan = choice.cost, choice.plan
    error = plan.job.tolerance if plan.wavelengths else 0.0  # a flat scene is exact
    return {"seconds": cost.seconds, "memory_bytes": cost.memory_bytes, "error": error}
