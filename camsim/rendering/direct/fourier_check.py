"""The check for lenses without a rotationally symmetric PSF, and for large scenes: frequency sums with other settings.

Periods, levels, and where that is quick transfer tables and wavelengths differ from the image's; the sources of
pictures and of many edges are the image's own.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.cached import cached_property
from camsim.optics.of_pupil import OfPupil
from camsim.rendering.direct.checks import in_channels
from camsim.rendering.direct.places import hardest_photosites
from camsim.rendering.direct.records import Outlines
from camsim.rendering.engine import FINEST, MEMORY_LIMIT_BYTES, Plan
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.job import Job
from camsim.rendering.waves.image import TILE, FrequencyImage, cells_of
from camsim.rendering.waves.levels import reach_of
from camsim.rendering.waves.plan import Waves, WavesPlan
from camsim.scene import Scene

OF_TOLERANCE = 0.5  # tolerance of the check over that of the image
COARSER, LONGEST = 1.0, 5.0  # the alternative, if that exceeds the memory limit or this many seconds
FARTHER, FINER = 1.37, 1.13  # reach of the first level and number of wavelengths, over those of the image
NEARER = 0.4  # the same of the reach for spikes: farther windows take as long as the image
STEEP = 0.6  # waves of a wavefront from which on a second table of transfers takes too long
MANY = 5_000  # edges above which the image's transforms are reused
PLACES, COUNT, OF_IMAGE = 32, 8, 0.03  # difficult places; cells with the most of them, and their share of the image's
EACH_SECONDS = 0.01  # of levels and tables
OF_REACH, SMALLEST = 0.4, 8  # side of a cell over the reach of the first level, and the smallest, photosites


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierCheck:
    """Recomputes photosites of a job.

    scene  : the whole scene;  fields: the pictures, gradients and points in it
    like   : the image's plan, whose sources and wavelengths are reused for many edges, or pictures
    """

    job: Job
    scene: Scene
    fields: FieldJob | None = None
    like: WavesPlan | None = None

    @property
    def _again(self) -> bool:
        """Whether the image's sources are reused."""
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
        """Plan of the check, with a looser tolerance where it would take too much memory or time."""
        plan = self._planned(OF_TOLERANCE)
        if plan.cost.memory_bytes > MEMORY_LIMIT_BYTES or plan.cost.seconds > LONGEST:
            plan = self._planned(COARSER)
        return plan

    def _planned(self, share: float) -> WavesPlan:
        lens = self.job.system.lens
        tolerance = max(share * self.job.tolerance, FINEST)
        job = self.job.to(tolerance)
        fields = self.fields
        if fields is not None:
            fields = dataclasses.replace(fields, tolerance=max(share * fields.tolerance, FINEST))
        shortest_nm = float(self.job.signals.wavelength_nm.min())
        steep = isinstance(lens, OfPupil) and lens.waves_across(shortest_nm) > STEEP
        sides = isinstance(lens, OfPupil) and lens.pupil.shape != "circular"
        nearer = NEARER if sides and not steep else FARTHER
        finer = 1.0 if self._again or steep or sides else FINER
        return Waves(farther=FARTHER, nearer=nearer, finer=finer, rougher=1.0 / share).plan(job, fields=fields)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to check: all between the difficult places of a few cells."""
        if self._nothing:
            return np.zeros(1, np.int64), np.zeros(1, np.int64)
        edges, none = self.job.edges, np.zeros(len(self.job.edges))
        (x, y), (dx, dy) = edges.start.T, (edges.end - edges.start).T
        outlines = Outlines(x, y, dx, dy, none, none)
        rows, cols = hardest_photosites(outlines, np.empty((0, 2)), self.job.grid, plan.marks, count=PLACES)
        which = cells_of(rows, cols, self._side)
        found = []
        for cell in np.argsort(-np.bincount(which), kind="stable")[: self._count]:
            y, x = rows[which == cell], cols[which == cell]
            found.append(np.mgrid[y.min() : y.max() + 1, x.min() : x.max() + 1].reshape(2, -1))
        rows, cols = np.concatenate(found, axis=1)
        return rows, cols

    @property
    def _side(self) -> int:
        """Return the side of a cell, photosites: little longer to compute than one of them."""
        return int(min(max(OF_REACH * reach_of(self._image.levels), SMALLEST), TILE))

    @property
    def _of_frame(self) -> float:
        """Return a cell's part of the frame, both with what reaches them."""
        grid, reach = self.job.grid, 2.0 * reach_of(self._image.levels)
        return (self._side + reach) ** 2 / ((grid.rows + reach) * (grid.cols + reach))

    @property
    def _count(self) -> int:
        """Return how many cells are checked."""
        return max(1, min(COUNT, int(OF_IMAGE / self._of_frame)))

    @property
    def _nothing(self) -> bool:
        return not len(self.job.edges) and self.fields is None

    def seconds(self, plan: Plan) -> float:
        """Return the expected seconds of the check."""
        if self._nothing:
            return 0.0
        return EACH_SECONDS + min(self._count * self._of_frame, 1.0) * self.plan.cost.seconds

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Recompute photosites, each in its channel of ``sets`` (..., photosites)."""
        values: F64 = self.job.base[sets]
        if self._nothing:
            return values
        grid = self.job.grid
        values += in_channels(self._image.at(grid.first_centre, rows, cols, self._side), sets)
        return values
