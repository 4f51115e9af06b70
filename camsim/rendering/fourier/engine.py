"""The Fourier engine as a plan: wavelengths, sizes, cost, one band."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.errors import UnsupportedError
from camsim.kept import cached_property
from camsim.optics.difference import RoundDifference
from camsim.rendering.budget import CLOSED_PART
from camsim.rendering.engine import (
    FEWEST_CHECKED,
    MEMORY_LIMIT_BYTES,
    SET_UP_SECONDS,
    Cost,
    Decision,
    Marks,
    Progress,
)
from camsim.rendering.fourier.image import FourierImage
from camsim.rendering.fourier.loudness import Loudness
from camsim.rendering.fourier.nodes import heard_from, nodes_of
from camsim.rendering.fourier.prices import PER_FIELD_POINT, PER_POINT_WEIGHT, PER_PUPIL_SAMPLE, PER_ROUND_POINT
from camsim.rendering.fourier.rim import RimLight
from camsim.rendering.fourier.spikes import Spikes
from camsim.rendering.fourier.task import FINEST, SAMPLES_OF_POINT, check_tolerance
from camsim.rendering.fourier.together import Part, Sum
from camsim.rendering.fourier.ways import Way, as_in, ways_of
from camsim.rendering.hearing import Listening
from camsim.rendering.job import Job, Nodes
from camsim.rendering.work import Work
from camsim.repeated import Channels


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierPlan:
    """A job with any lens and any photosite, and the wavelengths that it takes.

    listening : who tells what is heard of rings
    parts : a lens's round part and its short difference, where these take less than all of it at once
    undivided : a like job's image is not taken apart by distance or place, so nor is this one
    over_rectangle : a round pattern is taken over a rectangle
    """

    job: Job
    nodes: Nodes
    listening: Listening
    parts: tuple[FourierPlan, ...] = ()
    undivided: bool = False
    over_rectangle: bool = False

    @property
    def way(self) -> Way:
        """How its pattern is taken."""
        return Way(self.job, self.over_rectangle)

    @property
    def marks(self) -> Marks:
        """None of its own."""
        return Marks.plain(float(self.job.blur.max()))

    @property
    def fewest(self) -> int:
        """As many as of closed forms: a transform's own errors are everywhere, but those of outlines are not."""
        return FEWEST_CHECKED

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @cached_property
    def image(self) -> FourierImage | Sum:
        """What transforms."""
        return Sum(parts=tuple(part.whole for part in self.parts)) if self.parts else self.whole

    @cached_property
    def whole(self) -> FourierImage:
        """What transforms all of the lens at once."""
        job, until = self.job, self.listening.until
        return FourierImage(
            edges=job.edges,
            density=self.nodes.density,
            base=job.base,
            wavelength_nm=self.nodes.wavelength_nm,
            system=job.system,
            pitch_um=job.grid.pitch_um,
            tolerance=job.tolerance,
            rings_until=job.rings_until,
            hearing=self.listening.sides,
            quiet=None if until is None else functools.cache(functools.partial(until, job)),
            undivided=self.undivided,
            over_rectangle=self.over_rectangle,
        )

    @property
    def _divided(self) -> tuple[Part, ...]:
        """Parts by distance or by place of all of the lens."""
        grid = self.job.grid
        return self.whole.parts(grid.first_centre, (grid.rows, grid.cols))

    @cached_property
    def _expected(self) -> tuple[Cost, float]:
        grid = self.job.grid
        return self.image.expected(grid.first_centre, (grid.rows, grid.cols))

    @property
    def cost(self) -> Cost:
        """What one image takes."""
        cost = self._expected[0]
        return Cost(seconds=SET_UP_SECONDS + cost.seconds, memory_bytes=cost.memory_bytes)

    @property
    def _frequencies(self) -> int:
        return round(self._expected[1])

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        grid = self.job.grid
        return Work(
            edges=len(self.job.edges),
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * grid.rows * grid.cols,
            frequencies=images * self._frequencies,
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield whether lens and scenery are taken apart, and how many frequencies there are."""
        if self.parts:
            curve = ", round as well: a curve of frequencies" if self.parts[-1].way.curve else ""
            yield Decision(
                topic="lens",
                decision=f"a round pattern, and what differs from it{curve}"
                if len(self.parts) > 1
                else "a round pattern",
                reason="each by itself takes less: the difference is short" if len(self.parts) > 1 else "plane waves",
            )
        if any(part.over_rectangle for part in self.parts or (self,)):
            yield Decision(
                topic="lens",
                decision="its pattern over a rectangle",
                reason="a circle as far as the farthest edge would take longer",
            )
        if self.parts and (way := self.parts[-1]._divided) and isinstance(rim := way[-1], RimLight):
            yield Decision(
                topic="scenery",
                decision=f"what differs from {rim.hem.inner:.3g} photosites on by the light of the pupil's rim",
                reason="its rings stay within the tolerance there: what is between them is integrated edge by edge",
            )
        apart = () if self.parts else self._divided
        if apart and isinstance(far := apart[-1], Spikes):
            yield Decision(
                topic="scenery",
                decision=f"along {far.count} spikes from {far.hem.inner:.3g} photosites on",
                reason="straight sides of a pupil throw far light along their normals: it is integrated edge by edge",
            )
        elif apart and isinstance(near := apart[0], FourierImage) and near.islands > 1:
            yield Decision(
                topic="scenery",
                decision=f"in {near.islands} islands, each through its own part of the pattern",
                reason="a pattern out to the farthest edge, all round, would take longer",
            )
        elif apart:
            yield Decision(
                topic="scenery",
                decision=f"by distance, on {len(apart)} lattices",
                reason="what is far is smooth, and its rings stay within the tolerance",
            )
        yield Decision(
            topic="settings",
            decision=f"{self._frequencies:.2g} frequencies",
            reason="a period and a taper wide enough that nothing wraps round within the tolerance",
        )

    def of(self, job: Job) -> FourierPlan:
        """Return the same wavelengths for other edges."""
        job, own = as_in(job, self.way).job, [job.round_part, job.difference_part()] if self.parts else []
        parts = tuple(part.of(one) for part, one in zip(self.parts, own, strict=False) if one is not None)
        return dataclasses.replace(self, job=job, nodes=job.nodes_like(self.nodes), parts=parts)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image as one band: its last row is known no sooner than its first."""
        yield self._rendered(channel[:], progress)

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield several images, each as one band: edges and lens are transformed once for all."""
        for image in self._rendered(channels, progress):
            yield iter((image,))

    def _rendered(self, channels: U8, progress: Progress) -> F64:
        values = self.image.rendered(self.job.grid.first_centre, channels, progress)
        # A check that follows needs the memory of what was made of the lens.
        for plan in (self, *self.parts):
            plan.__dict__.pop("image", None)
            plan.__dict__.pop("whole", None)
        return values

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None


class Fourier:
    """The exact Fourier engine: any lens, any photosite."""

    finest = FINEST

    def plan(self, job: Job, samples: int | None = None) -> FourierPlan:
        """Choose nodes; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("fourier takes none; only importance takes a number", key="samples")
        check_tolerance(job.tolerance)
        return self._planned(job, Listening(heard_from if job.pattern is not None else None, Loudness.of))

    def plan_like(self, job: Job, plan: FourierPlan) -> FourierPlan:
        """Choose nodes; taken apart where and as a like job's plan is, which is not found out again."""
        return self._planned(job, plan.listening, like=plan)

    def _planned(self, job: Job, listening: Listening, like: FourierPlan | None = None) -> FourierPlan:
        if like is not None:
            return self._of(as_in(job, like.way), listening, like)
        return min((self._of(way, listening, None) for way in ways_of(job)), key=_taken)

    def _of(self, way: Way, listening: Listening, like: FourierPlan | None) -> FourierPlan:
        job = way.job
        as_whole = like is not None and not like.parts
        undivided = like is not None and as_whole and not like._divided
        whole = FourierPlan(
            job=job, nodes=nodes_of(job), listening=listening,
            undivided=undivided, over_rectangle=way.over_rectangle,
        )  # fmt: skip
        fine = min(CLOSED_PART, 1.0 - CLOSED_PART) * job.tolerance < FINEST
        if as_whole or job.split is None or not len(job.edges) or fine:
            return whole
        own, likes = (job.round_part, job.difference_part()), (None, None) if like is None else (*like.parts, None)
        pairs = zip(own, likes, strict=False)
        parts = tuple(self._planned(one, listening, as_that) for one, as_that in pairs if one is not None)
        apart = dataclasses.replace(whole, parts=parts)
        if like is not None:
            return apart
        return min(whole, apart, key=_taken)

    def windows(self, job: Job, listening: Listening) -> FourierImage | Sum:
        """Return what renders windows of a job; what is heard of rings whoever asks tells."""
        check_tolerance(job.tolerance)
        return self._planned(job, listening).image

    def least_seconds(self, job: Job) -> float:
        """Return what a plan is sure to take, without one: the band's frequencies of the smallest period there can be.

        That is as long as the farthest that a photosite lies from an edge of the frame's own.
        """
        grid = job.grid
        size = np.array([grid.cols - 1.0, grid.rows - 1.0])
        low, high = (np.clip(corner - grid.first_centre, 0.0, size) for corner in job.edges.box)
        period = np.maximum(high, size - low)
        ends_nm = job.signals.wavelength_nm[[0, -1]]
        band = job.system.highest_per_um(ends_nm) * grid.pitch_um
        count = 0.5 * math.pi * band * band * float(np.prod(period))
        per_point: float = PER_ROUND_POINT + job.signals.density.shape[1] * PER_POINT_WEIGHT
        if job.split is not None and job.split.rest is not None and not isinstance(job.split.rest, RoundDifference):
            # Together or apart, there is a pattern that is not round to be made as finely as the band asks.
            per_point += PER_FIELD_POINT + PER_PUPIL_SAMPLE * SAMPLES_OF_POINT
        return SET_UP_SECONDS + count * per_point


def _taken(plan: FourierPlan) -> tuple[bool, float]:
    """Return what plans are chosen by: that they fit, and seconds."""
    return plan.cost.memory_bytes > MEMORY_LIMIT_BYTES, plan.cost.seconds
