"""What a method is once it is prepared for a job, and how far its image is from an independent one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.arrays import F64, I64, U8
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
        """What rendering the job once is expected to take."""
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

    def hardest(self) -> tuple[I64, I64]:
        """Return rows and columns of the photosites that are worth checking."""
        ...

    def reference(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets``, by a path that shares little with ``bands``."""
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


def compare(run: Run, values: F64, rows: I64, cols: I64, sets: U8) -> Found:
    """Compare an image's values at photosites with the reference."""
    difference = np.abs(values - run.reference(rows, cols, sets))
    worst = int(np.argmax(difference))
    return Found(
        error=float(difference[worst]),
        row=int(rows[worst]),
        col=int(cols[worst]),
        photosites=rows.size,
        standard_error=run.standard_error(rows, cols),
    )


def check(run: Run, image: F64, channel: U8) -> Found:
    """Compare an image at its hardest photosites."""
    rows, cols = run.hardest()
    return compare(run, image[rows, cols], rows, cols, channel[rows, cols])


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
        return Cost(seconds=1e-4 + 5e-9 * photosites, memory_bytes=8.0 * photosites)

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

    def hardest(self) -> tuple[I64, I64]:
        """Return the first photosite: all are alike."""
        return np.zeros(1, np.int64), np.zeros(1, np.int64)

    def reference(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Return the background once more."""
        values: F64 = self.job.base[sets]
        return values

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None
