"""The ways in which a round pattern is taken: a curve over |k|, or over a rectangle of the plane as any other.

A curve is a circle's, as far as the farthest edge is. Where scenery lies to one side, or frame and scenery are long and
narrow, a rectangle of what is asked for has fewer frequencies.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.optics.difference import RoundDifference
from camsim.optics.protocols import Fading, Round
from camsim.rendering.job import Job

PART = 0.35  # of the circle's square, what a rectangle has at most that is worth a plan: all about a scene it has half


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
    fades = isinstance(lens, Fading) and lens.fades
    if isinstance(lens, Round) and not job.system.more and not fades and _is_narrow(job):
        ways.append(Way(job, over_rectangle=True))
    return tuple(ways)


def _is_narrow(job: Job) -> bool:
    """Whether the rectangle of all ways from a photosite to an edge has little of the square about their circle."""
    if not len(job.edges):
        return False
    size = np.array([job.grid.cols - 1.0, job.grid.rows - 1.0])
    low, high = (np.asarray(corner) - job.grid.first_centre for corner in job.edges.box)
    nearest, farthest = low - size - job.extent, high + job.extent
    radius = float(np.hypot(*np.maximum(np.abs(nearest), np.abs(farthest))))
    return bool(np.prod(farthest - nearest) <= PART * (2.0 * radius) ** 2)


def as_in(job: Job, like: Way) -> Way:
    """Return a job in the same way as a like one."""
    lens = job.system.lens
    if isinstance(lens, RoundDifference) and not isinstance(like.job.system.lens, RoundDifference):
        return Way(job.behind(lens.on_lattice))
    return Way(job, like.over_rectangle)
