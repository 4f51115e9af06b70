"""The check of a lens of revolution: every photosite with the transfer of its own place, and no lattice.

The perfect lens is integrated as everywhere. What differs is summed over directions: the transform of a side is that of
its two ends, so a photosite sees

    Σ over sides ∫ (n × e)/(n·e)·[Q(n·a) − Q(n·b)] dθ        n = (cos θ, sin θ), θ = 0 … π; a, b the ends about it

with Q(h) = ∫ T(f·n)·footprint(f·n)·cos-like(2πfh)/(2π²f) df. Smooth windows cut T in parts: what is fine is short,
what goes far is smooth, and each takes as many directions as its frequencies times its reach. The transfers are
overlaps of the pupil by another rule, wavelengths, shifts and angles others than the engine's; nothing is interpolated
over the frame. Edges are bent anew.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.placed import Revolves
from camsim.rendering.aberrated.settings import sighted
from camsim.rendering.across.ends import Ends
from camsim.rendering.across.far_reach import far_reach
from camsim.rendering.across.field_plan import FieldPlan
from camsim.rendering.across.hardest import changes_of
from camsim.rendering.across.judge_kernels import add_sides
from camsim.rendering.across.place_samples import steepest
from camsim.rendering.across.place_transfers import PlaceTransfers
from camsim.rendering.budget import DIFFERENCE_CHECK_PART
from camsim.rendering.check.checks import Found, Transforms
from camsim.rendering.check.judge import Judge
from camsim.rendering.check.polygons import polygons
from camsim.rendering.check.wavelengths import condensed
from camsim.rendering.edges import Edges
from camsim.rendering.engine import Plan
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.clamped import clamped
from camsim.rendering.job import Job
from camsim.scene.arcs import Fineness

FINER = 1.5  # directions, times what a sum over them takes to be exact of waves that go so far
STEPS, LOOKED_UP = 12.0, 1e-5  # of a table in the finest wave, at so much and more: sums over sides take slopes
PERIOD, APART = 6.0, 2.0  # of such a table, in what is seen to one side; and that more, at least, than lines are heard
CHUNK = 64  # directions at a time
AT_ONCE = 4  # photosites, on threads of their own: each has tables of its own
RAYS = 2.0  # λN that a ray goes for a wave of slope: what turns with the wavelength
WIDEST, NARROWER = 0.25, 4.0  # windows: the first one's width in cycles/pitch, and from one to the next
SHORT, LONG = 3.0, 4.0  # over a window's width, pitches: its reach is looked for within three times it; the last one's
QUIET = 0.05  # of the tolerance: what a line may show past a window's reach
SILENT = 5.5  # widths of a window, past which it is 5e-10
LISTENED, HALF = 16, 0.8  # directions in which lines are looked at; of half a period, as far as that tells their reach


class Window(NamedTuple):
    """Frequencies that are summed on their own: up to ``high``'s width, down to ``low``'s; 0 and inf for all."""

    low: float
    high: float

    def __call__(self, frequency: F64) -> F64:
        """Return what it takes of frequencies in cycles/pitch."""
        return _passed(frequency, self.high) - _passed(frequency, self.low)


def _passed(frequency: F64, width: float) -> F64:
    """Return what passes a window as flat at 0 as the eighth power."""
    if width in (0.0, math.inf):
        return np.full(frequency.shape, float(width > 0.0))
    q = np.square(frequency / width)
    taken: F64 = np.exp(-q) * (1.0 + q * (1.0 + q * (0.5 + q / 6.0)))
    return taken


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldJudge:
    """What recomputes photosites of a job behind a lens of revolution."""

    job: Job
    lens: Revolves
    transforms: Transforms

    @cached_property
    def _perfect(self) -> Judge:
        """What sees the scene, through the perfect lens."""
        return Judge(self.job, self.transforms)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at: the last of them where the lens changes most."""
        rows, cols = self._perfect.fewest(plan)
        place = self._changing
        if rows.size > 1 and place is not None and not ((rows == place[0]) & (cols == place[1])).any():
            rows[-1], cols[-1] = place
        return rows, cols

    @cached_property
    def _changing(self) -> tuple[int, int] | None:
        """Row and column of the photosite at an outline's corner where wavefronts change most with the distance."""
        grid, first = self.job.grid, np.array(self.job.grid.first_centre)
        inside = np.round(self._edges.start - first)
        inside = inside[((inside >= 0.0) & (inside <= [grid.cols - 1.0, grid.rows - 1.0])).all(axis=1)]
        if not len(inside):
            return None
        away_um = grid.pitch_um * np.hypot(*(first + inside).T)
        radii_um = float(away_um.min()), float(away_um.max())
        if radii_um[0] == radii_um[1]:
            return None
        radius, change = changes_of(self.lens, radii_um, float(self.job.wavelength_nm.min()))
        col, row = inside[int(np.argmax(np.interp(away_um, radius, np.gradient(change, radius))))].astype(int).tolist()
        return row, col

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        if not len(self._perfect.seen[0].left):
            return 0.0
        assert isinstance(plan, FieldPlan)
        grid = self.job.grid
        return min(plan.fewest, grid.rows * grid.cols) * plan.each_checked_seconds

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        values = self._perfect.values(rows, cols, sets)
        if not len(self._perfect.seen[0].left):
            return values
        x0, y0 = self.job.grid.first_centre
        _ = self._edges  # made once, before threads ask for them

        def work(first: int, end: int) -> None:
            for k in range(first, end):
                channels = sets[..., k].reshape(-1).astype(np.int64)
                more = self._differing((x0 + float(cols[k]), y0 + float(rows[k])), channels)
                values[..., k] += more.reshape(sets.shape[:-1])

        shared(rows.size, work, most=AT_ONCE)
        return values

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        return self._perfect.compare(plan, values, right, rows, cols)

    @cached_property
    def _edges(self) -> Edges:
        """The check's own edges, pitches."""
        pieces, wavelength_nm, _ = self._perfect.seen
        highest = self.job.system.highest_per_um(wavelength_nm) * self.job.grid.pitch_um
        return polygons(pieces, Fineness(1.0 / highest, self.job.budget.of_check.tolerance))

    def _differing(self, place: tuple[float, float], channels: I64) -> F64:
        """Return what one photosite sees besides the perfect lens's image, in each of some channels."""
        job, pitch_um = self.job, self.job.grid.pitch_um
        _, wavelength_nm, density = self._perfect.seen
        lens = self.lens.at(place[0] * pitch_um, place[1] * pitch_um)
        if not lens.zernike:
            return np.zeros(channels.size)  # a perfect lens that distorts
        wavelength_nm, contrast = condensed(
            wavelength_nm,
            (density[1:] - density[0])[:, channels],
            phase=RAYS * 2.0 * math.pi * steepest(lens, wavelength_nm),
            allowed=job.budget.of_check.allowed("own wavelengths"),
        )
        weights = contrast.reshape(-1, wavelength_nm.size)
        radius_um = pitch_um * math.hypot(*place)
        reach = far_reach(
            self.lens,
            job.system,
            wavelength_nm,
            weights,
            radii_um=(radius_um, radius_um),
            pitch_um=pitch_um,
            edges=self._edges,
            allowed=0.5 * DIFFERENCE_CHECK_PART * job.tolerance,
        )
        reach = max(reach, 8.0)
        farthest = min(reach, 2.0 * max(job.span, 8.0))
        if not len(clamped(self._edges.seen_from(place), (-farthest, -farthest), (farthest, farthest))):
            return np.zeros(channels.size)
        angle_rad = math.atan2(place[1], place[0])
        own = PlaceTransfers.of(lens, angle_rad, wavelength_nm, weights, job.tolerance)
        found = np.zeros((len(weights), len(contrast)))
        for window in _windows(farthest):
            heard = self._reach(own, window, reach) if window.low else reach
            box = min(heard, farthest)
            period = max(PERIOD * box, heard + APART * box)
            seen = clamped(self._edges.seen_from(place), (-box, -box), (box, box))
            count = math.ceil(FINER * math.pi * self._cut(own, window) * math.sqrt(2.0) * box)
            for first in range(0, count if len(seen) else 0, CHUNK):
                theta = math.pi * (np.arange(first, min(first + CHUNK, count)) + 0.5) / count
                found += self._directions(own, theta, seen, window, period) * (math.pi / count)
        # Each spectrum's regions with its own transfer.
        total: F64 = np.einsum("scs->c", found.reshape(len(contrast), channels.size, len(contrast)))
        return total

    def _cut(self, own: PlaceTransfers, window: Window) -> float:
        """Return where a window ends, cycles/pitch."""
        return min(SILENT * window.high, self.job.system.highest_per_um(own.wavelength_nm) * self.job.grid.pitch_um)

    def _reach(self, own: PlaceTransfers, window: Window, most: float) -> float:
        """Return how far lines, and ends of edges, are heard in a window, pitches; most: in any."""
        step, period = 1.0 / (self._steps * self._cut(own, window)), PERIOD * SHORT / window.low
        while True:
            beyond = self._shown_beyond(own, window, period)
            frequency, _ = self._frequencies(own, window, period)
            loudest = int(np.argmax(np.abs(own.weights).sum(axis=1)))
            harmonics = own.harmonics_at(frequency / self.job.grid.pitch_um)[loudest].T
            ends = Ends(frequency, harmonics, window(frequency))

            def reach_of(lines: float, beyond: F64 = beyond, ends: Ends = ends) -> float:
                allowed = QUIET * self.job.tolerance / lines
                quiet = np.flatnonzero(beyond <= allowed)
                # What is loud as far as half the period may be so farther on.
                if not quiet.size or quiet[0] >= HALF * beyond.size:
                    return most
                reach = max(float(quiet[0]), 1.0) * step
                return max(reach, ends.reach(allowed, reach))

            reach = min(sighted(self._edges, reach_of), most)
            if reach < most or HALF * beyond.size * step >= most:
                return reach
            period *= 2.0

    def _shown_beyond(self, own: PlaceTransfers, window: Window, period: float) -> F64:
        """Return the most that a line shows from a number of steps on, as far as half a period."""
        theta = math.pi * np.arange(LISTENED) / LISTENED
        spectrum, length = self._spectrum(own, theta, window, period)
        line = scipy.fft.irfft(2j * math.pi * spectrum, n=length, axis=-1, norm="forward")
        shown = np.abs(line).max(axis=(0, 1))
        either = np.maximum(shown[: length // 2], shown[:0:-1][: length // 2])
        beyond: F64 = np.maximum.accumulate(either[::-1])[::-1]
        return beyond

    def _frequencies(self, own: PlaceTransfers, window: Window, period: float) -> tuple[F64, int]:
        """Return frequencies of Q, even steps but for 0, and of how many steps its tables are.

        period : pitches, after which they repeat; some waves of the finest at the least
        """
        cut = self._cut(own, window)
        step = 1.0 / (self._steps * cut)
        length = fast_length(math.ceil(max(period, PERIOD / cut) / step), real=True)
        return np.arange(1, math.ceil(cut * length * step)) / (length * step), length

    def _spectrum(self, own: PlaceTransfers, theta: F64, window: Window, period: float) -> tuple[C128, int]:
        """Return spectra of Q (transfers, directions, n) in some directions, and of how many steps its tables are."""
        pitch_um, (frequency, length) = self.job.grid.pitch_um, self._frequencies(own, window, period)
        cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
        foot = self.job.system.footprint_otf(frequency * cos / pitch_um, frequency * sin / pitch_um)
        times = foot * (window(frequency) / (4.0 * math.pi**2 * np.arange(1, frequency.size + 1)))
        spectrum = np.zeros((len(own.weights), theta.size, length // 2 + 1), complex)
        spectrum[..., 1 : 1 + frequency.size] = (own.on(frequency / pitch_um, theta) * times).conj()
        return spectrum, length

    def _directions(self, own: PlaceTransfers, theta: F64, seen: Edges, window: Window, period: float) -> F64:
        """Return (transfers, spectra): what some directions give of the regions of each spectrum, added up."""
        spectrum, length = self._spectrum(own, theta, window, period)
        tables = scipy.fft.irfft(spectrum, n=length, axis=-1, norm="forward")
        step = 1.0 / (self._steps * self._cut(own, window))
        direction = np.stack([np.cos(theta), np.sin(theta)], axis=1)
        ends, sides = np.concatenate([seen.start, seen.end], axis=1), np.stack([seen.left, seen.right], axis=1)
        out = np.zeros((theta.size, len(tables), self._spectra))
        shared(theta.size, functools.partial(add_sides, direction, tables, step, ends, sides, out))
        total: F64 = out.sum(axis=0)
        return total

    @property
    def _steps(self) -> float:
        """Steps of a table in the finest wave: a look-up in six points loses by their sixth power."""
        return STEPS * max(1.0, float((LOOKED_UP / self.job.tolerance) ** (1.0 / 6.0)))

    @property
    def _spectra(self) -> int:
        return len(self._perfect.seen[2]) - 1


def _windows(farthest: float) -> list[Window]:
    """Return windows that together are all frequencies, the finest first."""
    widths = [math.inf]
    width = WIDEST
    while LONG / width < farthest:
        widths.append(width)
        width /= NARROWER
    return [Window(low, high) for high, low in pairwise([*widths, 0.0])]
