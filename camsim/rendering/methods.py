"""The methods by name: each is prepared for a job, then renders it and checks what it rendered."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.errors import UnsupportedError
from camsim.rendering import sampled
from camsim.rendering.engine import boundary_bands
from camsim.rendering.footprint import Footprint
from camsim.rendering.hardest import hardest_photosites
from camsim.rendering.job import Job, Nodes
from camsim.rendering.patterns import Pattern
from camsim.rendering.plan import Settings, plan_boundary
from camsim.rendering.spotcheck import SHARE, Check, reference_values

Progress = Callable[[float], None]

FLAT_ROWS = 256


class Run(Protocol):
    """A method that is ready to render a job."""

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        ...

    def image(self, channel: U8, progress: Progress) -> F64:
        """Render every photosite in its own channel; ``progress`` is told the fraction done."""
        ...

    def check(self, image: F64, channel: U8) -> tuple[float, int]:
        """Return the worst error found and the number of photosites it was looked for at."""
        ...


@runtime_checkable
class BandedRun(Run, Protocol):
    """A method that finishes rows from the top down: no more than a band need be held."""

    def bands(self, channel: U8) -> Iterator[F64]:
        """Yield the image band by band."""
        ...

    def hardest(self) -> tuple[I64, I64]:
        """Return rows and columns of the photosites that the check looks at."""
        ...

    def compare(self, values: F64, rows: I64, cols: I64, sets: U8) -> tuple[float, int]:
        """Return what ``check`` does, of an image's ``values`` at those photosites, of channels ``sets``."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoundRun:
    """What all methods share that need a round lens; the check has nodes of its own."""

    job: Job
    pattern: Pattern
    footprint: Footprint
    settings: Settings
    nodes: Nodes
    check_nodes: Nodes

    @classmethod
    def prepare(cls, job: Job) -> RoundRun:
        """Choose settings and nodes."""
        if job.pattern is None or job.footprint is None:
            raise UnsupportedError(job.unknown)
        settings = plan_boundary(job.pattern, job.blur, job.shares, job.footprint, job.start, job.end, job.tolerance)
        phase = 2.0 * math.pi * settings.quiet_line * float(1.0 / job.blur.min() - 1.0 / job.blur.max())
        return cls(
            job=job,
            pattern=job.pattern,
            footprint=job.footprint,
            settings=settings,
            nodes=job.nodes(phase=phase, tolerance=job.tolerance),
            check_nodes=job.nodes(phase=phase, tolerance=SHARE * job.tolerance),
        )

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @property
    def _check(self) -> Check:
        job = self.job
        return Check.planned(self.pattern, job.blur, job.shares, self.footprint, self.settings.tolerance)

    def hardest(self) -> tuple[I64, I64]:
        """Return rows and columns of the photosites that the check looks at."""
        job = self.job
        return hardest_photosites(
            job.start,
            job.end,
            job.grid,
            self.settings,
            self._check,
            job.blur_at(self.nodes.wavelength_nm),
            len(job.sides),
        )

    def compare(self, values: F64, rows: I64, cols: I64, sets: U8) -> tuple[float, int]:
        """Compute those photosites again, by the path of ``spotcheck``; return the worst difference, and how many."""
        job = self.job
        x0, y0 = job.grid.first_centre
        reference = reference_values(
            np.stack([x0 + cols, y0 + rows], axis=1),
            sets.astype(np.int64),
            start=job.start,
            end=job.end,
            pair=job.pair,
            weights=self.check_nodes.weights,
            base=job.base,
            pattern=self.pattern,
            blur=job.blur_at(self.check_nodes.wavelength_nm),
            check=self._check,
        )
        return float(np.abs(values - reference).max()), rows.size

    def check(self, image: F64, channel: U8) -> tuple[float, int]:
        """Compute the hardest photosites again."""
        rows, cols = self.hardest()
        return self.compare(image[rows, cols], rows, cols, channel[rows, cols])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoundaryRun:
    """The exact boundary engine."""

    round: RoundRun

    @classmethod
    def prepare(cls, job: Job, samples: int | None) -> BoundaryRun:
        """Choose settings and nodes; ``samples`` must be None."""
        _refuse_samples("boundary", samples)
        return cls(round=RoundRun.prepare(job))

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.round.wavelengths

    def bands(self, channel: U8) -> Iterator[F64]:
        """Yield the image band by band."""
        run = self.round
        return boundary_bands(
            run.job,
            pattern=run.pattern,
            footprint=run.footprint,
            nodes=run.nodes,
            settings=run.settings,
            channel=channel,
        )

    def image(self, channel: U8, progress: Progress) -> F64:
        """Render the whole grid."""
        image, row = np.empty(channel.shape), 0
        for band in self.bands(channel):
            image[row : row + len(band)] = band
            row += len(band)
            progress(row / len(image))
        return image

    def hardest(self) -> tuple[I64, I64]:
        """Return rows and columns of the photosites that the check looks at."""
        return self.round.hardest()

    def compare(self, values: F64, rows: I64, cols: I64, sets: U8) -> tuple[float, int]:
        """Return the worst error at photosites, and their number."""
        return self.round.compare(values, rows, cols, sets)

    def check(self, image: F64, channel: U8) -> tuple[float, int]:
        """Compute the hardest photosites again."""
        return self.round.check(image, channel)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledRun:
    """One of the paper's methods."""

    round: RoundRun
    method: str
    samples: int | None

    @classmethod
    def preparing(cls, method: str) -> Callable[[Job, int | None], SampledRun]:
        """Return what prepares the method of this name."""
        return lambda job, samples: cls(round=RoundRun.prepare(job), method=method, samples=samples)

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.round.wavelengths

    def image(self, channel: U8, progress: Progress) -> F64:
        """Render the whole grid."""
        job, run = self.round.job, self.round
        if run.nodes.weights.shape[1:] != (1, 1):
            raise UnsupportedError(f"{self.method} renders one wavelength at a time: use boundary, or camsim.render")
        image = sampled.sampled_image(
            self.method,
            samples=self.samples,
            start=job.start,
            end=job.end,
            contrast=run.nodes.weights[job.pair, 0, 0],
            background=float(job.base[0]),
            system=job.system,
            blur=float(job.blur[0]),
            side=run.footprint.side,
            spots=run.footprint.spots,
            origin=job.grid.first_centre,
            shape=(channel.shape[0], channel.shape[1]),
        )
        progress(1.0)
        return image

    def check(self, image: F64, channel: U8) -> tuple[float, int]:
        """Compute the hardest photosites again."""
        return self.round.check(image, channel)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlatRun:
    """A scene without edges: the background, exactly, whatever the method."""

    job: Job

    @property
    def wavelengths(self) -> int:
        """No wavelength is blurred."""
        return 0

    def bands(self, channel: U8) -> Iterator[F64]:
        """Yield the background of each photosite's channel, some rows at a time."""
        for row in range(0, len(channel), FLAT_ROWS):
            yield self.job.base[channel[row : row + FLAT_ROWS]]

    def image(self, channel: U8, progress: Progress) -> F64:
        """Return the background of each photosite's channel."""
        progress(1.0)
        return self.job.base[channel]

    def hardest(self) -> tuple[I64, I64]:
        """Return no photosites."""
        return np.empty(0, np.int64), np.empty(0, np.int64)

    def compare(self, values: F64, rows: I64, cols: I64, sets: U8) -> tuple[float, int]:
        """Return no error."""
        return 0.0, self.job.grid.rows * self.job.grid.cols

    def check(self, image: F64, channel: U8) -> tuple[float, int]:
        """Return no error: nothing was computed that could be wrong."""
        return 0.0, image.size


def _refuse_samples(method: str, samples: int | None) -> None:
    if samples is not None:
        raise UnsupportedError(f"samples: {method} takes none; only importance takes a number")


METHODS: dict[str, Callable[[Job, int | None], Run]] = {
    "boundary": BoundaryRun.prepare,
    **{method: SampledRun.preparing(method) for method in sampled.METHODS},
}
"""What prepares each method."""


def prepare(method: str, job: Job, samples: int | None) -> Run:
    """Prepare a method for a job; what it cannot render it refuses, even where there is nothing to render."""
    run = METHODS[method](job, samples)
    return run if job.edges else FlatRun(job=job)
