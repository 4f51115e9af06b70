"""The paper's methods (sampled.py), prepared for a job and checked like all others."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.errors import UnsupportedError
from camsim.optics import EllipticalGaussian
from camsim.rendering import sampled
from camsim.rendering.by_boundary import RoundLens
from camsim.rendering.by_fourier import FourierRun
from camsim.rendering.check.places import FEWEST, Marks
from camsim.rendering.cost import Cost
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job
from camsim.rendering.run import Progress, plain_marks
from camsim.rendering.work import Work

SECONDS_PER_CLIP = 4e-9  # of one square against one edge


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledRun:
    """One of the paper's methods.

    lens : the job, as the boundary engine takes it; as the Fourier engine does where the lens is not round
    """

    lens: RoundLens | FourierRun
    rule: sampled.Rule

    @classmethod
    def preparing(cls, method: str) -> Callable[[Job, int | None], SampledRun]:
        """Return what prepares the method of this name."""

        def prepare(job: Job, samples: int | None) -> SampledRun:
            lens: RoundLens | FourierRun
            if method == "strips" and isinstance(job.system.lens, EllipticalGaussian):
                lens = FourierRun.prepare(job, None)
            else:
                lens = RoundLens.prepare(job)
            if lens.nodes.weights.shape[1:] != (1, 1):
                raise UnsupportedError(f"{method} renders one wavelength at a time: use boundary, or camsim.render")
            rule = sampled.rule_of(
                method,
                job.system,
                blur=float(job.blur[0]),
                footprint=Footprint.of(job.system, job.grid.pitch_um),
                samples=samples,
            )
            return cls(lens=lens, rule=rule)

        return prepare

    @property
    def wavelengths(self) -> int:
        """One."""
        return self.lens.nodes.wavelength_nm.size

    @property
    def cost(self) -> Cost:
        """Every sample of every photosite is clipped against every edge."""
        grid = self.lens.job.grid
        photosites = float(grid.rows * grid.cols)
        return Cost(seconds=self.render_seconds, memory_bytes=8.0 * photosites)

    @property
    def render_seconds(self) -> float:
        """Every sample of every photosite is clipped against every edge."""
        grid = self.lens.job.grid
        return 1e-3 + SECONDS_PER_CLIP * grid.rows * grid.cols * self.rule.samples * self.lens.job.edges

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        photosites = images * self.lens.job.grid.rows * self.lens.job.grid.cols
        return Work(
            edges=self.lens.job.edges,
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=photosites,
            samples=photosites * self.rule.samples,
        )

    def of(self, job: Job) -> SampledRun:
        """Return the same samples for other edges."""
        return dataclasses.replace(self, lens=self.lens.of(job))

    def bands(self, channel: U8, progress: Progress) -> Iterator[F64]:
        """Yield the image as one band."""
        job = self.lens.job
        yield self.rule.image(
            job.start,
            job.end,
            self._contrast,
            float(job.base[0]),
            origin=job.grid.first_centre,
            shape=(channel.shape[0], channel.shape[1]),
        )
        progress(1.0)

    @property
    def marks(self) -> Marks:
        """None of its own."""
        return plain_marks(float(self.lens.job.blur.max()))

    @property
    def fewest(self) -> int:
        """A few whatever they take."""
        return FEWEST

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return the largest standard error of the mean of a photosite's samples; of ``importance`` only.

        It takes them for random, which is what the paper's analysis does; Halton's do better than that, and it does not
        see that the pattern is cut off. The other methods have fixed rules whose error no spread of values tells.
        """
        x0, y0 = self.lens.job.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1)
        return self.rule.standard_error(self.lens.job.start, self.lens.job.end, self._contrast, points)

    @property
    def _contrast(self) -> F64:
        contrast: F64 = self.lens.nodes.weights[self.lens.job.pair, 0, 0]
        return contrast
