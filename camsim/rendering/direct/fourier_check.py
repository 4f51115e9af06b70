"""The check of images whose lens has no round PSF: frequency sums once more, photosite by photosite, set otherwise.

Every photosite is a window of its own: other periods, levels, transfer tables and wavelengths than the image has, and
a tenth of its tolerance.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.cached import cached_property
from camsim.numerics.quadrature import GOLDEN
from camsim.optics.of_pupil import OfPupil
from camsim.rendering.direct.checks import Found
from camsim.rendering.engine import FINEST, MEMORY_LIMIT_BYTES, Plan
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job
from camsim.rendering.waves.image import FrequencyImage
from camsim.rendering.waves.plan import Waves, WavesPlan
from camsim.scene import Scene

OF_TOLERANCE = 0.1  # that the check may be wrong by
COARSER, LONGEST = (0.3, 1.0), 5.0  # likewise, where memory does not hold that, or it takes so many seconds
FARTHER, FINER = 1.37, 1.13  # times: the first level's reach, and the wavelengths, beside the image's
STEEP = 0.6  # waves across a pupil, from which on a second table of transfers takes too long
MANY = 5_000  # edges whose transforms are not made twice
COUNT = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierCheck:
    """What recomputes photosites of a job.

    scene  : all of it;  fields: its pictures, gradients and points
    like   : the image's plan, whose sources and wavelengths serve again where there are many edges, or pictures
    """

    job: Job
    scene: Scene
    fields: FieldJob | None = None
    like: WavesPlan | None = None

    @property
    def _again(self) -> bool:
        """Whether the image's sources serve again."""
        return self.like is not None and (self.fields is not None or len(self.job.edges) > MANY)

    @cached_property
    def _image(self) -> FrequencyImage:
        image = self.plan.image
        assert image is not None
        if self._again and self.like is not None and self.like.image is not None:
            return dataclasses.replace(image, sources=self.like.image.sources)
        return image

    @cached_property
    def plan(self) -> WavesPlan:
        """What is summed once more, more roughly where it would take too much memory."""
        plan = self._planned(OF_TOLERANCE)
        for share in COARSER:
            if plan.cost.memory_bytes <= MEMORY_LIMIT_BYTES and plan.cost.seconds <= LONGEST:
                break
            plan = self._planned(share)
        return plan

    def _planned(self, share: float) -> WavesPlan:
        lens = self.job.system.lens
        tolerance = max(share * self.job.tolerance, FINEST)
        job = dataclasses.replace(self.job, tolerance=tolerance)
        fields = self.fields
        if fields is not None:
            fields = dataclasses.replace(fields, tolerance=max(share * fields.tolerance, FINEST))
        if self._again or (
            isinstance(lens, OfPupil)
            and (
                lens.pupil.shape != "circular" or lens.waves_across(float(self.job.signals.wavelength_nm.min())) > STEEP
            )
        ):
            return Waves(farther=FARTHER, rougher=1.0 / share).plan(job, fields=fields)
        return Waves(farther=FARTHER, finer=FINER).plan(job, fields=fields)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at."""
        if self._nothing:
            return np.zeros(1, np.int64), np.zeros(1, np.int64)
        return hardest_of(self.job, COUNT)

    @property
    def _nothing(self) -> bool:
        return not len(self.job.edges) and self.fields is None

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        return 0.0 if self._nothing else 0.1 * plan.cost.seconds

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        values: F64 = self.job.base[sets]
        if self._nothing:
            return values
        grid = self.job.grid
        found = self._image.at(grid.first_centre, (grid.rows, grid.cols), rows, cols)
        values += np.take_along_axis(found, sets.reshape(-1, rows.size), axis=0).reshape(sets.shape)
        return values

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        difference = np.where(np.isnan(values - right), np.inf, np.abs(values - right))
        worst = int(np.argmax(difference))
        return Found(
            error=float(difference[worst]),
            row=int(rows[worst]),
            col=int(cols[worst]),
            photosites=rows.size,
            standard_error=plan.standard_error(rows, cols),
        )


def hardest_of(job: Job, count: int) -> tuple[I64, I64]:
    """Return places at corners, beside edges and anywhere."""
    grid: Grid = job.grid
    x0, y0 = grid.first_centre
    places = []
    for turn in range(count):
        part = (turn * GOLDEN) % 1.0
        if len(job.edges) and turn % 4 != 3:
            edge = int(part * len(job.edges))
            start, along = job.edges.start[edge], job.edges.end[edge] - job.edges.start[edge]
            places.append(start + (0.5 if turn % 4 == 1 else 0.0) * along + (3.0 if turn % 4 == 2 else 0.0))
        else:
            places.append(np.array([x0 + part * (grid.cols - 1), y0 + (37.0 * part) % 1.0 * (grid.rows - 1)]))
    col, row = np.round(np.array(places) - np.array([x0, y0])).T
    rows = np.clip(row, 0, grid.rows - 1).astype(np.int64)
    cols = np.clip(col, 0, grid.cols - 1).astype(np.int64)
    one = np.unique(np.stack([rows, cols], axis=1), axis=0)
    return one[:, 0], one[:, 1]
