"""What a method is once it is prepared for a job, and how far its image is from an independent one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.rendering.check.places import Marks
from camsim.rendering.cost import Cost
from camsim.rendering.job import Job
from camsim.rendering.work import Work

Progress = Callable[[float], None]
FLAT_ROWS = 256


class Run(Protocol):
    """A method that is ready to render a job."""

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        ...

    @property
    def cost(self) -> Cost:
        """What rendering the job once is expected to take, the check included."""
        ...

    @property
    def render_seconds(self) -> float:
        """What it is expected to take without the check."""
        ...

    def work(self, images: int) -> Work:
        """Return the work that ``images`` images of the job's grid take."""
        ...

    def of(self, job: Job) -> Run:
        """Return the same method with the same settings, for other edges of the same scene."""
        ...

    def bands(self, channel: U8, progress: Progress) -> Iterator[F64]:
        """Yield the image, each photosite in its own channel, from the top down in bands of rows."""
        ...

    @property
    def marks(self) -> Marks:
        """Where it changes its ways, for the check to look there."""
        ...

    @property
    def fewest(self) -> int:
        """How many photosites must be checked whatever it takes."""
        ...

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return what chance has left in the worst of these photosites, None for a method without chance."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """The worst of the photosites that were checked.

    error          : |image − reference| there, relative to the channel's full scale
    row, col       : where
    photosites     : how many were checked
    standard_error : see ``Run.standard_error``
    """

    error: float
    row: int
    col: int
    photosites: int
    standard_error: float | None = None


def plain_marks(blur: float) -> Marks:
    """Return the marks of a method without any: as far out as a few of the pattern's lengths."""
    return Marks(near=5.0 * blur, quiet=20.0 * blur, reach=5.0 * blur, leaf=16, apart=16.0)


def compare(job: Job, run: Run, values: F64, rows: I64, cols: I64, sets: U8) -> Found:
    """Compare an image's values at photosites with what the judge makes of them."""
    difference = np.abs(values - job.judge.values(rows, cols, sets))
    worst = int(np.argmax(difference))
    return Found(
        error=float(difference[worst]),
        row=int(rows[worst]),
        col=int(cols[worst]),
        photosites=rows.size,
        standard_error=run.standard_error(rows, cols),
    )


def hardest(job: Job, run: Run) -> tuple[I64, I64]:
    """Return the photosites that the check looks at."""
    return job.judge.photosites(run.render_seconds, run.marks, run.fewest)


def check(job: Job, run: Run, image: F64, channel: U8) -> Found:
    """Compare an image at its hardest photosites."""
    rows, cols = hardest(job, run)
    return compare(job, run, image[rows, cols], rows, cols, channel[rows, cols])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlatRun:
    """A scene without edges: the background, exactly, whatever the method."""

    job: Job

    @property
    def wavelengths(self) -> int:
        """No wavelength is blurred."""
        return 0

    @property
    def cost(self) -> Cost:
        """Filling an array."""
        photosites = self.job.grid.rows * self.job.grid.cols
        return Cost(seconds=self.render_seconds, memory_bytes=8.0 * photosites)

    @property
    def render_seconds(self) -> float:
        """A fill of an array."""
        return 1e-4 + 5e-9 * self.job.grid.rows * self.job.grid.cols

    def work(self, images: int) -> Work:
        """Return the work: photosites are filled, nothing is computed."""
        return Work(photosites=images * self.job.grid.rows * self.job.grid.cols, channels=images)

    def of(self, job: Job) -> FlatRun:
        """Return the background of another job."""
        return FlatRun(job=job)

    def bands(self, channel: U8, progress: Progress) -> Iterator[F64]:
        """Yield the background of each photosite's channel, some rows at a time."""
        for row in range(0, len(channel), FLAT_ROWS):
            yield self.job.base[channel[row : row + FLAT_ROWS]]
            progress(min(row + FLAT_ROWS, len(channel)) / len(channel))

    @property
    def marks(self) -> Marks:
        """Return marks that mean nothing: all photosites are alike."""
        return plain_marks(1.0)

    @property
    def fewest(self) -> int:
        """One."""
        return 1

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None
