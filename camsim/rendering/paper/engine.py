"""The paper's methods (rules.py) as plans, checked like those of all engines."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.tiled import Channels
from camsim.errors import UnsupportedError
from camsim.optics import EllipticalGaussian
from camsim.rendering.boundary.settings import check_tolerance
from camsim.rendering.engine import FEWEST_CHECKED, Cost, Decision, Marks, Progress, one_by_one
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job
from camsim.rendering.paper import rules
from camsim.rendering.work import Work

SECONDS_PER_CLIP = 4e-9  # of one square against one edge


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PaperPlan:
    """One of the paper's methods, for a job of one channel at one wavelength."""

    job: Job
    rule: rules.Rule

    @property
    def marks(self) -> Marks:
        """Plain marks: these methods add none."""
        return Marks.plain(float(self.job.blur.max()))

    @property
    def fewest(self) -> int:
        """The smallest number of photosites that the check recomputes."""
        return FEWEST_CHECKED

    @property
    def wavelengths(self) -> int:
        """1: these methods take one wavelength."""
        return 1

    @property
    def cost(self) -> Cost:
        """Cost of clipping every sample of every photosite against every edge."""
        photosites = float(self.job.grid.rows * self.job.grid.cols)
        clips = photosites * self.rule.samples * len(self.job.edges)
        return Cost(seconds=1e-3 + SECONDS_PER_CLIP * clips, memory_bytes=8.0 * photosites)

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        photosites = images * self.job.grid.rows * self.job.grid.cols
        return Work(
            edges=len(self.job.edges),
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=photosites,
            samples=photosites * self.rule.samples,
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield nothing: the rule is the one requested."""
        yield from ()

    def of(self, job: Job) -> PaperPlan:
        """Return a plan with the same samples for other edges."""
        return dataclasses.replace(self, job=job)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image as one band."""
        job = self.job
        yield self.rule.image(
            job.edges,
            self._contrast,
            float(job.base[0]),
            origin=job.grid.first_centre,
            shape=(channel.shape[0], channel.shape[1]),
        )
        progress(1.0)

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return the largest standard error of the mean of a photosite's samples; only for ``importance``.

        The samples are treated as random, as in the paper's analysis. Halton samples do better than that, and the error
        from cutting off the PSF is not included. The other methods have fixed rules without a standard error.
        """
        x0, y0 = self.job.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1)
        return self.rule.standard_error(self.job.edges, self._contrast, points)

    @property
    def _contrast(self) -> F64:
        """Left minus right of every edge."""
        density = self.job.signals.density[:, 0, 0]
        contrast: F64 = density[self.job.edges.left] - density[self.job.edges.right]
        return contrast


@dataclass(frozen=True, slots=True)
class Paper:
    """The engine for one of the paper's methods, by name."""

    method: str

    def plan(self, job: Job, samples: int | None = None) -> PaperPlan:
        """Build the method's rule for one wavelength and a rotationally symmetric lens (for strips, any Gaussian)."""
        turned = self.method == "strips" and isinstance(job.system.lens, EllipticalGaussian)
        if job.pattern is not None and job.footprint is not None:
            check_tolerance(job.tolerance, job.pattern)
        elif not turned:
            raise UnsupportedError(job.unknown)
        if job.signals.density.shape[1:] != (1, 1):
            raise UnsupportedError(
                f"{self.method} renders one wavelength at a time: use boundary, or camsim.render", key="method"
            )
        rule = rules.rule_of(
            self.method,
            job.system,
            blur=float(job.blur[0]),
            footprint=Footprint.of(job.system, job.grid.pitch_um),
            samples=samples,
        )
        return PaperPlan(job=job, rule=rule)
