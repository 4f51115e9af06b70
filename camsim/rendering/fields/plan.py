"""Edges and pictures as one plan: the sum of what an engine makes of the edges and the field engine of the pictures."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.rendering.engine import Cost, Decision, Marks, Plan, Progress, added
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.parts import FieldImages
from camsim.rendering.job import Job
from camsim.rendering.work import Work
from camsim.repeated import Channels

OF_EDGES = 0.3  # of the progress


@dataclass(frozen=True, kw_only=True, eq=False)
class WithPictures:
    """The plan of the edges, and the pictures of the same scene.

    tolerance : of both together
    """

    edges: Plan
    fields: FieldJob
    tolerance: float

    @cached_property
    def job(self) -> Job:
        """The edges', at the tolerance of the whole."""
        return dataclasses.replace(self.edges.job, tolerance=self.tolerance)

    @property
    def marks(self) -> Marks:
        """Those of the edges."""
        return self.edges.marks

    @property
    def fewest(self) -> int:
        """As many as the edges ask for."""
        return self.edges.fewest

    @cached_property
    def image(self) -> FieldImages:
        """What renders the pictures."""
        return self.fields.fused()

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes, of the one or the other."""
        return max(self.edges.wavelengths, self.image.wavelengths)

    @cached_property
    def _expected(self) -> tuple[Cost, float]:
        grid = self.fields.grid
        return self.image.expected(grid.first_centre, (grid.rows, grid.cols))

    @property
    def cost(self) -> Cost:
        """What both take, one after the other."""
        own, other = self._expected[0], self.edges.cost
        return Cost(seconds=own.seconds + other.seconds, memory_bytes=max(own.memory_bytes, other.memory_bytes))

    def work(self, images: int) -> Work:
        """Count the work of both."""
        grid, layers = self.fields.grid, self.fields.layers
        own = Work(
            samples_of_pictures=sum(layer.shape[0] * layer.shape[1] for layer in layers),
            frequencies=images * round(self._expected[1]),
        )
        edges = self.edges.work(images)
        nothing = len(self.edges.job.edges) == 0
        return dataclasses.replace(
            own + edges,
            channels=images,
            photosites=images * grid.rows * grid.cols,
            wavelength_nodes=self.image.wavelengths if nothing else edges.wavelength_nodes,
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield those of the edges, and how pictures and points are rendered."""
        yield from self.edges.decisions()
        kinds = {layer.kind for layer in self.fields.layers}
        topic = kinds.pop() if len(kinds) == 1 else "pictures"
        grid = self.fields.grid
        reach, *short = self.image.reach(grid.first_centre, (grid.rows, grid.cols))
        for layer in self.fields.layers:
            decision, reason = layer.said
            yield Decision(topic=layer.kind, decision=decision, reason=reason)
        yield Decision(
            topic=topic,
            decision=f"{self._expected[1]:.2g} frequencies",
            reason=f"the pattern as far as {reach.inner[0]:.3g} photosites; its smooth rest on a coarse lattice"
            if reach.far
            else "the whole of the pattern, as far as there is anything",
        )
        for own in short:
            yield Decision(
                topic=topic,
                decision=f"what the pattern differs by from a round one, as far as {max(own.inner):.3g} photosites",
                reason="far away the pattern of a round pupil is that of its rim, whatever the wavefront",
            )

    def of(self, job: Job) -> Plan:
        """Return the same method for other edges, without the pictures."""
        return self.edges.of(job)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image from the top, pictures and edges added as they come."""
        pictures = self.image.bands(self.fields.grid.first_centre, channel, progress)
        return added([pictures, self.edges.bands(channel, lambda done: None)])

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn; pictures are transformed once for all."""
        grid = self.fields.grid
        pictures = self.image.rendered(grid.first_centre, channels, lambda done: progress((1.0 - OF_EDGES) * done))
        edges = self.edges.images(channels, lambda done: progress(1.0 - OF_EDGES + OF_EDGES * done))
        for own, bands in zip(pictures, edges, strict=True):
            yield added([iter((own,)), bands])

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return that of the edges."""
        return self.edges.standard_error(rows, cols)
