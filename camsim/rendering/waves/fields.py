"""Pictures, gradients and points as sources."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from camsim.core.arrays import C128, F64, I64, Complex, distinct
from camsim.core.cached import cached_property
from camsim.core.kernels import shared
from camsim.errors import UnsupportedError
from camsim.numerics.nonuniform import complex_type, modes, modes_of_lines
from camsim.numerics.quadrature import gauss_legendre
from camsim.rendering.fields.layer import Layer, basis
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import LONGEST_SQUARE, Splines, Support, parts_of, splines_of
from camsim.rendering.fields.thinned import spacing, thinned
from camsim.rendering.waves.edges import NODES_AT_ONCE, half_plane
from camsim.rendering.waves.kernels import repeat
from camsim.rendering.waves.levels import Lattice

SPARSE = 8.0  # samples per frequency: above this an FFT computes too many unused frequencies
MOST_SAMPLES, MOST_PITCHES = 64, 64  # largest denominator and numerator of a rational step, for which FFTs are used
WHOLE = 1e-12  # relative difference up to which a number of samples is an integer
ROWS_AT_ONCE = 16
MOST_FINER = 4e7  # largest number of samples after subdivision
FAR_IN = 8  # samples: distance from a border beyond which no spline is affected
THINNED = 2.5  # periods of the highest frequency: over half of the kernel by which a picture is thinned
FINEST, MOST_THINNED = 0.5, 8e6  # least spacing of a thinned picture over the picture's, and most samples of it
NEAR_ZERO = 1e-4  # radians: below, a sine over its angle is that of a series
POINTS = -1  # degree of splines that are points
# Corrections are light of a narrow strip. The error of a Gauss rule of n nodes, over its precision, is (f/cut)²ⁿ, and a
# lens passes at most 1 − f/cut: 1/((n + ½)(n + 1)) of it remains.
OF_STRIP, OF_RULE = 8.0, 40.0  # relative errors of the transforms of corrections, and of their rule, over the precision
BORDER_NODES = 24  # quadrature nodes between two knots of a border spline, plus one per radian of phase


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldSource:
    """A picture, a gradient or point sources.

    layer     : the samples with their positions
    mixture   : (kinds, planes) mixtures of the planes that are transformed
    cut       : highest frequency of any lattice, cycles/pitch
    precision : relative error of the transforms
    support   : region outside of which only low frequencies are needed; None: all frequencies everywhere
    far       : falling ends of the far levels' frequencies, cycles/pitch, for which the picture is thinned
    """

    layer: Layer | PointLayer
    mixture: F64
    cut: float
    precision: float
    support: Support | None = None
    far: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        layer = self.layer
        if isinstance(layer, PointLayer) or self._as_they_are:
            return
        finer = float(layer.shape[0] * layer.shape[1]) * parts_of(layer, self.cut) ** 2 * len(self.mixture)
        if finer > MOST_FINER:
            raise UnsupportedError(
                f"its samples are {layer.step:.3g} pitches wide, and divided as finely as the lens passes they are "
                f"{finer:.2g}, of {MOST_FINER:.0e} at most: crop it to what lies near the frame, give more samples, "
                "or look at its units",
                key="picture",
            )

    @property
    def _as_they_are(self) -> bool:
        """Whether an upright picture's samples are transformed without subdivision, which wide samples need."""
        layer = self.layer
        return isinstance(layer, Layer) and layer.upright and layer.outline is None and layer.step <= LONGEST_SQUARE

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner (2,) of the bounding box, pitches."""
        corners = self.layer.corners
        return corners.min(axis=0), corners.max(axis=0)

    @cached_property
    def whole(self) -> int:
        """The smallest number of pitches that is a whole number of an upright picture's samples; 1 if that is large."""
        layer = self.layer
        if isinstance(layer, PointLayer) or not layer.upright:
            return 1
        step = Fraction(layer.step).limit_denominator(MOST_SAMPLES)
        same = abs(float(step) - layer.step) <= WHOLE * layer.step
        return step.numerator if same and step.numerator <= MOST_PITCHES else 1

    @property
    def in_parts(self) -> bool:
        """False: its transform needs the whole lattice."""
        return False

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> Complex | None:
        """Return the transform of each mixture of planes; None: no light in the lattice's box."""
        layer = self.layer
        columns, rows = lattice.counts
        out = np.zeros((len(self.mixture), 2 * rows - 1, columns), complex_type(self.precision))
        if isinstance(layer, PointLayer):
            return out if self._add_points(out, layer.at, self._mixed(layer.light), lattice, origin) else None
        assert isinstance(layer, Layer)
        if self.far and lattice.cut <= self.far[0] * (1.0 + WHOLE):
            return out if self._thinned(out, layer, lattice, origin) else None
        if self._as_they_are:
            corner = layer.corner + 0.5 * layer.step * layer.axes.sum(axis=0)
            there = self._upright(out, self._planes, corner, layer.step, lattice, origin, layer.degree)
            return out if there else None
        splines = self._splines
        if layer.upright:
            there = self._upright(
                out, splines.light, splines.first, splines.step, lattice, origin, layer.degree, whole=True
            )
            there |= self._add_corrections(out, lattice, origin)
            return out if there else None
        there = self._add_points(out, splines.places, splines.light, lattice, origin)
        if there:
            _multiply(out, _squares(layer, lattice, splines.step) ** (splines.degree + 1))
        there |= self._add_corrections(out, lattice, origin)
        return out if there else None

    def thinning(self, far: tuple[float, ...], support: Support) -> FieldSource:
        """Return the source with the support; for frequencies up to ``far`` it is thinned where that takes less."""
        layer = self.layer
        plain = dataclasses.replace(self, support=support)
        if not isinstance(layer, Layer) or layer.outline is not None:
            return plain
        step = spacing(layer, far[0])
        if step < FINEST or math.prod(layer.shape) / step**2 > MOST_THINNED:
            return plain
        return dataclasses.replace(self, support=support._replace(cut=0.0), far=far)

    def _thinned(self, out: Complex, layer: Layer, lattice: Lattice, origin: tuple[float, float]) -> bool:
        """Add the transform of a picture that nothing hides from fewer samples; return whether there are any."""
        thin = thinned(layer, tuple(cut for cut in self.far if cut >= lattice.cut * (1.0 - WHOLE)), self.precision)
        # Coarse samples of light within the lattice's box may lie beside it.
        beside = THINNED / lattice.cut
        low, high = ((x + side, y + side) for (x, y), side in ((lattice.low, -beside), (lattice.high, beside)))
        wider = dataclasses.replace(lattice, low=low, high=high)
        across, down = layer.within(np.add(low, origin), np.add(high, origin))
        here = [thin.within(n, *ends) for n, ends in zip(thin.whole.shape, (down, across), strict=True)]
        if not all(here):
            return False
        light, step = self._mixed(thin.part(layer, *here)), thin.steps[-1]
        rows, cols = (thin.first + step * np.array(one) for one in here)
        if layer.upright:
            light, first = light / step**2, layer.places(np.array([[cols[0], rows[0]]]))[0]
            light = light.transpose(0, 2, 1) if self._is_turned else light
            there = self._upright(out, light, first, step * layer.step, wider, origin, POINTS)
        else:
            ways = layer.step * rows[:, None] * layer.axes[1], layer.step * cols[:, None] * layer.axes[0]
            places = layer.corner + ways[0][:, None] + ways[1]
            there = self._add_points(out, places, layer.step**2 * light, wider, origin)
        one, other = (thin.passes(layer.step * along) for along in _along(layer, lattice))
        _multiply(out, one * other)
        return there

    def _mixed(self, planes: F64) -> F64:
        """Return mixtures (kinds, …) of planes, without BLAS, whose last bits differ between processors."""
        if np.array_equal(self.mixture, np.eye(len(planes))):
            return planes
        mixed: F64 = np.einsum("kp,p...->k...", self.mixture, planes)
        return mixed

    @cached_property
    def _splines(self) -> Splines:
        assert isinstance(self.layer, Layer)
        found = splines_of(self.layer, cut=self.cut, allowed=OF_RULE * self.precision, support=self.support)
        light = self._mixed(found.light)
        if self.layer.upright:
            light = light / found.step**2
            light = light.transpose(0, 2, 1) if self._is_turned else light
        return found._replace(light=light, corrections=self._mixed(found.corrections))

    def _add_corrections(self, out: Complex, lattice: Lattice, origin: tuple[float, float]) -> bool:
        """Add the corrections at the outline; return whether there are any."""
        splines, precision = self._splines, OF_STRIP * self.precision
        return self._add_points(out, splines.points, splines.corrections, lattice, origin, precision)

    def _add_points(
        self,
        out: Complex,
        places: F64,
        light: F64,
        lattice: Lattice,
        origin: tuple[float, float],
        precision: float | None = None,
    ) -> bool:
        """Add the point sources, light (kinds, n), that lie in the lattice's box; return whether there are any."""
        precision = self.precision if precision is None else precision
        places, light = places.reshape(-1, 2), light.reshape(len(light), -1)
        at = places - np.array(origin)
        (x, y), low, high = at.T, lattice.low, lattice.high
        inside = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
        if not inside.any():
            return False
        if not inside.all():
            at, light = at[inside], light[:, inside]
        phases, turn = half_plane(at, lattice)
        at_once = max(1, NODES_AT_ONCE // turn.size)
        for first in range(0, len(out), at_once):
            some = slice(first, first + at_once)
            out[some] += modes(phases, turn * light[some], out.shape[1:], precision=precision, sign=-1)
        return True

    @cached_property
    def _planes(self) -> F64:
        """Samples of each kind (kinds, rows, cols), rows along x."""
        assert isinstance(self.layer, Layer)
        return self._mixed(self.layer.all_coefficients(self._is_turned))

    @property
    def _is_turned(self) -> bool:
        return bool(self.layer.axes[0, 0] == 0.0)  # its rows lie along y

    def _upright(
        self,
        out: Complex,
        planes: F64,
        corner: F64,
        step: float,
        lattice: Lattice,
        origin: tuple[float, float],
        degree: int,
        *,
        whole: bool = False,
    ) -> bool:
        """Add samples on a grid parallel to the photosites', transformed along rows, then along columns.

        planes : (kinds, rows, cols), rows along x;  corner: (2,) position of the first sample
        degree : of the splines, or POINTS
        whole  : whether splines at the border are left uncut
        """
        layer = self.layer
        assert isinstance(layer, Layer)
        x_axis, y_axis = (layer.axes[1], layer.axes[0]) if self._is_turned else (layer.axes[0], layer.axes[1])
        columns, rows = lattice.counts
        numbers = np.arange(columns), np.arange(1 - rows, rows)
        each = []
        for axis, (sign, count) in enumerate(((x_axis[0], planes.shape[2]), (y_axis[1], planes.shape[1]))):
            place = corner[axis] - origin[axis] + sign * step * np.arange(count)
            inside = np.flatnonzero((place >= lattice.low[axis]) & (place <= lattice.high[axis]))
            if not inside.size:
                return False
            which = range(int(inside[0]), int(inside[-1]) + 1)
            period = lattice.periods[axis]
            total = 0 if whole else count
            one = place[which.start : which.stop]
            each.append(_Along(one, which, total, sign * step, degree, period, numbers[axis]))
        along_x, along_y = each
        part = planes[:, along_y.which.start : along_y.which.stop, along_x.which.start : along_x.which.stop]
        for one, samples in zip(out, part, strict=True):
            if along_x.whole and along_y.whole:
                _add_both(one, samples, along_x, along_y)
                continue
            lines = along_x.transformed(samples, self.precision)
            one[:] = along_y.transformed(np.ascontiguousarray(lines.T), self.precision).T
        out *= step**2
        return True


def _along(layer: Layer, lattice: Lattice) -> list[F64]:
    """Return a lattice's frequencies (n, m) along each of a picture's axes, cycles/pitch."""
    columns, rows = lattice.counts
    fx, fy = np.arange(columns) / lattice.periods[0], np.arange(1 - rows, rows)[:, None] / lattice.periods[1]
    return [fx * axis[0] + fy * axis[1] for axis in layer.axes]


def _squares(layer: Layer, lattice: Lattice, side: float) -> F64:
    """Return the transform of a square with a turned picture's axes at a lattice's frequencies (n, m); side: pitches.

    The sine of a sum of phases follows from those of its terms. Near 0 it loses digits to the quotient's series.
    """
    columns, rows = lattice.counts
    squares = np.ones((2 * rows - 1, columns))
    for axis in math.pi * side * layer.axes:
        across = axis[0] / lattice.periods[0] * np.arange(columns)
        down = axis[1] / lattice.periods[1] * np.arange(1 - rows, rows)[:, None]
        phase, sine = across + down, np.sin(down) * np.cos(across)
        sine += np.cos(down) * np.sin(across)
        small = np.abs(phase) < NEAR_ZERO
        few = 1.0 - phase[small] ** 2 / 6.0
        phase[small] = 1.0
        sine /= phase
        sine[small] = few
        squares *= sine
    return squares


def _multiply(out: Complex, factor: F64) -> None:
    """Multiply transforms by a real factor (n, m), in their precision."""
    out *= factor.astype(out.real.dtype, copy=False)


class _Along(NamedTuple):
    """Splines along one axis, cut at the picture's border, where the samples are mirrored.

    place   : (n,) positions of the samples;  which: their indices
    total   : number of all samples, 0 if splines are not cut at the border;  step: signed, pitches
    numbers : (m,) frequencies times period
    """

    place: F64
    which: range
    total: int
    step: float
    degree: int
    period: int
    numbers: I64

    def transformed(self, lines: F64 | C128, precision: float) -> C128:
        """Return Σ lines[…, i]·(transform of spline i) at all frequencies: (lines, m)."""
        middle = int(self.numbers[self.numbers.size // 2])
        phase = (2.0 * np.pi / self.period) * self.place
        strengths = np.ascontiguousarray(lines * np.exp(-1j * middle * phase))
        out = modes_of_lines(phase, strengths, self.numbers.size, precision=precision)
        out *= self.passes
        for i, wrong in self.borders():
            out += lines[:, i, None] * wrong
        return out

    @property
    def frequency(self) -> F64:
        """Cycles/pitch (m,)."""
        return self.numbers / self.period

    @property
    def passes(self) -> F64:
        """Transform of an uncut spline (m,)."""
        passes: F64 = np.sinc(self.step * self.frequency) ** (self.degree + 1)
        return passes

    @property
    def whole(self) -> int:
        """Samples per period if that is an integer and an FFT pays; else 0."""
        samples = self.period / abs(self.step)
        count = round(samples)
        same = abs(samples - count) <= WHOLE * samples
        return count if same and len(self.which) <= count <= SPARSE * self.numbers.size else 0

    @property
    def tiled(self) -> tuple[I64, C128]:
        """Index (m,) of each frequency in the periodic FFT, and the phase factor (m,) of the first sample."""
        numbers = self.numbers if self.step > 0.0 else -self.numbers
        return numbers % self.whole, np.exp((-2j * np.pi / self.period) * self.place[0] * self.numbers)

    def borders(self) -> list[tuple[int, C128]]:
        """Return the samples at the border, each with the transform of its cut spline less that of an uncut spline."""
        frequency = self.frequency
        half = (self.degree + 1) // 2 if self.total else 0
        found = []
        ends = {*range(min(half, self.total)), *range(max(self.total - half, 0), self.total)}
        for i in sorted(ends & {*self.which}):
            first, count = int(self.numbers[0]), self.numbers.size
            wrong = _wrong(
                min(i, FAR_IN), min(self.total - 1 - i, FAR_IN), self.degree, abs(self.step) / self.period, first, count
            )
            if self.step < 0.0:  # the picture is mirrored
                wrong = wrong.conj()
            one = i - self.which.start
            found.append((one, wrong * np.exp(-2j * np.pi * frequency * self.place[one])))
        return found


def _add_both(out: Complex, samples: F64, along_x: _Along, along_y: _Along) -> None:
    """Write the transform (m, n) of samples (rows, cols), by FFTs; the periods are whole numbers of samples."""
    rows = scipy.fft.rfft(samples, along_x.whole, axis=1)
    both = scipy.fft.fft(rows, along_y.whole, axis=0)
    (i, turn_x), (j, turn_y) = along_x.tiled, along_y.tiled
    passes_x, passes_y = along_x.passes * turn_x, along_y.passes * turn_y
    down: list[C128] = []
    across: list[C128] = []
    for row, wrong in along_y.borders():
        down.append(wrong)
        across.append(scipy.fft.fft(samples[row], along_x.whole)[i] * passes_x)
    for column, wrong in along_x.borders():
        line = scipy.fft.fft(samples[:, column], along_y.whole)[j] * passes_y
        for row, other in along_y.borders():
            line += samples[row, column] * other
        down.append(line)
        across.append(wrong)
    added = np.array(down, complex).reshape(-1, j.size), np.array(across, complex).reshape(-1, i.size)
    which, times = (i, j), (passes_x, passes_y)
    shared(len(out), functools.partial(repeat, out, both, along_x.whole, which, times, added), least=ROWS_AT_ONCE)


@functools.lru_cache(maxsize=256)
def _wrong(before: int, after: int, degree: int, step: float, first: int, count: int) -> C128:
    """Return the transform of a cut spline minus that of an uncut one, at evenly spaced frequencies.

    before, after : samples on either side of it;  step: spacing of samples times that of frequencies
    """
    frequency = step * np.arange(first, first + count, dtype=np.float64)
    wrong: C128 = _seen(before, before + after + 1, degree, frequency) - np.sinc(frequency) ** (degree + 1)
    wrong.flags.writeable = False
    return wrong


def _seen(i: int, count: int, degree: int, frequency: F64) -> C128:
    """Return ∫ from 0 to ``count`` of spline i, mirrored at both ends, times exp(−2πi·f·(u − i − ½))."""
    half = 0.5 * (degree + 1)
    low, high = max(0.0, i + 0.5 - half), min(float(count), i + 0.5 + half)
    # Splines are polynomials between knots, which lie halfway between integers.
    knots = distinct(np.concatenate([[low, high], np.arange(math.ceil(low - 0.5), high) + 0.5]))
    knots = knots[(knots >= low) & (knots <= high)]
    # A picture of one sample is its own neighbour's neighbour: it is mirrored twice.
    copies = [at + 2 * count * k for k in (-1, 0, 1) for at in (i, -1 - i)]
    nodes = BORDER_NODES + math.ceil(2.0 * math.pi * float(np.abs(frequency).max(initial=0.0)))
    x, w = gauss_legendre(nodes)
    total = np.zeros(frequency.size, complex)
    for a, b in pairwise(knots.tolist()):
        u = a + 0.5 * (b - a) * (1.0 + x)
        value = sum(_spline(u - 0.5 - at, degree) for at in copies)
        total += np.einsum("fn,n->f", np.exp(-2j * np.pi * np.outer(frequency, u - i - 0.5)), 0.5 * (b - a) * w * value)
    return total


def _spline(t: F64, degree: int) -> F64:
    """Return the B-spline centred at 0, at t in samples."""
    cell = np.floor(t + 0.5 * (degree + 1)).astype(np.int64)
    inside = (cell >= 0) & (cell <= degree)
    place = t + 0.5 * (degree + 1) - cell
    values = basis(degree, place).T
    return np.where(inside, np.take_along_axis(values, np.clip(degree - cell, 0, degree)[:, None], 1)[:, 0], 0.0)
