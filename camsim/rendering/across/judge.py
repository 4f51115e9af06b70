"""The check of a lens that changes over the frame: every photosite with the pattern of its own place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.protocols import Varies
from camsim.rendering.check.checks import Found, Transforms
from camsim.rendering.check.judge import Judge
from camsim.rendering.engine import Plan
from camsim.rendering.job import Job

AT_ONCE = 2  # photosites, on threads of their own: a window may take much memory
LEAST_SECONDS = 0.06  # of a photosite: its pupil's nodes, and windows of a few thousand frequencies


@dataclass(frozen=True, kw_only=True, eq=False)
class AcrossJudge:
    """What recomputes photosites; nothing is interpolated, and edges are bent anew, four times as finely."""

    job: Job
    lens: Varies
    transforms: Transforms

    @cached_property
    def _whole(self) -> Judge:
        """What sees the scene, for all photosites."""
        return Judge(self.job, self.transforms)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at."""
        return self._whole.fewest(plan)

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        grid = self.job.grid
        if not len(self._whole.seen[0].left):
            return 0.0
        return min(plan.fewest, grid.rows * grid.cols) * self._each_seconds

    @cached_property
    def _each_seconds(self) -> float:
        """What a photosite takes on average: asked in the middle, in the farthest corner, and in the one opposite.

        Of a lens with terms of its own at every place one corner may take five times as long as another.
        """
        (x0, y0), grid = self.job.grid.first_centre, self.job.grid
        last_row, last_col = grid.rows - 1, grid.cols - 1
        row, col = (0 if abs(first) > abs(first + last) else last for first, last in ((y0, last_row), (x0, last_col)))
        places = {(row, col), (last_row - row, last_col - col), (last_row // 2, last_col // 2)}
        each = [self._at(*place).taken(*map(np.atleast_1d, place)) for place in sorted(places)]
        return max(LEAST_SECONDS, sum(each) / len(each))

    def _at(self, row: int, col: int) -> Judge:
        """Return what sees the scene with the pattern of one place."""
        (x0, y0), pitch_um = self.job.grid.first_centre, self.job.grid.pitch_um
        lens = self.lens.at((x0 + float(col)) * pitch_um, (y0 + float(row)) * pitch_um)
        return Judge(self.job.behind(lens), self.transforms, seen=self._whole.seen)

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        values = np.empty(sets.shape)
        _ = self._whole.seen  # made once, before threads ask for it

        def work(first: int, end: int) -> None:
            for k in range(first, end):
                one = slice(k, k + 1)
                judge = self._at(int(rows[k]), int(cols[k]))
                values[..., one] = judge.values(rows[one], cols[one], sets[..., one])

        shared(rows.size, work, most=AT_ONCE)
        return values

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        return self._whole.compare(plan, values, right, rows, cols)
