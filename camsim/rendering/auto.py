"""Which method renders a job: a pure function of the inputs, no clock, no core count, no history."""

from __future__ import annotations

from dataclasses import dataclass

from camsim.errors import UnknownNameError
from camsim.rendering.by_boundary import BoundaryRun
from camsim.rendering.by_fourier import FourierRun
from camsim.rendering.cost import MEMORY_LIMIT_BYTES, Cost
from camsim.rendering.fourier import FINEST
from camsim.rendering.job import Job
from camsim.rendering.methods import METHODS
from camsim.rendering.run import FlatRun, Run

NAMES = ("auto", *METHODS)
CHEAP_SECONDS = 0.025  # nobody waits for this, and asking what the other engine would take is not free either


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """A method that is ready to run, and why it was chosen."""

    method: str
    why: str
    run: Run


def check_method(method: str) -> None:
    """Refuse the name of a method that does not exist."""
    if method not in NAMES:
        raise UnknownNameError("method", method, NAMES)


def choose(method: str, job: Job, samples: int | None = None) -> Choice:
    """Prepare the method named; "auto": boundary where it can and is cheaper, fourier otherwise.

    What a method cannot render it refuses, even where there is nothing to render.
    """
    if method != "auto":
        return _chosen(method, "asked for", job, samples)
    if job.pattern is None or job.footprint is None:
        return _chosen("fourier", job.unknown, job, samples)
    if job.tolerance < job.pattern.finest:
        why = f"boundary keeps {job.pattern.finest:g} with this lens, fourier {FINEST:g}"
        return _chosen("fourier", why, job, samples)
    boundary = _chosen("boundary", "exact for this lens, and cheap", job, samples)
    if not isinstance(boundary.run, BoundaryRun):
        return Choice(method="boundary", why="there is no edge to render", run=boundary.run)
    own = boundary.run.cost
    if own.seconds <= CHEAP_SECONDS:
        return boundary
    # It takes no fewer wavelengths than boundary, and to choose its own takes a while: first what it takes with those.
    fourier = FourierRun(job=job, nodes=boundary.run.lens.nodes)
    if fourier.cost.seconds < own.seconds or own.memory_bytes > MEMORY_LIMIT_BYTES:
        fourier = FourierRun.prepare(job, samples)
    cost = fourier.cost
    fits = cost.memory_bytes <= MEMORY_LIMIT_BYTES
    if fits and (cost.seconds < own.seconds or own.memory_bytes > MEMORY_LIMIT_BYTES):
        why = f"{_taking(cost)} expected, boundary {_taking(own)}"
        return Choice(method="fourier", why=why, run=fourier)
    return Choice(method="boundary", why=f"{_taking(own)} expected, fourier {_taking(cost)}", run=boundary.run)


def _taking(cost: Cost) -> str:
    if cost.memory_bytes > MEMORY_LIMIT_BYTES:
        return f"{cost.memory_bytes / 1e9:.2g} GB of memory"
    return f"{cost.seconds:.2g} s of one core"


def _chosen(method: str, why: str, job: Job, samples: int | None) -> Choice:
    run = METHODS[method](job, samples)
    return Choice(method=method, why=why, run=run if job.edges else FlatRun(job=job))
