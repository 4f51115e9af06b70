"""What was decided before a rendering, each decision with its reason, for people to read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from camsim.rendering.auto import Choice
from camsim.rendering.budget import SCENE
from camsim.rendering.by_boundary import BoundaryRun
from camsim.rendering.by_fourier import FourierRun
from camsim.rendering.job import Job


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """One decision.

    topic    : what it is about, a word or two
    decision : what is done, or left out
    reason   : why
    """

    topic: str
    decision: str
    reason: str


def rendering_decisions(job: Job, choice: Choice, *, light_samples: int, shapes: int) -> Iterator[Decision]:
    """Yield what was decided about a rendering.

    light_samples : wavelengths of the light;  shapes: of the scene
    """
    yield from _stages(job)
    yield from _edges(job, shapes)
    yield from _wavelengths(job, choice, light_samples)
    yield Decision(topic="engine", decision=choice.method, reason=choice.why)
    yield from _settings(choice)


def _stages(job: Job) -> Iterator[Decision]:
    system = job.system
    if system.olpf is None:
        yield Decision(topic="OLPF", decision="left out", reason="the camera has none: one spot")
    footprint = job.footprint
    if footprint is not None and footprint.side == 0.0:
        yield Decision(topic="photosite", decision="a point", reason="its sides are 0: nothing to average over")


def _edges(job: Job, shapes: int) -> Iterator[Decision]:
    out = job.left_out
    arranged = job.edges + out.equal + out.far
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
    elif job.edges:
        share = 100.0 * SCENE["dropped"].part
        yield Decision(
            topic="edges",
            decision="none dropped for being far",
            reason="how far this lens spreads light is not bounded by a formula"
            if job.pattern is None
            else f"inside the window, or their light in it may be more than {share:.0f} % of the tolerance",
        )


def _wavelengths(job: Job, choice: Choice, light_samples: int) -> Iterator[Decision]:
    seen = job.signals.wavelength_nm.size
    if seen < light_samples:
        yield Decision(
            topic="wavelengths",
            decision=f"{light_samples - seen} of {light_samples} dropped",
            reason="no channel responds there",
        )
    if not job.edges:
        return
    nodes = choice.run.wavelengths
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


def _settings(choice: Choice) -> Iterator[Decision]:
    run = choice.run
    if isinstance(run, BoundaryRun):
        settings, counts = run.lens.settings, run.lens.counts
        yield Decision(
            topic="settings",
            decision=f"ends integrated within {settings.near:.3g} pitches, lines looked up within {settings.reach:.3g}",
            reason="beyond, the far form keeps its share of the tolerance",
        )
        if len(settings.foci.radius):
            yield Decision(
                topic="settings",
                decision=f"rings followed to {len(settings.foci.radius)} round outlines",
                reason="in their centres the rings of all sides meet, and are heard",
            )
        yield Decision(
            topic="settings",
            decision=f"{counts.tables} tables, {counts.table_values:.2g} numbers",
            reason="fields and edge responses, one for each channel and pair of colours",
        )
    if isinstance(run, FourierRun):
        yield Decision(
            topic="settings",
            decision=f"{run.work(1).frequencies:.2g} frequencies",
            reason="a period and a taper wide enough that nothing wraps round within the tolerance",
        )


def expectation(choice: Choice, job: Job) -> dict[str, Any]:
    """Return what the rendering is expected to take: seconds of one core, bytes, and the error it may have."""
    cost = choice.run.cost
    return {"seconds": cost.seconds, "memory_bytes": cost.memory_bytes, "error": job.tolerance if job.edges else 0.0}
