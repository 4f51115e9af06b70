"""Aberrated lenses as a plan: the round part by the engine that is cheaper, the difference where an edge is near."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

from camsim.arrays import F64, I64, U8
from camsim.errors import UnsupportedError
from camsim.kept import cached_property
from camsim.optics.difference import Difference
from camsim.rendering.aberrated.cost import Counts, short_cost, short_counts
from camsim.rendering.aberrated.image import ShortImage
from camsim.rendering.aberrated.settings import settings_of
from camsim.rendering.boundary.engine import Boundary, BoundaryPlan
from camsim.rendering.boundary.settings import check_tolerance
from camsim.rendering.budget import CLOSED_PART
from camsim.rendering.engine import Cost, Decision, Marks, Progress, added, one_by_one
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import wavefront_phase
from camsim.rendering.work import Work
from camsim.repeated import Channels

TOLD_DIGITS = 6  # of a move in µm: what is smaller is rounding
SIDES = (2.0, 5.0, 12.0)  # of windows, in reaches: one corner, an outline, a crowd
FEW = 16  # windows: larger ones would hardly be fewer


@dataclass(frozen=True, kw_only=True, eq=False)
class AberratedPlan:
    """A job with an aberrated lens.

    closed : what renders the round part;  short: the difference, None where that is nothing
    """

    job: Job
    closed: BoundaryPlan
    short: ShortImage | None

    @property
    def marks(self) -> Marks:
        """Where the round part changes its ways, and the difference ends."""
        marks = self.closed.marks
        return marks if self.short is None else dataclasses.replace(marks, reach=self.short.settings.near)

    @property
    def fewest(self) -> int:
        """As many as the round part."""
        return self.closed.fewest

    @property
    def nodes(self) -> Nodes:
        """Wavelengths of whichever part takes more."""
        if self.short is None or self.short.nodes.wavelength_nm.size <= self.closed.wavelengths:
            return self.closed.nodes
        return self.short.nodes

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @cached_property
    def counts(self) -> Counts | None:
        """What has to be done for the difference."""
        return None if self.short is None else short_counts(self.short)

    @property
    def cost(self) -> Cost:
        """What one image takes."""
        closed = self.closed.cost
        if self.counts is None:
            return closed
        short = short_cost(self.counts)
        return Cost(seconds=closed.seconds + short.seconds, memory_bytes=closed.memory_bytes + short.memory_bytes)

    @property
    def kept_seconds(self) -> float:
        """Of these what is kept for the next place's image: tables of the round part."""
        return self.closed.counts.table_seconds

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        work = self.closed.work(images)
        if self.counts is None:
            return work
        counts = self.counts
        return dataclasses.replace(
            work,
            wavelength_nodes=self.wavelengths,
            tables=work.tables + counts.responses,
            frequencies=work.frequencies + images * round(counts.windows * counts.frequencies),
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield how the lens is taken apart, and what its parts take."""
        job = self.job
        assert job.split is not None
        x_um, y_um = (round(own, TOLD_DIGITS) + 0.0 for own in job.split.moved_um)
        pattern = f"an {type(job.split.core).__name__} pattern" + f" moved by ({x_um:.3g}, {y_um:.3g}) µm" * bool(
            x_um or y_um
        )
        if self.short is None:
            yield Decision(
                topic="lens",
                decision=pattern,
                reason="its wavefront is plane",
            )
        else:
            yield Decision(
                topic="lens",
                decision=f"{pattern}, and what differs within {self.short.settings.reach:.3g} pitches",
                reason="far away the pattern of a round pupil is that of its rim, whatever the wavefront",
            )
            lines, windows, side = len(self.short.lines[1]), len(self.short.windows), self.short.settings.side
            yield Decision(
                topic="difference",
                decision=f"{lines} directions of lines, {windows} windows of {side} photosites along a side, "
                f"its patterns {self.short.pattern.transfers.made_over}",
                reason="photosites that see an end, or a short edge, take a transform; others near a line a look-up",
            )
        yield from self.closed.decisions()

    def of(self, job: Job) -> AberratedPlan:
        """Return the same settings and wavelengths for other edges."""
        closed, rest = job.round_part, _about_its_move(job)
        short = self.short
        if short is not None and rest is not None:
            short = dataclasses.replace(short, job=rest, nodes=rest.nodes_like(short.nodes))
        return AberratedPlan(job=job, closed=self.closed.of(closed), short=short)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image band by band."""
        if self.short is None:
            yield from self.closed.bands(channel, progress)
            return
        half = 0.5
        short = self.short.rendered(channel[:], lambda done: progress(half * done))
        closed = self.closed.bands(channel, lambda done: progress(half + half * done))
        yield from added([closed, iter((short,))])

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None


class Aberrated:
    """Lenses that are a round one, moved, and a short difference, on rectangular photosites."""

    def plan(self, job: Job, samples: int | None = None) -> AberratedPlan:
        """Choose settings and nodes; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("boundary takes none; only importance takes a number", key="samples")
        assert job.split is not None
        assert job.footprint is not None
        check_tolerance(job.tolerance, job.split.core.pattern(), CLOSED_PART)
        closed, rest_job = Boundary().plan(job.round_part), _about_its_move(job)
        rest = job.split.rest
        if rest is None or rest_job is None or not len(rest_job.edges):
            return AberratedPlan(job=job, closed=closed, short=None)
        return AberratedPlan(job=job, closed=closed, short=_short(rest_job, rest, job.footprint))


def _about_its_move(job: Job) -> Job | None:
    """Return the difference, whose pattern lies about its move, with the edges moved instead."""
    assert job.split is not None
    rest = job.difference_part()
    return None if rest is None else rest.moved(job.split.moved_um)


def _short(job: Job, rest: Difference, footprint: Footprint) -> ShortImage:
    """Return the difference's image with the windows that take least."""
    best: tuple[float, ShortImage] | None = None
    nodes = None
    for times in SIDES:
        settings = settings_of(job, rest, footprint.extent, times)
        if nodes is None:
            nodes = job.nodes(phase=_phase(job, settings.reach))
        image = ShortImage(job=job, rest=rest, nodes=nodes, settings=settings)
        seconds = short_cost(short_counts(image)).seconds
        if best is None or seconds < best[0]:
            best = seconds, image
        if len(image.windows) <= FEW:
            break
    assert best is not None
    return best[1]


def _phase(job: Job, reach: float) -> float:
    """Return by how much phases turn over the spectrum: of a ring at the reach, and of the wavefront itself."""
    rings = 2.0 * math.pi * min(reach, job.span) * float(1.0 / job.blur.min() - 1.0 / job.blur.max())
    return rings + wavefront_phase(job.system, job.signals.wavelength_nm)
