"""The judge of renderings with pictures: edges by their own check, and to that what pictures add, from the scene."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.optics.difference import Split
from camsim.optics.protocols import OpticalStage
from camsim.quadrature import GOLDEN
from camsim.rendering.budget import DIFFERENCE_CHECK_PART, ErrorBudget
from camsim.rendering.check.checks import Found
from camsim.rendering.check.crossings import crossed
from camsim.rendering.check.fields import DirectSums
from camsim.rendering.check.fitting import Fitting, Windows
from camsim.rendering.check.judge import Judge
from camsim.rendering.check.places import SHARE_OF_TIME
from camsim.rendering.check.pupils import summed_otherwise
from camsim.rendering.check.ring_sums import RingSums
from camsim.rendering.check.seen_fields import SeenFields, Summed
from camsim.rendering.check.wavelengths import condensed
from camsim.rendering.engine import Plan
from camsim.rendering.grid import Grid
from camsim.scene import Picture, PointSource, Scene
from camsim.scene.gradients import Gradient
from camsim.scene.raster import axes_of

FEWEST, MOST = 2, 24
CROSSED = 3  # more photosites where outlines lie in front of pictures
RIM = 1


class Fields(Protocol):
    """What the check is told of a rendering's pictures, and asks of the field engine where it cannot sum itself."""

    @property
    def tolerance(self) -> float: ...  # noqa: D102 (of the pictures)

    @property
    def split(self) -> Split | None: ...  # noqa: D102 (the lens as a round one, moved, and the rest)

    def windows(self, tolerance: float) -> Windows: ...  # noqa: D102 (renders windows of the pictures)

    def difference(self, tolerance: float, rings_until: float) -> Windows | None: ...  # noqa: D102 (behind the rest)

    def behind(self, lens: OpticalStage) -> Fields: ...  # noqa: D102 (the same behind another lens)


@dataclass(frozen=True, kw_only=True, eq=False)
class PictureJudge:
    """What recomputes photosites of a scene with pictures.

    edges  : the judge of everything else;  scene: as it came in
    fields : see there
    """

    edges: Judge
    scene: Scene
    fields: Fields

    @cached_property
    def _seen(self) -> SeenFields:
        """What there is to see."""
        job, split = self.edges.job, self.fields.split
        system = job.system if split is None else dataclasses.replace(job.system, lens=split.core)
        return SeenFields(job=job, scene=self.scene, system=system)

    @property
    def sees(self) -> bool:
        """Whether anything of pictures, gradients and points is to be seen."""
        return self._seen.visible

    @cached_property
    def _moved(self) -> F64:
        """Where the pattern's centre lies (x, y), pitches: a photosite sees what is as far the other way."""
        split = self.fields.split
        return np.zeros(2) if split is None else np.array(split.moved_um) / self.edges.job.grid.pitch_um

    @cached_property
    def _middles(self) -> F64:
        """The photosites (n, 2) nearest to the middles of pictures, moved and not: rings may be about these."""
        grid, fields = self.edges.job.grid, [one for one in self.scene.shapes if isinstance(one, Picture | Gradient)]
        middles = np.array([one.centre_um for one in fields], float).reshape(-1, 2)[: MOST // 2] / grid.pitch_um
        rows, cols = _nearest(np.concatenate([middles, middles + self._moved]), grid)
        return np.unique(np.stack([cols, rows], axis=1) + np.array(grid.first_centre), axis=0)

    @cached_property
    def _summed(self) -> Summed:
        """What sums are of."""
        return self._seen.summed()

    @cached_property
    def _rings(self) -> RingSums:
        """What is heard in the middles of pictures."""
        return RingSums.at(self._middles - self._moved, self._summed, self.edges.job.grid.pitch_um)

    @cached_property
    def _sums(self) -> DirectSums | None:
        """What sums photosites, None where nothing does."""
        if not DirectSums.can(self._seen.system):
            return None
        seen, grid = self._summed, self.edges.job.grid
        blur = seen.system.blurs_um(seen.wavelength_nm) / grid.pitch_um
        sums = functools.partial(
            DirectSums, seen=seen.pictures, system=seen.system, grid=grid, allowed=seen.allowed, moved=self._moved,
            until=self._rings.until(seen.allowed),
        )  # fmt: skip
        if not seen.pictures:
            return sums(density=seen.density, wavelength_nm=seen.wavelength_nm)
        radius = sums(density=seen.density, wavelength_nm=seen.wavelength_nm).radius
        phase = 2.0 * math.pi * radius * float(1.0 / blur.min() - 1.0 / blur.max())
        nodes, moved = condensed(seen.wavelength_nm, seen.density, phase=phase, allowed=seen.allowed)
        return sums(density=moved, wavelength_nm=nodes)

    @cached_property
    def _transformed(self) -> Fields:
        """What renders windows: behind the same lens, its pattern by the check's own rule."""
        return self.fields.behind(summed_otherwise(self.edges.job.system.lens))

    @cached_property
    def _windows(self) -> Windows | None:
        """What renders windows of what is not summed, None where all is."""
        finest = self.edges.transforms.finest
        if self._sums is not None:
            wanted, coarsest = max(DIFFERENCE_CHECK_PART * self.fields.tolerance, finest), self.fields.tolerance
            if self._transformed.difference(coarsest, 0.0) is None:
                return None
            return Fitting(self._difference, wanted=wanted, coarsest=coarsest)
        wanted = max(self.edges.job.budget.of_check.tolerance, finest)
        return Fitting(self._transformed.windows, wanted=wanted, coarsest=self.fields.tolerance)

    def _difference(self, tolerance: float) -> Windows:
        # A wavefront turns the rings of two sides against one another by half a turn at the most.
        allowed = ErrorBudget(tolerance).allowed("cut") / 2.0
        found = self._transformed.difference(tolerance, self._rings.until(allowed))
        assert found is not None
        return found

    def _seconds_each(self, sums: DirectSums) -> float:
        """Return what one photosite is expected to take: its sums, and a window of what the lens has besides."""
        if self._windows is None:
            return sums.seconds_each
        side = 2 * RIM + 1
        return sums.seconds_each + self._windows.expected(self.edges.job.grid.first_centre, (side, side))[0].seconds

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at."""
        grid, sums = self.edges.job.grid, self._sums
        rows, cols = np.empty((2, 0), np.int64)
        if len(self.edges.seen[0].left):
            rows, cols = self.edges.hardest(plan)
        if sums is None:
            own = _nearest(self._crossed(1), grid) if rows.size else self._places(2)
            more = _windows_of(own, grid.rows, grid.cols)
            return np.concatenate([rows, more[0]]), np.concatenate([cols, more[1]])
        each = self._seconds_each(sums)
        count = int(np.clip(SHARE_OF_TIME * plan.cost.seconds / each, self._fewest, MOST))
        own = self._places(count)
        some = np.linspace(0, rows.size - 1, min(rows.size, count)).astype(int)
        both = np.concatenate([np.stack([rows[some], cols[some]], axis=1), np.stack(own, axis=1)])
        places = np.unique(both.astype(np.int64), axis=0)
        return places[:, 0], places[:, 1]

    @property
    def _fewest(self) -> int:
        """How many photosites are looked at whatever it takes."""
        return FEWEST + len(self._middles) + len(self._crossed(CROSSED))

    def _places(self, count: int) -> tuple[I64, I64]:
        """Return photosites where outlines lie in front of pictures, at their corners and middles, and anywhere."""
        grid = self.edges.job.grid
        x0, y0 = grid.first_centre
        in_front = self._crossed(count)
        corners = list(self._middles)
        corners += [np.array(point.centre_um) / grid.pitch_um + self._moved for point in self._seen.points[:count]]
        for shape in self.scene.shapes:
            if isinstance(shape, Picture | Gradient):
                middle = np.array(shape.centre_um) / grid.pitch_um + self._moved
                half = np.array(shape.half_um) / grid.pitch_um
                for across, down in ((-1, -1), (1, 1), (1, -1), (-1, 1)):
                    corners.append(middle + np.einsum("a,ax->x", half * [across, down], axes_of(shape.rotate_deg)))
        # What shows a point that lies under a shape is wrong.
        seen = set(self._seen.points)
        under = [one for one in self.scene.shapes if isinstance(one, PointSource) and one not in seen]
        corners += [np.array(point.centre_um) / grid.pitch_um + self._moved for point in under[:count]]
        spots: dict[tuple[int, int], None] = {}
        turn = 0
        while len(spots) < min(count, grid.rows * grid.cols):
            part = (turn * GOLDEN) % 1.0
            anywhere = np.array([x0 + part * (grid.cols - 1), y0 + (part * 37.0 % 1.0) * (grid.rows - 1)])
            places = np.stack([*in_front[turn : turn + 1], *corners[turn : turn + 1], anywhere])
            spots |= dict.fromkeys(zip(*(axis.tolist() for axis in _nearest(places, grid)), strict=True))
            turn += 1
            if turn > 40 * count:
                break
        chosen = np.array(list(spots)[:count], np.int64)
        return chosen[:, 0], chosen[:, 1]

    def _crossed(self, count: int) -> F64:
        """Return places (n, 2) where outlines lie in front of pictures, the hardest first."""
        fields = [shape for shape in self.scene.shapes if isinstance(shape, Picture | Gradient)]
        found = crossed(zip(fields, self._seen.bounds.values(), strict=True), self.edges.job.grid, count)
        return found + self._moved

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        sums = self._sums
        if sums is None:
            return self.edges.seconds(plan)
        return self.edges.seconds(plan) + self.hardest(plan)[0].size * self._seconds_each(sums)

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        return self.edges.compare(plan, values, right, rows, cols)

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        value = self.edges.values(rows, cols, sets)
        windows, together = self._windows, 9
        if self._sums is not None:
            value, together = value + self._sums.values(rows, cols, sets), 1
            # Of a large picture it holds a copy, for which there is no room while a sensor records.
            for kept in ("_sums", "_summed"):
                self.__dict__.pop(kept)
        if windows is None:
            return value
        x0, y0 = self.edges.job.grid.first_centre
        for first in range(0, rows.size, together):
            part = slice(first, first + together)
            row, col = int(rows[part].min()) - RIM, int(cols[part].min()) - RIM
            shape = int(rows[part].max()) - row + RIM + 1, int(cols[part].max()) - col + RIM + 1
            channel = np.empty((*sets.shape[:-1], *shape), sets.dtype)
            channel[...] = sets[..., part][..., :1, None]
            places = (..., rows[part] - row, cols[part] - col)
            channel[places] = sets[..., part]
            value[..., part] += windows.rendered((x0 + col, y0 + row), channel)[places]
        return value


def _windows_of(places: tuple[I64, I64], rows: int, cols: int) -> tuple[I64, I64]:
    """Return windows of 3 × 3 photosites about places."""
    tall, wide = min(3, rows), min(3, cols)
    down, across = np.divmod(np.arange(tall * wide), wide)
    row = np.clip(places[0] - tall // 2, 0, rows - tall)
    col = np.clip(places[1] - wide // 2, 0, cols - wide)
    return (row[:, None] + down).ravel(), (col[:, None] + across).ravel()


def _nearest(places: F64, grid: Grid) -> tuple[I64, I64]:
    """Return rows and columns of the photosites nearest to places (n, 2)."""
    col, row = np.round(places - np.array(grid.first_centre)).T
    return np.clip(row, 0, grid.rows - 1).astype(np.int64), np.clip(col, 0, grid.cols - 1).astype(np.int64)
