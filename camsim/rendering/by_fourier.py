"""The Fourier engine (fourier.py), prepared for a job; what judges it."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.errors import UnsupportedError
from camsim.optics import OpticalSystem
from camsim.rendering.check.places import Marks
from camsim.rendering.cost import SET_UP_SECONDS, Cost
from camsim.rendering.footprint import Footprint
from camsim.rendering.fourier import check_tolerance, fourier_cost, fourier_image
from camsim.rendering.job import Job, Nodes
from camsim.rendering.patterns import AIRY
from camsim.rendering.plan import quiet_distance
from camsim.rendering.run import Progress, plain_marks
from camsim.rendering.work import Work

FEWEST = 2  # photosites that are checked singly: a transform's errors are everywhere, no photosite is a case of its own


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierRun:
    """Any lens and any photosite."""

    job: Job
    nodes: Nodes

    @classmethod
    def prepare(cls, job: Job, samples: int | None) -> FourierRun:
        """Choose nodes; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("samples: fourier takes none; only importance takes a number")
        check_tolerance(job.tolerance)
        return cls(job=job, nodes=_nodes(job))

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @property
    def cost(self) -> Cost:
        """What one image takes, the check included."""
        seconds, memory_bytes, _ = self._expected
        return Cost(
            seconds=SET_UP_SECONDS + seconds + self.job.judge.seconds(seconds, FEWEST), memory_bytes=memory_bytes
        )

    @property
    def render_seconds(self) -> float:
        """What one image takes without the check."""
        return self._expected[0]

    @functools.cached_property
    def _expected(self) -> tuple[float, float, float]:
        job, grid = self.job, self.job.grid
        return fourier_cost(
            start=job.start,
            end=job.end,
            density=self.nodes.density,
            wavelength_nm=self.nodes.wavelength_nm,
            system=job.system,
            pitch_um=grid.pitch_um,
            origin=grid.first_centre,
            channel=np.broadcast_to(np.uint8(0), (grid.rows, grid.cols)),
            tolerance=job.tolerance,
        )

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        grid = self.job.grid
        return Work(
            edges=self.job.edges,
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * grid.rows * grid.cols,
            frequencies=images * round(self._expected[2]),
        )

    def of(self, job: Job) -> FourierRun:
        """Return the same wavelengths for other edges."""
        return FourierRun(job=job, nodes=job.nodes_like(self.nodes))

    def bands(self, channel: U8, progress: Progress) -> Iterator[F64]:
        """Yield the image as one band: its last row is known no sooner than its first."""
        yield self.image(self.job.grid.first_centre, channel, progress)

    @property
    def marks(self) -> Marks:
        """None of its own."""
        return plain_marks(float(self.job.blur.max()))

    @property
    def fewest(self) -> int:
        """A few whatever they take."""
        return FEWEST

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None

    def image(self, origin: tuple[float, float], channel: U8, progress: Progress) -> F64:
        """Return the photosites from ``origin`` (pitches, the first one's centre) on."""
        job = self.job
        return fourier_image(
            start=job.start,
            end=job.end,
            left=job.left,
            right=job.right,
            density=self.nodes.density,
            base=job.base,
            wavelength_nm=self.nodes.wavelength_nm,
            system=job.system,
            pitch_um=job.grid.pitch_um,
            origin=origin,
            channel=channel,
            tolerance=job.tolerance,
            progress=progress,
        )


def _nodes(job: Job) -> Nodes:
    """Return wavelengths that follow the rings of the spectrum as far as these are heard.

    Farther out they need not be right, but must be as quiet: a few wavelengths come back into step where the spectrum
    does not, and then more are taken. A lens that is not round is taken for an Airy pattern of the same width on a
    point: no pupil's rings exceed those by much.
    """
    blur, span, allowed = job.blur, job.span, job.budget.allowed("rings")
    if job.pattern is not None and job.footprint is not None:
        pattern, footprint = job.pattern, job.footprint
    else:
        pattern, footprint = AIRY, Footprint.of(OpticalSystem(lens=job.system.lens), job.grid.pitch_um)
    spread = 2.0 * math.pi * float(1.0 / blur.min() - 1.0 / blur.max())
    followed = quiet_distance(pattern, blur, job.shares, footprint, allowed, front="line", within=span)
    while True:
        nodes = job.nodes(phase=spread * followed)
        count = nodes.wavelength_nm.size
        if count == blur.size or followed >= span:
            return nodes
        shares, at_nodes = nodes.weights.reshape(-1, count), job.blur_at(nodes.wavelength_nm)
        heard = quiet_distance(pattern, at_nodes, shares, footprint, allowed, front="line", within=span)
        if heard <= followed:
            return nodes
        followed = min(1.4 * followed, span)
