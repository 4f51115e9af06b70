"""Which engine renders a job, and why."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camsim.errors import UnsupportedError
from camsim.kept import cached_property
from camsim.kernels.threads import meanwhile
from camsim.optics import RoundLens
from camsim.optics.of_pupil import OfPupil
from camsim.rendering.boundary.engine import Boundary, BoundaryPlan
from camsim.rendering.check.checks import Checks
from camsim.rendering.check.judge import Judge
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Cost, Engine, Plan, too_much
from camsim.rendering.flat import FlatPlan
from camsim.rendering.hearing import Listening
from camsim.rendering.job import Job
from camsim.rendering.paper import rules
from camsim.rendering.paper.engine import Paper
from camsim.typed import known_name

if TYPE_CHECKING:
    from camsim.rendering.aberrated.engine import AberratedPlan
    from camsim.rendering.check.fitting import Windows
    from camsim.rendering.fourier.engine import Fourier, FourierPlan
    from camsim.scene import Scene

BOUNDARY = Boundary()


class ByEdges:
    """Edges in closed form: behind a round lens all of them, behind an aberrated one but for a short difference."""

    def plan(self, job: Job, samples: int | None = None) -> BoundaryPlan | AberratedPlan:
        """Plan with the engine that knows the lens."""
        if job.split is None or job.footprint is None:
            return BOUNDARY.plan(job, samples)
        from camsim.rendering.aberrated.engine import Aberrated

        return Aberrated().plan(job, samples)


class ByTransforms:
    """Any lens: an engine that is imported when it is asked, which captures of a few edges never do."""

    @cached_property
    def _engine(self) -> Fourier:
        from camsim.rendering.fourier.engine import Fourier

        return Fourier()

    @property
    def finest(self) -> float:
        """The finest tolerance that it keeps."""
        return self._engine.finest

    def plan(self, job: Job, samples: int | None = None) -> FourierPlan:
        """Choose nodes; ``samples`` must be None."""
        return self._engine.plan(job, samples)

    def plan_like(self, job: Job, plan: FourierPlan) -> FourierPlan:
        """Choose nodes; in parts where a like job's plan is."""
        return self._engine.plan_like(job, plan)

    def least_seconds(self, job: Job) -> float:
        """Return what a plan is sure to take, without one."""
        return self._engine.least_seconds(job)

    def windows(self, job: Job, listening: Listening) -> Windows:
        """Return what renders windows of a job."""
        return self._engine.windows(job, listening)


BY_EDGES, FOURIER = ByEdges(), ByTransforms()
ENGINES: dict[str, Engine] = {
    "boundary": BY_EDGES,
    "fourier": FOURIER,
    **{method: Paper(method) for method in rules.METHODS},
}
NAMES = ("auto", *ENGINES)
CHEAP_SECONDS = 0.05  # the answer saves no more than this; to import and ask the other engine takes nearly as long
IMAGE_BYTES = 24.0  # of a photosite: whole images, which are no engine's tables and transforms
CROWD, DIRECT = 20_000, 1e-6  # edges that closed forms are not asked for; the finest tolerance of direct sums
MANY_EDGES = 100_000  # from which on the check's own scene takes a tenth of a second: it is made while engines plan
CHEAP_SPLIT_SECONDS = 0.1  # of a lens that is taken apart it takes 20 ms more


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """A plan that is ready to run, why it was chosen, and what judges it."""

    method: str
    why: str
    plan: Plan
    judge: Checks
    samples: int | None = None

    def __repr__(self) -> str:
        return f"Choice({self.method}: {self.why}; about {_taking(self.cost)})"

    @property
    def cost(self) -> Cost:
        """What one image takes, the check included."""
        return _checked(self.plan, self.judge)


def check_method(method: str) -> None:
    """Refuse the name of a method that does not exist."""
    known_name("method", method, NAMES)


def choose(method: str, job: Job, samples: int | None = None) -> Choice:
    """Plan with the method named; "auto": boundary where it can and is cheaper, fourier otherwise.

    What a method cannot render it refuses, even where there is nothing to render; what takes too much memory, before
    anything is rendered.
    """
    if method == "auto" and samples is None and len(job.edges) >= CROWD and isinstance(job.system.lens, RoundLens):
        from camsim.rendering.waves.plan import Waves

        direct, spread = judge_of(job, job.tolerance), Waves().plan(job)
        if direct is not None and fits(spread):
            return Choice(method="fourier", why=f"{len(job.edges)} edges", plan=spread, judge=direct)
    judge = Judge(job, FOURIER)
    with meanwhile(lambda: judge.seen) if len(job.edges) > MANY_EDGES else contextlib.nullcontext():
        if method != "auto":
            name, why, plan = method, "asked for", _planned(method, job, samples)
        else:
            name, why, plan = _auto(job, judge, samples)
    refuse_much(name, plan)
    return Choice(method=name, why=why, plan=plan, judge=judge, samples=samples)


def judge_of(job: Job, tolerance: float, scene: Scene | None = None) -> Checks | None:
    """Return what sums up what photosites see directly, of scenes that it judges quickest; None: not behind this lens.

    scene : where it is not the job's own, because pictures are left out there
    """
    from camsim.rendering.direct.judge import Judge as DirectSums

    lens = job.system.lens
    straight = isinstance(lens, OfPupil) and lens.pupil.shape != "circular"
    if tolerance < DIRECT or straight or job.system.more:
        return None
    return DirectSums(job, scene=scene, tolerance=tolerance)


def fits(plan: Plan) -> bool:
    """Whether a plan takes no more memory than it may, its image aside."""
    grid = plan.job.grid
    return plan.cost.memory_bytes <= MEMORY_LIMIT_BYTES + IMAGE_BYTES * grid.rows * grid.cols


def refuse_much(name: str, plan: Plan) -> None:
    """Refuse what takes too much memory."""
    if not fits(plan):
        raise too_much(name, plan.cost.memory_bytes)


def _auto(job: Job, judge: Judge, samples: int | None) -> tuple[str, str, Plan]:
    """Return the name of the cheaper engine, why, and its plan."""
    finest = job.finest
    if finest is None:
        return "fourier", job.unknown, _planned("fourier", job, samples)
    if job.tolerance < finest:
        why = f"boundary keeps {finest:g} with this lens, fourier {FOURIER.finest:g}"
        return "fourier", why, _planned("fourier", job, samples)
    try:
        boundary = BY_EDGES.plan(job, samples)
    except UnsupportedError as unfollowed:
        return "fourier", f"boundary: {unfollowed.message}", _planned("fourier", job, samples)
    if not len(job.edges):
        return "boundary", "there is no edge to render", FlatPlan(job=job)
    own = _checked(boundary, judge)
    if own.seconds <= (CHEAP_SECONDS if job.split is None else CHEAP_SPLIT_SECONDS):
        return "boundary", "exact for this lens, and cheap", boundary
    if _fits(own) and own.seconds <= (least := FOURIER.least_seconds(job) + judge.least_seconds):
        return "boundary", f"{_taking(own)} expected, fourier over {least:.2g} s", boundary
    fourier = FOURIER.plan(job, samples)
    cost = _checked(fourier, judge)
    if _fits(cost) and (cost.seconds < own.seconds or not _fits(own)):
        return "fourier", f"{_taking(cost)} expected, boundary {_taking(own)}", fourier
    return "boundary", f"{_taking(own)} expected, fourier {_taking(cost)}", boundary


def _checked(plan: Plan, judge: Checks) -> Cost:
    cost = plan.cost
    return Cost(seconds=cost.seconds + judge.seconds(plan), memory_bytes=cost.memory_bytes)


def _fits(cost: Cost) -> bool:
    return cost.memory_bytes <= MEMORY_LIMIT_BYTES


def _taking(cost: Cost) -> str:
    if not _fits(cost):
        return f"{cost.memory_bytes / 1e9:.2g} GB of memory"
    return f"{cost.seconds:.2g} s of one core"


def _planned(method: str, job: Job, samples: int | None) -> Plan:
    plan = ENGINES[method].plan(job, samples)
    return plan if len(job.edges) else FlatPlan(job=job)
