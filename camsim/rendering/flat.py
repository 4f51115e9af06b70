"""A scene without edges: the background, exactly, whatever the method."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from camsim.core.arrays import F64, I64, U8
from camsim.core.tiled import Channels
from camsim.rendering.engine import Cost, Decision, Marks, Progress, one_by_one
from camsim.rendering.job import Job
from camsim.rendering.work import Work

ROWS = 256  # of a band


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlatPlan:
    """The plan of a scene without edges: an array of the background's values."""

    job: Job

    @property
    def marks(self) -> Marks:
        """Marks of no importance, as all photosites are equal."""
        return Marks.plain(1.0)

    @property
    def fewest(self) -> int:
        """1: a single photosite is checked."""
        return 1

    @property
    def wavelengths(self) -> int:
        """0: no wavelength is blurred."""
        return 0

    @property
    def cost(self) -> Cost:
        """Cost of filling an array."""
        photosites = self.job.grid.rows * self.job.grid.cols
        return Cost(seconds=1e-4 + 5e-9 * photosites, memory_bytes=8.0 * photosites)

    def work(self, images: int) -> Work:
        """Return the work: photosites only."""
        return Work(photosites=images * self.job.grid.rows * self.job.grid.cols, channels=images)

    def decisions(self) -> Iterator[Decision]:
        """Yield nothing: there is nothing to decide."""
        yield from ()

    def of(self, job: Job) -> FlatPlan:
        """Return the background of another job."""
        return FlatPlan(job=job)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the background of each photosite's channel, some rows at a time."""
        for row in range(0, len(channel), ROWS):
            yield self.job.base[channel[row : row + ROWS]]
            progress(min(row + ROWS, len(channel)) / len(channel))

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: the method is deterministic."""
        return None
