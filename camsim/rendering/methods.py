"""The methods by name, and what prepares each for a job."""

from __future__ import annotations

from collections.abc import Callable

from camsim.rendering import sampled
from camsim.rendering.by_boundary import BoundaryRun
from camsim.rendering.by_fourier import FourierRun
from camsim.rendering.by_samples import SampledRun
from camsim.rendering.job import Job
from camsim.rendering.run import Run

METHODS: dict[str, Callable[[Job, int | None], Run]] = {
    "boundary": BoundaryRun.prepare,
    "fourier": FourierRun.prepare,
    **{method: SampledRun.preparing(method) for method in sampled.METHODS},
}
