"""The check of a lens that changes over the frame: every photosite with the pattern of its own place."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.optics.protocols import Varies
from camsim.rendering.across.plan import AcrossPlan
from camsim.rendering.check.judge import Found, Judge, Transforms
from camsim.rendering.engine import Plan
from camsim.rendering.job import Job

LEAST_SECONDS = 0.06  # of a photosite: its pupil's nodes, and windows of a few thousand frequencies


@dataclass(frozen=True, kw_only=True, eq=False)
class AcrossJudge:
    """What recomputes photosites; nothing is interpolated, and edges are bent anew, four times as finely."""

    job: Job
    lens: Varies
    transforms: Transforms

    @functools.cached_property
    def _whole(self) -> Judge:
        """What sees the scene, for all photosites."""
        return Judge(self.job, self.transforms)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at."""
        return self._whole.fewest(plan)

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take: about a place's image for each photosite."""
        assert isinstance(plan, AcrossPlan)
        grid = self.job.grid
        if not len(self._whole.seen[0].left):
            return 0.0
        return min(plan.fewest, grid.rows * grid.cols) * max(LEAST_SECONDS, plan.each.seconds)

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        values = np.empty(sets.shape)
        x0, y0 = self.job.grid.first_centre
        pitch_um = self.job.grid.pitch_um
        for k in range(rows.size):
            one = slice(k, k + 1)
            place = (x0 + float(cols[k])) * pitch_um, (y0 + float(rows[k])) * pitch_um
            judge = Judge(self.job.behind(self.lens.at(*place)), self.transforms, seen=self._whole.seen)
            values[..., one] = judge.values(rows[one], cols[one], sets[..., one])
        return values

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        return self._whole.compare(plan, values, right, rows, cols)
