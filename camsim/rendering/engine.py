"""Protocols of an engine and its plan: the plan fixes all settings of a job, and its bands are the image."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from camsim.core.arrays import F64, I64, U8
from camsim.core.tiled import Channels
from camsim.errors import InvalidValueError
from camsim.rendering.job import Job
from camsim.rendering.work import Work

MEMORY_LIMIT_BYTES = 2e9  # of one engine's tables and transforms
SET_UP_SECONDS = 5e-3  # of any rendering
FEWEST_CHECKED = 8  # photosites, whatever their cost
FINEST = 1e-11  # tolerance that sums in double precision reach

Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Seconds of one core, summed over all threads, and bytes in addition to the program's.

    A pure function of the inputs: no clock, no core count, no history.
    """

    seconds: float
    memory_bytes: float


def too_much(what: str, memory_bytes: float) -> InvalidValueError:
    """Return the error for a method that would exceed the memory limit."""
    message = (
        f"{what} would take {memory_bytes / 1e9:.1f} GB for this frame and scene, and its limit is "
        f"{MEMORY_LIMIT_BYTES / 1e9:.1f} GB; render a smaller region, fewer colours, allow a larger tolerance, or take "
        "another method"
    )
    return InvalidValueError(message, key="method")


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """One decision made before a rendering, for reports.

    topic    : subject, a word or two
    decision : what is done or omitted
    reason   : why
    """

    topic: str
    decision: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Marks:
    """Where an engine switches methods: distances from an end and from a line, pitches, and the smallest tile.

    near, quiet : cutoff radii of an end: methods change at ``near`` and at ``quiet``
    reach       : the same for a line
    leaf, apart : photosites along the smallest tile, and the least distance from a source of one that is interpolated
    """

    near: float
    quiet: float
    reach: float
    leaf: int
    apart: float

    @classmethod
    def plain(cls, blur: float) -> Marks:
        """Return marks for a method that does not switch: a few λN from ends and lines."""
        return cls(near=5.0 * blur, quiet=20.0 * blur, reach=5.0 * blur, leaf=16, apart=16.0)


class Plan(Protocol):
    """A method with all settings, ready to render a job.

    job    : what is rendered
    marks  : where it switches methods, for the choice of photosites to check
    fewest : smallest number of photosites to check, whatever the cost
    """

    @property
    def job(self) -> Job: ...  # noqa: D102 (above)

    @property
    def marks(self) -> Marks: ...  # noqa: D102

    @property
    def fewest(self) -> int: ...  # noqa: D102

    @property
    def wavelengths(self) -> int:
        """Number of wavelengths at which the optics are computed."""
        ...

    @property
    def cost(self) -> Cost:
        """Expected cost of rendering the job once, without the check."""
        ...

    def work(self, images: int) -> Work:
        """Return the work that ``images`` images of the job's grid take."""
        ...

    def decisions(self) -> Iterator[Decision]:
        """Yield the decisions that are reported to the user."""
        ...

    def of(self, job: Job) -> Plan:
        """Return the same method with the same settings, for other edges of the same scene."""
        ...

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image in bands of rows from the top; ``channel`` gives the channel of each photosite."""
        ...

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn; channels: (images, rows, cols)."""
        ...

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return the largest standard error of these photosites; None for a deterministic method."""
        ...


def one_by_one(plan: Plan, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
    """Yield the bands of several images in turn, for a plan that gains nothing from computing them together."""
    for k, channel in enumerate(channels):
        yield plan.bands(channel, functools.partial(share, progress, k, len(channels)))


def added(each: Sequence[Iterator[F64]]) -> Iterator[F64]:
    """Yield the sum of images that come in bands of different heights; the first image's bands are overwritten."""
    rest: list[F64 | None] = [None] * len(each)
    while True:
        for k, bands in enumerate(each):
            if rest[k] is None:
                rest[k] = next(bands, None)
        held = [band for band in rest if band is not None]
        if len(held) < len(each):
            return
        rows = min(band.shape[-2] for band in held)
        total = held[0][..., :rows, :]
        for k in range(1, len(held)):
            total += held[k][..., :rows, :]
        rest = [band[..., rows:, :] if band.shape[-2] > rows else None for band in held]
        del held  # frees the bands before the next ones are computed
        yield total
        del total


def share(progress: Progress, number: int, count: int, done: float) -> None:
    """Report the progress of part ``number`` of ``count`` as a fraction of the whole."""
    progress((number + done) / count)


class Engine(Protocol):
    """Protocol of a rendering method, found by its name."""

    def plan(self, job: Job, samples: int | None = None) -> Plan:
        """Decide how a job is rendered; raises UnsupportedError for a job that the engine does not support."""
        ...
