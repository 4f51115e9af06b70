"""The check of a lens of revolution: every photosite with the transfer of its own place, and no lattice.

The perfect lens is integrated as everywhere. What differs is summed over directions: the transform of a side is that of
its two ends, so a photosite sees

    Σ over sides ∫ (n × e)/(n·e)·[Q(n·a) − Q(n·b)] dθ        n = (cos θ, sin θ), θ = 0 … π; a, b the ends about it

with Q(h) = ∫ T(f·n)·footprint(f·n)·cos-like(2πfh)/(2π²f) df. The transfers are overlaps of the pupil by another rule,
wavelengths, shifts and angles others than the engine's; nothing is interpolated over the frame. Edges are bent anew.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64, U8
from camsim.optics.airy import NM_PER_UM, airy_otf
from camsim.optics.difference import rim_of
from camsim.optics.placed import PlacedLens, Revolves
from camsim.optics.pupil import Pupil
from camsim.optics.zernike import zernike
from camsim.quadrature import barycentric, chebyshev, gauss_legendre, interpolation
from camsim.rendering.across.bands import far_reach
from camsim.rendering.budget import DIFFERENCE_CHECK_PART
from camsim.rendering.check.judge import Found, Judge, Transforms
from camsim.rendering.check.polygons import polygons
from camsim.rendering.check.wavelengths import condensed
from camsim.rendering.edges import Edges
from camsim.rendering.engine import Plan
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.clamped import clamped
from camsim.rendering.job import Job

SECONDS = 3.0  # for each photosite
FEWEST_NODES = (14, 28, 20, 16)  # of the overlap's rule, shifts, half a circle of angles, wavelengths
PER_WAVE = (2.2, 3.4, 3.2, 4.5)  # of the steepest slope, waves per radius: nodes more, at 1e-5
COARSEST = 0.7  # of them, at 2e-3 and more
FINER = 1.5  # directions, times what a sum over them takes to be exact of waves that go so far
STEPS = 8.0  # of a direction's table in the finest wave
PERIOD = 6.0  # of such a table, in what is seen to one side
CHUNK = 64  # directions at a time
RAYS = 2.0  # λN that a ray goes for a wave of slope: what turns with the wavelength
FLAT = 1e-2  # of a step: ends this near are one place, and Q's slope


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldJudge:
    """What recomputes photosites of a job behind a lens of revolution."""

    job: Job
    lens: Revolves
    transforms: Transforms

    @functools.cached_property
    def _perfect(self) -> Judge:
        """What sees the scene, through the perfect lens."""
        return Judge(self.job, self.transforms)

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to look at."""
        return self._perfect.fewest(plan)

    def seconds(self, plan: Plan) -> float:
        """Return what the check is expected to take."""
        return 0.0 if not len(self._perfect.seen[0].left) else plan.fewest * SECONDS

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again, each in its channel of ``sets`` (..., photosites)."""
        values = self._perfect.values(rows, cols, sets)
        if not len(self._perfect.seen[0].left):
            return values
        x0, y0 = self.job.grid.first_centre
        for k in range(rows.size):
            channels = sets[..., k].reshape(-1).astype(np.int64)
            more = self._differing((x0 + float(cols[k]), y0 + float(rows[k])), channels)
            values[..., k] += more.reshape(sets.shape[:-1])
        return values

    def compare(self, plan: Plan, values: F64, right: F64, rows: I64, cols: I64) -> Found:
        """Compare an image's values at photosites with what they should be."""
        return self._perfect.compare(plan, values, right, rows, cols)

    @functools.cached_property
    def _edges(self) -> Edges:
        """The check's own edges, pitches."""
        pieces, wavelength_nm, _ = self._perfect.seen
        highest = self.job.system.highest_per_um(wavelength_nm) * self.job.grid.pitch_um
        return polygons(pieces, 1.0 / highest, self.job.budget.of_check.tolerance)

    def _differing(self, place: tuple[float, float], channels: I64) -> F64:
        """Return what one photosite sees besides the perfect lens's image, in each of some channels."""
        job, pitch_um = self.job, self.job.grid.pitch_um
        _, wavelength_nm, density = self._perfect.seen
        lens = self.lens.at(place[0] * pitch_um, place[1] * pitch_um)
        wavelength_nm, contrast = condensed(
            wavelength_nm,
            (density[1:] - density[0])[:, channels],
            phase=RAYS * 2.0 * math.pi * _steepest(lens, wavelength_nm),
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
        box = min(max(reach, 8.0), 2.0 * max(job.span, 8.0))
        seen = clamped(self._edges.seen_from(place), (-box, -box), (box, box))
        if not len(seen):
            return np.zeros(channels.size)
        own = _Fused(lens=lens, wavelength_nm=wavelength_nm, weights=weights, tolerance=job.tolerance)
        found = np.zeros((len(weights), len(contrast)))
        cut = job.system.highest_per_um(wavelength_nm) * pitch_um
        count = math.ceil(FINER * math.pi * cut * math.sqrt(2.0) * box)
        for first in range(0, count, CHUNK):
            theta = math.pi * (np.arange(first, min(first + CHUNK, count)) + 0.5) / count
            found += self._directions(own, theta, seen, cut, box) * (math.pi / count)
        # Each spectrum's regions with its own transfer.
        total: F64 = np.einsum("scs->c", found.reshape(len(contrast), channels.size, len(contrast)))
        return total

    def _directions(self, own: _Fused, theta: F64, seen: Edges, cut: float, box: float) -> F64:
        """Return (transfers, spectra): what some directions give of the regions of each spectrum, added up."""
        pitch_um = self.job.grid.pitch_um
        step = 1.0 / (STEPS * cut)
        length = fast_length(math.ceil(PERIOD * box / step), real=True)
        frequency = np.arange(1, math.ceil(cut * length * step)) / (length * step)
        cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
        foot = self.job.system.footprint_otf(frequency * cos / pitch_um, frequency * sin / pitch_um)
        transfer = own.on(frequency / pitch_um, theta) * (foot / (4.0 * math.pi**2 * np.arange(1, frequency.size + 1)))
        spectrum = np.zeros((*transfer.shape[:-1], length // 2 + 1), complex)
        spectrum[..., 1 : 1 + frequency.size] = transfer.conj()
        tables = scipy.fft.irfft(spectrum, n=length, axis=-1, norm="forward")
        along = seen.end - seen.start
        begin, end = (p[:, 0] * cos + p[:, 1] * sin for p in (seen.start, seen.end))
        # Ends that are one place show the slope there.
        close = np.abs(end - begin) < FLAT * step
        begin, end = np.where(close, begin - step, begin) / step, np.where(close, begin + step, end) / step
        turned = (cos * along[:, 1] - sin * along[:, 0]) / (step * (end - begin))
        out = np.zeros((len(transfer), self._spectra))
        for own_out, table in zip(out, tables, strict=True):
            each = np.sum(turned * (_looked_up(table, begin) - _looked_up(table, end)), axis=0)
            for side, sign in ((seen.left, 1.0), (seen.right, -1.0)):
                there = side > 0
                own_out += sign * np.bincount(side[there] - 1, each[there], out.shape[1])
        return out

    @property
    def _spectra(self) -> int:
        return len(self._perfect.seen[2]) - 1


def _steepest(lens: PlacedLens, wavelength_nm: F64) -> float:
    """Return the steepest slope of the wavefront, waves per radius."""
    some_nm = np.linspace(wavelength_nm.min(), wavelength_nm.max(), 4)
    return max(rim_of(lens, 0.0, float(nm), np.zeros(2)).inside_waves for nm in some_nm)


def _looked_up(table: F64, place: F64) -> F64:
    """Return values (directions, n) at places, in steps, from periodic tables (directions, steps), by six points."""
    cell = np.floor(place)
    t, first = place - cell, cell.astype(np.int64)
    row = np.arange(len(table))[:, None]
    value = np.zeros_like(t)
    for k in range(-2, 4):
        weight = np.ones_like(t)
        for other in range(-2, 4):
            if other != k:
                weight *= (t - other) / (k - other)
        value += weight * table[row, (first + k) % table.shape[1]]
    return value


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fused:
    """Transfers of one place, less the perfect one's, for sets of weights (sets, wavelengths)."""

    lens: PlacedLens
    wavelength_nm: F64
    weights: F64
    tolerance: float

    @functools.cached_property
    def _nodes(self) -> tuple[int, int, int, int]:
        steep = _steepest(self.lens, self.wavelength_nm)
        share = min(1.0, max(COARSEST, (3.0 - math.log10(self.tolerance)) / 8.0))
        counts = [math.ceil(share * (few + per * steep)) for few, per in zip(FEWEST_NODES, PER_WAVE, strict=True)]
        return counts[0], counts[1], counts[2], counts[3]

    @functools.cached_property
    def _samples(self) -> tuple[F64, F64, C128]:
        """Shifts' angles α, ν = cos α; wavelengths; samples (wavelengths, shifts, 2·angles) all round."""
        rule, shifts, angles, colours = self._nodes
        nm = self.wavelength_nm
        if nm.size > colours:
            nm = 0.5 * (nm[0] + nm[-1]) + 0.5 * (nm[-1] - nm[0]) * chebyshev(colours)
        alpha = 0.25 * math.pi * (1.0 + gauss_legendre(shifts)[0])
        waves = self.lens.coefficients(nm)
        pupil, out = Pupil(), np.empty((nm.size, shifts, angles), complex)
        for s, nu in enumerate(np.cos(alpha)):
            for a in range(angles):
                angle = math.pi * a / angles
                x, y, weight = pupil.overlap(2.0 * float(nu), angle, rule)
                dx, dy = float(nu) * math.cos(angle), float(nu) * math.sin(angle)
                steps = np.stack([zernike(j, x - dx, y - dy) - zernike(j, x + dx, y + dy) for j in self.lens.zernike])
                turn = 2.0 * math.pi * np.einsum("wz,zn->wn", waves, steps)
                out[:, s, a] = (np.cos(turn) @ weight + 1j * (np.sin(turn) @ weight)) / pupil.area
        out -= airy_otf(np.cos(alpha), f_number=1.0, wavelength_nm=NM_PER_UM)[:, None]
        return alpha, nm, np.concatenate([out, out.conj()], axis=-1)

    @functools.cached_property
    def _harmonics(self) -> tuple[I64, C128]:
        samples = self._samples[2]
        count = samples.shape[-1]
        spectrum = scipy.fft.fft(samples, axis=-1) / count
        m = np.arange(-(count // 2) + 1, count // 2)
        return m, spectrum[..., m]

    def on(self, frequency_per_um: F64, theta: F64) -> C128:
        """Return transfers (sets, directions, frequencies)."""
        m, _ = self._harmonics
        fused = self._over(frequency_per_um)
        around = np.exp(1j * np.multiply.outer(theta, m))
        found: C128 = np.einsum("smf,tm->stf", fused, around, optimize=True)
        return found

    def _over(self, frequency_per_um: F64) -> C128:
        """Return harmonics (sets, m, frequencies), wavelengths added up; kept for the next directions."""
        key = frequency_per_um.size, float(frequency_per_um[0])
        if key not in self._kept:
            alpha, nm, _ = self._samples
            _, harmonics = self._harmonics
            low, high = self.wavelength_nm[0], self.wavelength_nm[-1]
            own = np.eye(nm.size)
            if nm.size < self.wavelength_nm.size:
                own = interpolation(chebyshev(nm.size), (2.0 * self.wavelength_nm - low - high) / (high - low))
            x, w = gauss_legendre(alpha.size)
            signs = (-1.0) ** np.arange(x.size) * np.sqrt((1.0 - x * x) * w)
            f_number = self.lens.f_number
            fused = np.zeros((len(self.weights), harmonics.shape[-1], frequency_per_um.size), complex)
            for j, each_nm in enumerate(self.wavelength_nm):
                nu = frequency_per_um * f_number * each_nm / NM_PER_UM
                inside = nu < 1.0
                at = barycentric(x, signs, np.arccos(nu[inside]) / (0.25 * math.pi) - 1.0, same=1e-14)
                mine = np.einsum("c,csm->sm", own[j], harmonics)
                values = np.einsum("fs,sm->mf", at, mine, optimize=True)
                fused[:, :, inside] += self.weights[:, j, None, None] * values
            self._kept[key] = fused
        return self._kept[key]

    @functools.cached_property
    def _kept(self) -> dict[tuple[int, float], C128]:
        return {}
