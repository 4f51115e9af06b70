"""The boundary engine as a method, and what all methods share that need a round lens: settings and nodes."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from camsim.arrays import F64, I64, U8
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.rendering.check.places import FEWEST, Marks
from camsim.rendering.cost import MEMORY_LIMIT_BYTES, Cost, Counts, boundary_cost, boundary_counts
from camsim.rendering.engine import boundary_bands
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job, Nodes
from camsim.rendering.patterns import Pattern
from camsim.rendering.plan import Settings, plan_boundary
from camsim.rendering.run import Progress
from camsim.rendering.work import Work


@dataclass(frozen=True, kw_only=True, eq=False)
class RoundLens:
    """A job with a round lens, and what the boundary engine needs for it."""

    job: Job
    pattern: Pattern
    footprint: Footprint
    settings: Settings
    nodes: Nodes

    @classmethod
    def prepare(cls, job: Job) -> RoundLens:
        """Choose settings and nodes."""
        if job.pattern is None or job.footprint is None:
            raise UnsupportedError(job.unknown)
        settings = plan_boundary(
            job.pattern, job.blur, job.shares, job.footprint, job.start, job.end, job.grid, job.tolerance
        )
        phase = 2.0 * math.pi * min(settings.quiet_line, job.span) * float(1.0 / job.blur.min() - 1.0 / job.blur.max())
        return cls(
            job=job,
            pattern=job.pattern,
            footprint=job.footprint,
            settings=settings,
            nodes=job.nodes(phase=phase),
        )

    def of(self, job: Job) -> RoundLens:
        """Return the same settings and wavelengths for other edges."""
        return dataclasses.replace(self, job=job, nodes=job.nodes_like(self.nodes))

    @functools.cached_property
    def counts(self) -> Counts:
        """What the boundary engine has to do for one image."""
        job = self.job
        return boundary_counts(
            job.start,
            job.end,
            job.grid,
            self.settings,
            self.footprint,
            sets=len(job.sides) * job.signals.scale.size,
            wavelengths=self.nodes.wavelength_nm.size,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoundaryRun:
    """The exact boundary engine."""

    lens: RoundLens

    @classmethod
    def prepare(cls, job: Job, samples: int | None) -> BoundaryRun:
        """Choose settings and nodes; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("samples: boundary takes none; only importance takes a number")
        return cls(lens=RoundLens.prepare(job))

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.lens.nodes.wavelength_nm.size

    @property
    def cost(self) -> Cost:
        """What one image takes, the check included."""
        checking = self.lens.job.judge.seconds(self.render_seconds, FEWEST)
        return boundary_cost(self.lens.counts, check_seconds=checking)

    @property
    def render_seconds(self) -> float:
        """What one image takes without the check."""
        return boundary_cost(self.lens.counts, check_seconds=0.0).seconds

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        counts = self.lens.counts
        return Work(
            edges=self.lens.job.edges,
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * int(counts.photosites),
            tables=counts.tables,
            table_values=round(counts.table_values),
            table_terms=round(counts.table_terms),
            nodes_integrated=images * round(counts.near_nodes),
        )

    def of(self, job: Job) -> BoundaryRun:
        """Return the same settings for other edges."""
        return BoundaryRun(lens=self.lens.of(job))

    def bands(self, channel: U8, progress: Progress) -> Iterator[F64]:
        """Yield the image band by band; raises InvalidValueError where the tables would take too much memory."""
        lens, row = self.lens, 0
        table_bytes = 8.0 * lens.counts.table_values
        if table_bytes > MEMORY_LIMIT_BYTES:
            raise InvalidValueError(
                f"method: boundary would take {table_bytes / 1e9:.1f} GB for its tables, and its limit is "
                f"{MEMORY_LIMIT_BYTES / 1e9:.1f} GB; allow a larger tolerance, fewer colours, or use fourier"
            )
        for band in boundary_bands(
            lens.job,
            pattern=lens.pattern,
            footprint=lens.footprint,
            nodes=lens.nodes,
            settings=lens.settings,
            channel=channel,
        ):
            row += len(band)
            yield band
            del band  # or it would stay until the next one is finished
            progress(row / len(channel))

    @property
    def marks(self) -> Marks:
        """The radii of the plan."""
        settings = self.lens.settings
        return Marks(
            near=settings.near,
            quiet=settings.quiet_end,
            reach=settings.reach,
            leaf=settings.leaf,
            apart=max(settings.near, settings.separation * 0.5 * settings.leaf),
        )

    @property
    def fewest(self) -> int:
        """A few whatever they take."""
        return FEWEST

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None
