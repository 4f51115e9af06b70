"""The boundary engine and its plan: settings, wavelengths, cost and bands."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

from camsim.core.arrays import F64, I64, U8, distinct
from camsim.core.cached import cached_property
from camsim.core.tiled import Channels
from camsim.errors import UnsupportedError
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.cost import Counts, boundary_cost, boundary_counts
from camsim.rendering.boundary.image import boundary_bands, directions
from camsim.rendering.boundary.settings import Settings, plan_boundary
from camsim.rendering.engine import FEWEST_CHECKED, Cost, Decision, Marks, Progress, one_by_one
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import multiples
from camsim.rendering.work import Work


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundaryPlan:
    """A job with a rotationally symmetric lens, and the settings for it.

    pattern   : pattern of the job's lens
    footprint : footprint of the job's photosite and OLPF
    """

    job: Job
    pattern: Pattern
    footprint: Footprint
    settings: Settings
    nodes: Nodes

    @property
    def marks(self) -> Marks:
        """The radii at which the plan's methods change."""
        settings = self.settings
        return Marks(
            near=settings.near,
            quiet=settings.near,
            reach=settings.reach,
            leaf=settings.leaf,
            apart=max(settings.near, settings.separation * 0.5 * settings.leaf),
        )

    @property
    def fewest(self) -> int:
        """The smallest number of photosites that the check recomputes."""
        return FEWEST_CHECKED

    @property
    def wavelengths(self) -> int:
        """Number of wavelengths at which the optics are computed."""
        return self.nodes.wavelength_nm.size

    @cached_property
    def tabled(self) -> int:
        """Number of pairs of spectra of which no two are proportional."""
        weights = self.nodes.weights
        return len(distinct(multiples(weights.reshape(len(weights), -1))[0]))

    @cached_property
    def lines(self) -> tuple[I64, F64]:
        """The index of each edge's response, and the normals of all responses; cost and image both use them."""
        settings = self.settings
        return directions(self.job.edges, self.job.grid, settings.near, settings.reach, self.footprint)

    @cached_property
    def counts(self) -> Counts:
        """Counts of the work for one image."""
        job = self.job
        return boundary_counts(
            job.edges,
            job.grid,
            self.settings,
            self.footprint,
            normals=len(self.lines[1]),
            sets=self.tabled * job.signals.scale.size,
            wavelengths=self.wavelengths,
        )

    @cached_property
    def cost(self) -> Cost:
        """Cost of one image."""
        return boundary_cost(self.counts)

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        counts = self.counts
        return Work(
            edges=len(self.job.edges),
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * int(counts.photosites),
            tables=counts.tables,
            table_values=round(counts.table_values),
            table_terms=round(counts.table_terms),
            nodes_integrated=images * round(counts.near_nodes),
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield the decisions on radii and tables that are reported to the user."""
        settings, counts = self.settings, self.counts
        yield Decision(
            topic="settings",
            decision=f"ends integrated within {settings.near:.3g} pitches, lines looked up within {settings.reach:.3g}",
            reason="beyond, the far form keeps its share of the tolerance",
        )
        yield Decision(
            topic="settings",
            decision=f"{counts.tables} tables, {counts.table_values:.2g} numbers",
            reason="fields and edge responses, one for each channel and pair of colours, of greys one for all",
        )

    def of(self, job: Job) -> BoundaryPlan:
        """Return a plan with the same settings and wavelengths for other edges."""
        return dataclasses.replace(self, job=job, nodes=job.nodes_like(self.nodes))

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image band by band."""
        row = 0
        for band in boundary_bands(
            self.job,
            pattern=self.pattern,
            footprint=self.footprint,
            nodes=self.nodes,
            settings=self.settings,
            lines=self.lines,
            channel=channel,
        ):
            row += len(band)
            yield band
            del band  # frees it before the next band is computed
            progress(row / len(channel))

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: the method is deterministic."""
        return None


class Boundary:
    """The exact boundary engine: rotationally symmetric lenses with rectangular photosites."""

    def plan(self, job: Job, samples: int | None = None) -> BoundaryPlan:
        """Choose settings and nodes; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("boundary takes none; only importance takes a number", key="samples")
        if job.pattern is None or job.footprint is None:
            raise UnsupportedError(job.unknown)
        settings = plan_boundary(job, job.pattern, job.footprint)
        phase = 2.0 * math.pi * min(settings.reach, job.span) * float(1.0 / job.blur.min() - 1.0 / job.blur.max())
        return BoundaryPlan(
            job=job,
            pattern=job.pattern,
            footprint=job.footprint,
            settings=settings,
            nodes=job.nodes(phase=phase),
        )
