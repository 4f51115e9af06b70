"""The judge of every rendering: photosites computed again, from the scene itself, by another road."""

from __future__ import annotations

import dataclasses
import functools
from typing import TypeAlias

import numpy as np

from camsim.arrays import F64, I64, U8, kinds_of
from camsim.kept import cached_property
from camsim.optics import RoundLens
from camsim.rendering.budget import DIFFERENCE_CHECK_PART, ErrorBudget
from camsim.rendering.check.bent import bent
from camsim.rendering.check.beside import Beside
from camsim.rendering.check.checks import Found, Transforms
from camsim.rendering.check.fitting import Either, Fitting, Windows
from camsim.rendering.check.framed import Framed
from camsim.rendering.check.from_afar import FromAfar, from_afar
from camsim.rendering.check.integrals import Integrals
from camsim.rendering.check.listener import Listener
from camsim.rendering.check.overlap import Overlapping, followed
from camsim.rendering.check.places import farthest, hardest_photosites, how_many, windows
from camsim.rendering.check.polygons import polygons
from camsim.rendering.check.pupils import summed_otherwise
from camsim.rendering.check.scenery import Pieces, pieces_of
from camsim.rendering.check.sides import Sides
from camsim.rendering.check.wavelengths import densities, widest
from camsim.rendering.engine import FEWEST_CHECKED, Plan
from camsim.rendering.hearing import Listening
from camsim.rendering.job import Job
from camsim.rendering.spectral import carrying
from camsim.scene.arcs import Fineness

WINDOW = 3  # photosites along a side, for lenses that are not round
OF_WINDOW = [2, 4, 7]  # of these, where each is integrated too: the middle one, and one of every other row
JUST_BEYOND = 1.03  # times the distance where a difference is cut off
DEAR_SECONDS = 0.05  # for one photosite and the table: then windows are asked what they take
ASKING_SECONDS = 5e-5  # of that for every piece of outline: 0.4 ms, and eight photosites are looked at or more
OF_RINGS = 0.5  # of what a window may be wrong by: what integrals may be that end where its rings are dropped
OF_MEETING = (
    0.1  # of the tolerance: louder rings that meet in step are followed, of the difference as of the round part
)
FAR_SHARE, FAR_SECONDS = 0.5, 0.3  # of the image's time, or so much, for one photosite far away


Seen: TypeAlias = tuple[Pieces, F64, F64]


class Judge:
    """What recomputes photosites of a job.

    Of the job it takes what came in (scene, optics, grid, light, tolerance) and nothing that was made of it: outlines,
    painter's order, spectra and wavelengths are its own. A round lens on rectangles is integrated (integrals.py).
    Any other is rendered in small windows by Fourier transforms, with another period, taper and band, from the check's
    own outlines and rule over the pupil and to its own budget; so is a tolerance below what the integrals are good for,
    and a photosite of so many blurs that windows take less. Of an aberrated lens the round part is integrated, and what
    it has besides rendered in windows, to ``DIFFERENCE_CHECK_PART`` of the tolerance.
    """

    def __init__(self, job: Job, transforms: Transforms, seen: Seen | None = None) -> None:
        self.job = job
        self.transforms = transforms
        self._seen = seen

    @cached_property
    def seen(self) -> Seen:
        """Pieces of the scene, wavelengths, and densities (spectra, channels, n); of another judge if it was given."""
        if self._seen is not None:
            return self._seen
        job = self.job
        whole = job.bending is None and job.finest is not None and job.tolerance >= job.finest
        budget = job.budget.of_check if whole else self._of_windows
        highest = job.system.highest_per_um(self._felt_nm) * job.grid.pitch_um
        fine = Fineness(1.0 / highest, budget.allowed("own curves"), self._away)
        pieces, spectra = pieces_of(job.scene, job.grid.pitch_um, fine, whole=whole)
        if job.bending is not None and len(pieces.left):
            pieces = bent(pieces, fine, job.bending)
        wavelength_nm, density = densities(spectra, job.response, job.wavelength_nm)
        return pieces, wavelength_nm, density

    @cached_property
    def _felt_nm(self) -> F64:
        """The wavelengths without those of a light that the sensor does not see."""
        felt_nm: F64 = self.job.wavelength_nm[carrying(self.job.response)]
        return felt_nm

    @cached_property
    def _away(self) -> FromAfar | None:
        return from_afar(self.job, self._felt_nm)

    @cached_property
    def base(self) -> F64:
        """The background in each channel."""
        background: F64 = self.seen[2][0].sum(axis=1)
        return background

    @cached_property
    def integrates(self) -> bool:
        """Whether photosites are integrated one by one: where that is known, and not dear beside windows."""
        job = self.job
        if job.finest is None or job.tolerance < job.finest:
            return False
        each, table = self.integrals.seconds_each, self.integrals.table_seconds
        if each + table <= max(DEAR_SECONDS, ASKING_SECONDS * len(self.seen[0].left)):
            return True
        middle = np.array([job.grid.rows // 2]), np.array([job.grid.cols // 2])
        return table + self._all * each <= self._whole.taken(*middle)

    @cached_property
    def integrals(self) -> Integrals:
        """What integrates."""
        return self._integrals(self.job.budget.of_check)

    def _integrals(self, budget: ErrorBudget) -> Integrals:
        """Return what integrates what a rectangle on every spot sees; or a point, where the photosite is none."""
        job, (pieces, wavelength_nm, density) = self.job, self.seen
        both, pair = kinds_of(pieces.left * len(density) + pieces.right)
        left, right = np.divmod(both, len(density))
        weights, which, times = widest(density[left] - density[right])
        x0, y0 = np.array(job.grid.first_centre) - self._moved
        lens = job.system.lens if job.split is None else job.split.core
        assert isinstance(lens, RoundLens)
        return Integrals(
            lens=lens, listener=Listener.of(job, wavelength_nm), pitch_um=job.grid.pitch_um,
            pieces=pieces, pair=which[pair], times=times[pair],
            wavelength_nm=wavelength_nm, weights=weights, budget=budget,
            corners=np.array([x0, y0, x0 + job.grid.cols - 1, y0 + job.grid.rows - 1]),
        )  # fmt: skip

    def _heard(self, job: Job) -> float:
        """Return how far a round lens's rings are heard, by the check's own rule."""
        own = self._integrals(ErrorBudget(OF_RINGS * job.tolerance))
        # A photosite that is no rectangle hears as far as a point that lets as much pass, and by its extent farther.
        return own.farthest + (0.0 if own.listener.envelope is None else job.extent)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at: a tenth of the rendering's time's worth, at least.

        Those that would take more memory than there is are refused: an image is not rendered to be checked by nothing.
        """
        pieces, grid = self.seen[0], self.job.grid
        if not len(pieces.left):
            return np.zeros(1, np.int64), np.zeros(1, np.int64)
        if self.integrates and self._difference is None:
            return hardest_photosites(pieces.round, grid, plan.marks, count=self.count(plan))
        if self._difference is not None:
            rows, cols = windows(pieces.round, grid, WINDOW, JUST_BEYOND * plan.marks.reach)
            which = (self._of_all + np.arange(0, rows.size, self._all)[:, None]).ravel()
            self._framed.refuse_much(rows[which], cols[which])
            return rows[which], cols[which]
        rows, cols = windows(pieces.round, grid, WINDOW)
        self._framed.refuse_much(rows, cols)
        # A pattern's far parts are seen from far away: where that is not dear.
        row, col = farthest(pieces.round, grid)
        if self._whole.taken(row, col) > max(FAR_SHARE * plan.cost.seconds, FAR_SECONDS):
            return rows, cols
        return np.append(rows, row), np.append(cols, col)

    def fewest(self, plan: Plan) -> tuple[I64, I64]:
        """Return those of them that are looked at whatever it takes, each by itself."""
        outlines = self.seen[0].round
        if not len(self.seen[0].left):
            return np.zeros(1, np.int64), np.zeros(1, np.int64)
        return hardest_photosites(outlines, self.job.grid, plan.marks, count=plan.fewest)

    def count(self, plan: Plan) -> int:
        """Return how many photosites are looked at."""
        grid, each = self.job.grid, self.integrals.seconds_each
        return how_many(grid.rows * grid.cols, render_seconds=plan.cost.seconds, check_seconds=each, fewest=plan.fewest)

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        if not len(self.seen[0].left):
            return 0.0
        if self.integrates and self._difference is None:
            return self.integrals.table_seconds + self.count(plan) * self.integrals.seconds_each
        return self.taken(*self.hardest(plan))

    @property
    def least_seconds(self) -> float:
        """What it is sure to take, whatever the plan."""
        if not len(self.seen[0].left) or not self.integrates or self._difference is not None:
            return 0.0
        fewest = min(FEWEST_CHECKED, self.job.grid.rows * self.job.grid.cols)
        return self.integrals.table_seconds + fewest * self.integrals.seconds_each

    def taken(self, rows: I64, cols: I64) -> float:
        """Return what photosites are expected to take."""
        own = 0.0
        if self.integrates:
            own = self.integrals.table_seconds + rows.size * self.integrals.seconds_each
        return own + (0.0 if self.integrates and self._difference is None else self._framed.seconds(rows, cols))

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        difference = np.abs(values - right)
        worst = int(np.argmax(difference))
        return Found(
            error=float(difference[worst]),
            row=int(rows[worst]),
            col=int(cols[worst]),
            photosites=rows.size,
            standard_error=plan.standard_error(rows, cols),
        )

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        pieces = self.seen[0]
        base: F64 = self.base[sets]
        if not len(pieces.left):
            return base
        if not self.integrates:
            return self._framed.values(rows, cols, sets)
        x0, y0 = self.job.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1) - self._moved
        again = self.integrals.values(points, sets.reshape(-1, rows.size).astype(np.int64))
        values: F64 = base + again.reshape(sets.shape)
        return values if self._difference is None else values + self._framed.values(rows, cols, sets)

    @cached_property
    def _moved(self) -> F64:
        """How far the round part's pattern is moved, pitches."""
        split = self.job.split
        return np.zeros(2) if split is None else np.array(split.moved_um) / self.job.grid.pitch_um

    @cached_property
    def _difference(self) -> Job | None:
        """What there is besides the round part, followed as far as the check hears rings that meet in step."""
        rest = None if self.job.split is None or not self.integrates else self.job.difference_part()
        if rest is None:
            return None
        return dataclasses.replace(rest, rings_until=self.integrals.meets_until(OF_MEETING * self.job.tolerance))

    @property
    def _of_windows(self) -> ErrorBudget:
        """What transforms of all of the lens may be wrong by: no less than their engine is."""
        return ErrorBudget(max(self.job.budget.of_check.tolerance, self.transforms.finest))

    @property
    def _all(self) -> int:
        """How many photosites there are in a window."""
        return min(WINDOW, self.job.grid.rows) * min(WINDOW, self.job.grid.cols)

    @property
    def _of_all(self) -> I64:
        """Which of them are looked at where each is integrated too."""
        return np.array(OF_WINDOW if self._all == WINDOW**2 else range(self._all))

    @cached_property
    def _framed(self) -> Framed:
        return self._whole if self._difference is None else self._of_difference(self._difference)

    @cached_property
    def _whole(self) -> Framed:
        """What transforms photosites of the job itself."""
        windows = self._windows_of(self.job, self.base, self.job.budget.of_check.tolerance)
        return Framed(grid=self.job.grid, windows=windows, together=self._all)

    def _of_difference(self, rest: Job) -> Framed:
        """Return what transforms photosites of the difference, or looks up what they see of lines."""
        pieces, wavelength_nm, density = self.seen
        allowed = DIFFERENCE_CHECK_PART * self.job.tolerance
        job, beside = followed(rest, wavelength_nm), None
        if isinstance(job.system.lens, Overlapping):
            beside = Beside(
                job=job,
                lens=job.system.lens,
                pieces=pieces,
                where=self.integrals.where,
                wavelength_nm=wavelength_nm,
                density=density,
                budget=ErrorBudget(allowed),
            )
        nothing = np.zeros_like(self.base)
        windows = self._windows_of(job, nothing, allowed)
        if job is not rest:
            # Overlaps have no pattern whose far light is known: where that is much, patterns take less.
            windows = Either(windows, self._windows_of(rest, nothing, allowed))
        return Framed(grid=job.grid, windows=windows, together=self._of_all.size, beside=beside)

    def _windows_of(self, job: Job, base: F64, allowed: float) -> Windows:
        """Return what transforms windows of the job itself, or of its difference."""
        pieces, wavelength_nm, density = self.seen
        job = job.behind(summed_otherwise(job.system.lens))
        highest = job.system.highest_per_um(wavelength_nm) * job.grid.pitch_um
        edges = polygons(pieces, Fineness(1.0 / highest, self._of_windows.tolerance, self._away))
        until = self._heard if isinstance(job.system.lens, RoundLens) and not job.system.more else None
        make = functools.partial(job.of_edges, edges, wavelength_nm=wavelength_nm, density=density, base=base)
        return Fitting(
            lambda tolerance: self.transforms.windows(make(tolerance=tolerance), Listening(until, Sides.of)),
            wanted=max(allowed, self.transforms.finest),
            coarsest=job.tolerance,
        )
