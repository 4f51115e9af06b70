"""The ways in which a round pattern is taken: a curve over |k|, or over a rectangle of the plane as any other.

A curve is a circle's, as far as the farthest edge is. Where scenery lies to one side, or frame and scenery are long and
narrow, a rectangle of what is asked for has fewer frequencies.
"""

from __future__ import annotations

from typing import NamedTuple

from camsim.optics.difference import RoundDifference
from camsim.optics.protocols import Fading, Round
from camsim.rendering.job import Job

SOON = 0.03  # seconds, for which nobody looks for another way


class Way(NamedTuple):
    """A job, and whether a pattern that is round is taken over a rectangle, from what it is along its radius."""

    job: Job
    over_rectangle: bool = False

    @property
    def curve(self) -> bool:
        """Whether it is one, of a difference."""
        return isinstance(self.job.system.lens, RoundDifference) and not self.over_rectangle


def ways_of(job: Job) -> tuple[Way, ...]:
    """Return a job as it may be taken: a round pattern as a curve first."""
    lens = job.system.lens
    ways = [Way(job)]
    if isinstance(lens, RoundDifference):
        ways.append(Way(job.behind(lens.on_lattice)))
    if isinstance(lens, Round) and not job.system.more and not (isinstance(lens, Fading) and lens.fades):
        ways.append(Way(job, over_rectangle=True))
    return tuple(ways)


def as_in(job: Job, like: Way) -> Way:
    """Return a job in the same way as a like one."""
    lens = job.system.lens
    if isinstance(lens, RoundDifference) and not isinstance(like.job.system.lens, RoundDifference):
        return Way(job.behind(lens.on_lattice))
    return Way(job, like.over_rectangle)
