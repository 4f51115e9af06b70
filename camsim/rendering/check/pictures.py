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
from camsim.quadrature import GOLDEN, gauss_error
from camsim.rendering.budget import DIFFERENCE_CHECK_PART
from camsim.rendering.check.checks import Found
from camsim.rendering.check.crossings import Bounds, bounds_of, crossed
from camsim.rendering.check.fields import DirectSums
from camsim.rendering.check.fitting import Fitting, Windows
from camsim.rendering.check.gradient_samples import Cells, SeenGradient
from camsim.rendering.check.judge import Judge
from camsim.rendering.check.places import SHARE_OF_TIME
from camsim.rendering.check.point_samples import SeenPoints, seen_points
from camsim.rendering.check.pupils import summed_otherwise
from camsim.rendering.check.scene_samples import LARGEST, Seen
from camsim.rendering.check.wavelengths import condensed, densities
from camsim.rendering.engine import Plan
from camsim.rendering.grid import Grid
from camsim.scene import Picture, PointSource, Scene
from camsim.scene.gradients import Gradient
from camsim.scene.raster import Field, axes_of, flat_of
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum

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

    def difference(self, tolerance: float) -> Windows | None: ...  # noqa: D102 (the same behind the rest alone)

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
    def _highest(self) -> float:
        """The highest frequency that passes the lens, cycles/pitch."""
        job = self.edges.job
        seen_nm = job.wavelength_nm[np.any(job.response != 0.0, axis=0)]
        if not seen_nm.size:
            seen_nm = job.wavelength_nm[:1]
        return job.system.highest_per_um(seen_nm) * job.grid.pitch_um

    @cached_property
    def _bounds(self) -> dict[int, Bounds | None]:
        """What bounds what is seen of every field, by its number among the shapes; None for all of a picture."""
        job = self.edges.job
        pitch_um, allowed = job.grid.pitch_um, job.budget.of_check.tolerance
        return {
            number: bounds_of(self.scene, number, pitch_um, 1.0 / (self._highest + _cycles(shape, pitch_um)), allowed)
            for number, shape in enumerate(self.scene.shapes)
            if isinstance(shape, Picture | Gradient)
        }

    @property
    def sees(self) -> bool:
        """Whether anything of pictures, gradients and points is to be seen."""
        return bool(self._points) or any(bounds is None or len(bounds.start) for bounds in self._bounds.values())

    @cached_property
    def _points(self) -> list[PointSource]:
        """Points that nothing covers, the brightest first."""
        seen = seen_points(self.scene, self.edges.job.grid.pitch_um)
        return sorted(seen, key=lambda point: -(point.photosites or 0.0))

    @cached_property
    def _moved(self) -> F64:
        """Where the pattern's centre lies (x, y), pitches: a photosite sees what is as far the other way."""
        split = self.fields.split
        return np.zeros(2) if split is None else np.array(split.moved_um) / self.edges.job.grid.pitch_um

    @cached_property
    def _sums(self) -> DirectSums | None:
        """What sums photosites behind a round lens, or behind the round part of one."""
        job, system = self.edges.job, self.edges.job.system
        if self.fields.split is not None:
            system = dataclasses.replace(system, lens=self.fields.split.core)
        if not DirectSums.can(system):
            return None
        allowed = job.budget.of_check.tolerance
        background = self.scene.background
        pictures: list[Seen] = []
        spectra: list[Spectrum | Component] = []
        for number, shape in enumerate(self.scene.shapes):
            if isinstance(shape, Picture | Gradient):
                pictures.append(self._seen(number, shape, allowed))
                spectra.extend(shape.spectra)
                if pictures[-1].ones:
                    spectra.append(Component.less(background))
        colours: list[Spectrum] = list(dict.fromkeys(point.reflectance for point in self._points))
        wavelength_nm, density = densities(
            [*spectra, *colours] or [0.0], job.response, job.wavelength_nm, full=job.signals.scale
        )
        if self._points:
            pictures.append(SeenPoints.of(self._points, colours, job.grid.pitch_um))
            allowed /= max(1.0, pictures[-1].loud)
        blur = system.blurs_um(wavelength_nm) / job.grid.pitch_um
        sums = functools.partial(
            DirectSums, seen=tuple(pictures), system=system, grid=job.grid, allowed=allowed, moved=self._moved
        )
        radius = sums(density=density, wavelength_nm=wavelength_nm).radius
        phase = 2.0 * math.pi * radius * float(1.0 / blur.min() - 1.0 / blur.max())
        nodes, moved = condensed(wavelength_nm, density, phase=phase, allowed=allowed)
        return sums(density=moved, wavelength_nm=nodes)

    def _seen(self, number: int, shape: Field, allowed: float) -> Seen:
        """Return what is seen of a picture or gradient."""
        assert isinstance(shape, Picture | Gradient)
        highest, bounds = self._highest, self._bounds[number]
        pitch_um, background = self.edges.job.grid.pitch_um, self.scene.background
        grey = background if isinstance(background, float | int) else None
        flat = None if grey is None else flat_of(shape.spectra)
        less = np.zeros(len(shape.spectra)) if flat is None or grey is None else grey * flat
        outline = None if bounds is None else (bounds.start, bounds.end)
        raster = Cells.over(shape, pitch_um) if isinstance(shape, Gradient) else shape
        phase = math.pi * (highest + _cycles(shape, pitch_um)) * min(raster.step_um / pitch_um, LARGEST)
        order = 3
        while order < 60 and gauss_error(order, phase) > math.log(max(allowed, 1e-12)):
            order += 1
        if isinstance(shape, Gradient):
            return SeenGradient(
                picture=raster, less=less, ones=flat is None, outline=outline, pitch_um=pitch_um, order=order + 1,
                gradient=shape, highest=highest, allowed=allowed,
            )  # fmt: skip
        return Seen(picture=raster, less=less, ones=flat is None, outline=outline, pitch_um=pitch_um, order=order + 1)

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
            if self._transformed.difference(coarsest) is None:
                return None
            return Fitting(self._difference, wanted=wanted, coarsest=coarsest)
        wanted = max(self.edges.job.budget.of_check.tolerance, finest)
        return Fitting(self._transformed.windows, wanted=wanted, coarsest=self.fields.tolerance)

    def _difference(self, tolerance: float) -> Windows:
        found = self._transformed.difference(tolerance)
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
        return FEWEST + len(self._crossed(CROSSED))

    def _places(self, count: int) -> tuple[I64, I64]:
        """Return photosites where outlines lie in front of pictures, at their corners and middles, and anywhere."""
        grid = self.edges.job.grid
        x0, y0 = grid.first_centre
        in_front = self._crossed(count)
        corners = [np.array(point.centre_um) / grid.pitch_um + self._moved for point in self._points[:count]]
        for shape in self.scene.shapes:
            if isinstance(shape, Picture | Gradient):
                middle = np.array(shape.centre_um) / grid.pitch_um + self._moved
                half = np.array(shape.half_um) / grid.pitch_um
                for across, down in ((-1, -1), (0, 0), (1, 1), (1, -1), (-1, 1)):
                    corners.append(middle + np.einsum("a,ax->x", half * [across, down], axes_of(shape.rotate_deg)))
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
        found = crossed(zip(fields, self._bounds.values(), strict=True), self.edges.job.grid, count)
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
            self.__dict__.pop("_sums")
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


def _cycles(field: Field, pitch_um: float) -> float:
    """Return the most cycles/pitch of a gradient; a picture is told by its samples."""
    return field.cycles_per_um * pitch_um if isinstance(field, Gradient) else 0.0


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
