"""The judge of every rendering: photosites computed again, from the scene itself, by another road."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.check.places import Marks, hardest_photosites, how_many, windows
from camsim.rendering.check.round_lens import RoundLens
from camsim.rendering.check.scenery import Pieces, pieces_of
from camsim.rendering.check.wavelengths import densities
from camsim.rendering.fourier import FINEST

if TYPE_CHECKING:
    from camsim.rendering.job import Job

WINDOW = 3  # photosites along a side, for lenses that are not round
RIM = 2  # more on every side of a window: a grid that is one window has other numbers in its check all the same
WINDOWS_SHARE = 0.5  # of an image's time, for the windows of the check


class Judge:
    """What recomputes photosites of a job.

    Of the job it takes what came in (scene, optics, grid, light, tolerance) and nothing that was made of it: outlines,
    painter's order, spectra and wavelengths are its own. A round lens on rectangles is integrated (round_lens.py).
    Any other is rendered in small windows by Fourier transforms, with another period, taper, band and other nodes, from
    the check's own outlines and to its own budget; so is a tolerance below what the integrals are good for.
    """

    def __init__(self, job: Job) -> None:
        self.job = job

    @functools.cached_property
    def seen(self) -> tuple[Pieces, F64, F64]:
        """Pieces of the scene, wavelengths, and densities (spectra, channels, n)."""
        job = self.job
        pieces, spectra = pieces_of(job.scene, job.grid.pitch_um)
        wavelength_nm, density = densities(spectra, job.response, job.wavelength_nm)
        return pieces, wavelength_nm, density

    @functools.cached_property
    def base(self) -> F64:
        """The background in each channel."""
        background: F64 = self.seen[2][0].sum(axis=1)
        return background

    @property
    def integrates(self) -> bool:
        """Whether photosites are integrated one by one."""
        job = self.job
        return job.pattern is not None and job.footprint is not None and job.tolerance >= job.pattern.finest

    @functools.cached_property
    def lens(self) -> RoundLens:
        """What integrates."""
        job = self.job
        pieces, wavelength_nm, density = self.seen
        sides, pair = np.unique(np.stack([pieces.left, pieces.right], axis=1), axis=0, return_inverse=True)
        x0, y0 = job.grid.first_centre
        return RoundLens(
            system=job.system,
            pitch_um=job.grid.pitch_um,
            pieces=pieces,
            pair=pair.ravel().astype(np.int64),
            wavelength_nm=wavelength_nm,
            weights=density[sides[:, 0]] - density[sides[:, 1]],
            budget=ErrorBudget(job.tolerance).of_check,
            corners=np.array([x0, y0, x0 + job.grid.cols - 1, y0 + job.grid.rows - 1]),
        )

    def photosites(self, render_seconds: float, marks: Marks, fewest: int) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at: a tenth of the rendering's time's worth, at least."""
        pieces, grid = self.seen[0], self.job.grid
        if not len(pieces.left):
            return np.zeros(1, np.int64), np.zeros(1, np.int64)
        if self.integrates:
            return hardest_photosites(
                pieces.outlines,
                grid,
                marks,
                count=self.count(render_seconds, fewest),
            )
        return windows(pieces.outlines, grid, WINDOW)

    def count(self, render_seconds: float, fewest: int) -> int:
        """Return how many photosites are looked at."""
        grid = self.job.grid
        each = self.lens.seconds_each
        return how_many(grid.rows * grid.cols, render_seconds=render_seconds, check_seconds=each, fewest=fewest)

    def seconds(self, render_seconds: float, fewest: int) -> float:
        """Return what the check is expected to take."""
        if self.integrates:
            return self.count(render_seconds, fewest) * self.lens.seconds_each
        return WINDOWS_SHARE * render_seconds

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets``."""
        pieces = self.seen[0]
        base: F64 = self.base[sets]
        if not len(pieces.left):
            return base
        if not self.integrates:
            return self._in_windows(rows, cols, sets)
        x0, y0 = self.job.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1).astype(float)
        return base + self.lens.values(points, sets.astype(np.int64))

    def _in_windows(self, rows: I64, cols: I64, sets: U8) -> F64:
        from camsim.rendering.by_fourier import FourierRun  # an engine, which knows the judge

        job, (pieces, wavelength_nm, density) = self.job, self.seen
        finer = max(ErrorBudget(job.tolerance).of_check.tolerance, FINEST)
        highest = max(job.system.cutoff_per_um(float(w)) for w in wavelength_nm) * job.grid.pitch_um
        start, end, left, right = _polygons(pieces, 1.0 / highest, finer)
        mine = job.of_edges(
            start, end, left, right, wavelength_nm=wavelength_nm, density=density, base=self.base, tolerance=finer
        )
        run = FourierRun.prepare(mine, None)
        x0, y0 = job.grid.first_centre
        values = np.empty(rows.size)
        size = min(WINDOW, job.grid.rows) * min(WINDOW, job.grid.cols)
        for first in range(0, rows.size, size):
            part = slice(first, first + size)
            row, col = int(rows[part].min()), int(cols[part].min())
            shape = (int(rows[part].max()) - row + 1, int(cols[part].max()) - col + 1)
            channel = np.pad(sets[part].reshape(shape), RIM, mode="edge")
            window = run.image((x0 + col - RIM, y0 + row - RIM), channel, lambda done: None)
            values[part] = window[RIM:-RIM, RIM:-RIM].ravel()
        return values


def _polygons(pieces: Pieces, longest: float, allowed: float) -> tuple[F64, F64, I64, I64]:
    """Return the pieces as straight edges: round ones as sides of the same area, shorter than any wave that passes.

    A whole circle's corners all lie on R·√(θ/sin θ). A part's ends stay where other pieces meet them, and its first and
    last sides are off by s³/36R of area, which is kept below what is allowed on a square wave.
    """
    o = pieces.outlines
    starts, ends, owners = [], [], []
    straight = np.flatnonzero(o.turn_rad == 0.0)
    starts.append(np.stack([o.x, o.y], axis=1)[straight])
    ends.append(np.stack([o.x + o.dx, o.y + o.dy], axis=1)[straight])
    owners.append(straight)
    for e in np.flatnonzero(o.turn_rad > 0.0).tolist():
        whole = o.turn_rad[e] >= math.tau * (1.0 - 1e-15)
        side = 0.7 * longest
        if not whole:
            side = min(side, (36.0 * o.dx[e] * allowed * longest**2) ** (1.0 / 3.0))
        sides = max(96 if whole else 2, math.ceil(o.dx[e] * o.turn_rad[e] / side))
        theta = o.turn_rad[e] / sides
        radius = np.full(sides + 1, o.dx[e] * math.sqrt(theta / math.sin(theta)))
        if not whole:
            radius[[0, -1]] = o.dx[e]
        angle = o.from_rad[e] + theta * np.arange(sides + 1)
        corners = np.stack([o.x[e] + radius * np.cos(angle), o.y[e] + radius * np.sin(angle)], axis=1)
        if whole:
            corners[-1] = corners[0]
        starts.append(corners[:-1])
        ends.append(corners[1:])
        owners.append(np.full(sides, e))
    owner = np.concatenate(owners)
    return np.concatenate(starts), np.concatenate(ends), pieces.left[owner], pieces.right[owner]
