"""A difference that is round: by a curve over |k|, or by its pattern on a lattice as any other."""

from __future__ import annotations

from camsim.optics.difference import RoundDifference
from camsim.rendering.job import Job


def is_curve(lens: object) -> bool:
    """Whether a lens is a difference whose transfer is one curve."""
    return isinstance(lens, RoundDifference)


def ways_of(job: Job) -> tuple[Job, ...]:
    """Return a job as it may be taken: a circle as far as an edge is, or a rectangle of what is asked for."""
    lens = job.system.lens
    return (job, job.behind(lens.on_lattice)) if isinstance(lens, RoundDifference) else (job,)


def as_in(job: Job, like: Job) -> Job:
    """Return a job with its difference on a lattice, if a like one has it there."""
    return job if is_curve(like.system.lens) else ways_of(job)[-1]
