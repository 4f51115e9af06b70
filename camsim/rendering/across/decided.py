"""What the plans of lenses that change over the frame say alike."""

from __future__ import annotations

from collections.abc import Iterator

from camsim.rendering.engine import Decision
from camsim.rendering.job import Job


def bent_sides(job: Job) -> Iterator[Decision]:
    """Yield what distortion makes of edges."""
    if job.bending is not None:
        yield Decision(
            topic="distortion",
            decision=f"{len(job.edges)} straight sides",
            reason="edges are mapped before they are blurred, and cut until no photosite can tell them from curves",
        )
