"""Choice of the engine that renders a job, and of the check."""

from __future__ import annotations

from dataclasses import dataclass

from camsim.core.typed import known_name
from camsim.errors import UnsupportedError
from camsim.optics import RoundLens
from camsim.rendering.boundary.engine import Boundary
from camsim.rendering.direct.checks import Checks
from camsim.rendering.direct.direct_check import DirectCheck
from camsim.rendering.direct.fourier_check import FARTHER, MANY, FourierCheck
from camsim.rendering.engine import FINEST, MEMORY_LIMIT_BYTES, Cost, Engine, Plan, too_much
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.layer import Layer
from camsim.rendering.flat import FlatPlan
from camsim.rendering.job import Job
from camsim.rendering.paper import rules
from camsim.rendering.paper.engine import Paper
from camsim.rendering.waves.plan import Waves, WavesPlan
from camsim.scene import Scene
from camsim.scene.raster import Field

BOUNDARY, FREQUENCIES = Boundary(), Waves()
ENGINES: dict[str, Engine] = {
    "boundary": BOUNDARY,
    "fourier": FREQUENCIES,
    **{method: Paper(method) for method in rules.METHODS},
}
NAMES = ("auto", *ENGINES)
CHEAP_SECONDS = 0.05  # cost of the boundary engine up to which a plan of the other would save nothing
IMAGE_BYTES = 24.0  # of a photosite: whole images, which do not count as an engine's tables and transforms
AROUND = 1.5  # what counted operations take in all, with what is not counted
CAPTURE_SECONDS, RECORDED_SECONDS = 0.025, 5e-8  # of a capture, and of a photosite's noise and code
CROWD = 1_000, 20_000  # edges from which on closed forms are not considered: in small frames, and in large ones
EACH = 40  # photosites to an edge, for frames between
CURVES = 1_000  # lines, circles and other curves of a scene that direct sums check, however many edges they become
DIRECT = 1e-8  # finest tolerance that direct sums check
WIDEST = 50.0  # largest side of a picture's sample for direct sums, in periods of the highest frequency


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """A plan that is ready to run, the reason why it was chosen, and the check of its image."""

    method: str
    why: str
    plan: Plan
    checker: Checks
    samples: int | None = None

    def __repr__(self) -> str:
        return f"Choice({self.method}: {self.why}; about {_taking(self.cost)})"

    @property
    def cost(self) -> Cost:
        """Cost of one capture, the check included."""
        cost, grid = self.plan.cost, self.plan.job.grid
        seconds = AROUND * (cost.seconds + self.checker.seconds(self.plan))
        recorded = CAPTURE_SECONDS + RECORDED_SECONDS * grid.rows * grid.cols
        return Cost(seconds=seconds + recorded, memory_bytes=cost.memory_bytes)


def check_method(method: str) -> None:
    """Refuse the name of a method that does not exist."""
    known_name("method", method, NAMES)


def choose(
    method: str, job: Job, samples: int | None = None, *, scene: Scene | None = None, fields: FieldJob | None = None
) -> Choice:
    """Plan with the method named; "auto": boundary if it applies and is cheaper, fourier otherwise.

    scene  : the whole scene, if that is more than the job's edges
    fields : the pictures, gradients and points of that scene

    Raises UnsupportedError for a job that the method does not support, even if there is nothing to render, and
    InvalidValueError for a plan that exceeds the memory limit.
    """
    if fields is not None:
        if method not in ("auto", "fourier"):
            raise UnsupportedError(
                f"{method} renders shapes, and no pictures, gradients or points; use fourier or auto", key="method"
            )
        name, why = "fourier", "pictures, gradients and points are rendered by it"
        plan: Plan = FREQUENCIES.plan(job, samples, fields)
    elif method != "auto":
        name, why, plan = method, "asked for", ENGINES[method].plan(job, samples)
        if not len(job.edges):
            plan = FlatPlan(job=job)
    else:
        name, why, plan = _auto(job, samples)
    if not fits(plan):
        raise too_much(name, plan.cost.memory_bytes)
    return Choice(method=name, why=why, plan=plan, checker=_checker(plan, scene or job.scene, fields), samples=samples)


def _checker(plan: Plan, scene: Scene, fields: FieldJob | None) -> Checks:
    """Return the check: direct sums for few outlines and a rotationally symmetric lens, else a second frequency sum."""
    job, like = plan.job, plan if isinstance(plan, WavesPlan) else None
    curves = sum(shape.pieces for shape in scene.shapes if not isinstance(shape, Field))
    few = len(job.edges) <= MANY or curves <= CURVES
    few = few and (fields is None or _waves_of_samples(fields) <= WIDEST)
    finest = job.tolerance if fields is None else job.tolerance / fields.brighter
    if isinstance(job.system.lens, RoundLens) and not job.system.more and finest >= DIRECT and few:
        return DirectCheck(job, scene)
    checker = FourierCheck(job=job, scene=scene, fields=fields, like=like)
    if checker.plan.cost.memory_bytes > FARTHER**2 * MEMORY_LIMIT_BYTES:  # than an image, of which that is the most
        raise too_much("the check", checker.plan.cost.memory_bytes)
    return checker


def _waves_of_samples(fields: FieldJob) -> float:
    """Return the largest side of a picture's sample, in periods of the lens's highest frequency."""
    step = max((layer.step for layer in fields.layers if isinstance(layer, Layer)), default=0.0)
    return step * fields.grid.pitch_um * fields.system.highest_per_um(fields.wavelength_nm)


def fits(plan: Plan) -> bool:
    """Return whether a plan stays within the memory limit, the image not counted."""
    grid = plan.job.grid
    return plan.cost.memory_bytes <= MEMORY_LIMIT_BYTES + IMAGE_BYTES * grid.rows * grid.cols


def _auto(job: Job, samples: int | None) -> tuple[str, str, Plan]:
    """Return the name of the cheaper engine, the reason, and its plan."""
    finest, crowd = job.finest, min(max(job.grid.rows * job.grid.cols / EACH, CROWD[0]), CROWD[1])
    if finest is None or job.tolerance < finest or len(job.edges) >= crowd:
        why = f"{len(job.edges)} edges"
        if finest is None:
            why = job.unknown
        elif job.tolerance < finest:
            why = f"boundary keeps {finest:g} with this lens, fourier {FINEST:g}"
        plan = FREQUENCIES.plan(job, samples)
        return "fourier", why, plan if len(job.edges) else FlatPlan(job=job)
    try:
        boundary = BOUNDARY.plan(job, samples)
    except UnsupportedError as refusal:
        return "fourier", f"boundary: {refusal.message}", FREQUENCIES.plan(job, samples)
    if not len(job.edges):
        return "boundary", "there is no edge to render", FlatPlan(job=job)
    one = boundary.cost
    if one.seconds <= CHEAP_SECONDS:
        return "boundary", "exact for this lens, and cheap", boundary
    frequencies = FREQUENCIES.plan(job, samples)
    cost = frequencies.cost
    if fits(frequencies) and (cost.seconds < one.seconds or not fits(boundary)):
        return "fourier", f"{_taking(cost)} expected, boundary {_taking(one)}", frequencies
    return "boundary", f"{_taking(one)} expected, fourier {_taking(cost)}", boundary


def _taking(cost: Cost) -> str:
    if cost.memory_bytes > MEMORY_LIMIT_BYTES:
        return f"{cost.memory_bytes / 1e9:.2g} GB of memory"
    return f"{cost.seconds:.2g} s of one core"
