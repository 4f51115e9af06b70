"""Pictures, gradients and points as sources."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kept import cached_property
from camsim.nonuniform import modes, modes_of_lines
from camsim.quadrature import gauss_legendre
from camsim.rendering.fields.layer import Layer, basis
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import Splines, splines_of
from camsim.rendering.waves.edges import half_plane, phases
from camsim.rendering.waves.levels import Lattice

SAMPLES_OF_WAVE = 4.0  # that a coarser copy of the samples has, of the highest frequency, at the least
BORDER_NODES = 24  # of a rule on a sample at a picture's border, and more the more waves there are on it


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldSource:
    """A picture, a gradient or points.

    layer     : its samples, placed
    mixture   : (kinds, planes) which mixtures of its planes are transformed
    cut       : highest frequency that is ever asked, cycles/pitch
    precision : relative
    """

    layer: Layer | PointLayer
    mixture: F64
    cut: float
    precision: float

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corners."""
        corners = self.layer.corners
        return corners.min(axis=0), corners.max(axis=0)

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> C128 | None:
        """Return the transform of each mixture of planes."""
        layer = self.layer
        columns, rows = lattice.counts
        out = np.zeros((len(self.mixture), 2 * rows - 1, columns), complex)
        if isinstance(layer, PointLayer):
            return out if self._add_points(out, layer.at, self._mixed(layer.light), lattice, origin) else None
        if layer.upright and layer.outline is None:
            return out if self._upright(out, lattice, origin) else None
        splines = self._splines
        while 1.0 / (lattice.cut * splines.step) >= 2.0 * SAMPLES_OF_WAVE:
            splines = self._coarser(splines)
        there = self._add_points(out, splines.places, splines.light, lattice, origin)
        if there:
            fx = np.arange(columns) / lattice.periods[0]
            fy = np.arange(1 - rows, rows)[:, None] / lattice.periods[1]
            for axis in layer.axes:
                out *= splines.passes(fx * axis[0] + fy * axis[1])
        there |= self._add_points(out, splines.points, splines.corrections, lattice, origin)
        return out if there else None

    def _mixed(self, planes: F64) -> F64:
        """Return mixtures (kinds, …) of planes; no BLAS, whose last bits differ between processors."""
        if np.array_equal(self.mixture, np.eye(len(planes))):
            return planes
        mixed: F64 = np.einsum("kp,p...->k...", self.mixture, planes)
        return mixed

    @cached_property
    def _splines(self) -> Splines:
        assert isinstance(self.layer, Layer)
        found = splines_of(self.layer, cut=self.cut, allowed=self.precision)
        return found._replace(light=self._mixed(found.light), corrections=self._mixed(found.corrections))

    def _coarser(self, splines: Splines) -> Splines:
        """Return half as many samples each way that have the same low frequencies, kept."""
        if splines.step not in self._copies:
            self._copies[splines.step] = splines.halved(self.precision)
        return self._copies[splines.step]

    @cached_property
    def _copies(self) -> dict[float, Splines]:
        return {}

    def _add_points(self, out: C128, places: F64, light: F64, lattice: Lattice, origin: tuple[float, float]) -> bool:
        """Add points of light (kinds, n) that lie in the lattice's box; return whether there are any."""
        places, light = places.reshape(-1, 2), light.reshape(len(light), -1)
        at = places - np.array(origin)
        inside = ((at >= np.array(lattice.low)) & (at <= np.array(lattice.high))).all(axis=1)
        if not inside.any():
            return False
        if not inside.all():
            at, light = at[inside], light[:, inside]
        down, across = phases(at, lattice)
        turn = half_plane(np.ones(1, complex), across, out.shape[2])
        for own, values in zip(out, light, strict=True):
            if values.any():
                own += modes((down, across), turn * values, own.shape, precision=self.precision, sign=-1)
        return True

    def _upright(self, out: C128, lattice: Lattice, origin: tuple[float, float]) -> bool:
        """Add a picture whose rows lie along the photosites', all of it seen: along its rows, then along columns."""
        layer = self.layer
        assert isinstance(layer, Layer)
        turned = layer.axes[0, 0] == 0.0  # its rows lie along y
        planes = layer.kept(turned)
        x_axis, y_axis = (layer.axes[1], layer.axes[0]) if turned else (layer.axes[0], layer.axes[1])
        columns, rows = lattice.counts
        numbers = np.arange(columns), np.arange(1 - rows, rows)
        each = []
        for axis, (sign, count) in enumerate(((x_axis[0], planes.shape[2]), (y_axis[1], planes.shape[1]))):
            first = layer.corner[axis] - origin[axis] + 0.5 * sign * layer.step
            place = first + sign * layer.step * np.arange(count)
            inside = np.flatnonzero((place >= lattice.low[axis]) & (place <= lattice.high[axis]))
            if not inside.size:
                return False
            each.append(
                _Along(
                    place[inside[0] : inside[-1] + 1],
                    range(int(inside[0]), int(inside[-1]) + 1),
                    count,
                    sign * layer.step,
                    layer.degree,
                    lattice.periods[axis],
                    numbers[axis],
                )
            )
        along_x, along_y = each
        part = planes[:, along_y.which.start : along_y.which.stop, along_x.which.start : along_x.which.stop]
        for own, samples in zip(out, self._mixed(part), strict=True):
            lines = along_x.transformed(np.ascontiguousarray(samples), self.precision)
            own[:] = along_y.transformed(np.ascontiguousarray(lines.T), self.precision).T
        out *= layer.step**2
        return True


class _Along(NamedTuple):
    """Splines along one axis, cut at the picture's border, where the samples are mirrored.

    place : (n,) of samples;  which: of all ``total``;  step: signed, pitches;  numbers: (m,) frequencies times period
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
        frequency = self.numbers / self.period
        middle = int(self.numbers[self.numbers.size // 2])
        phase = (2.0 * np.pi / self.period) * self.place
        strengths = lines * np.exp(-1j * middle * phase)
        out = modes_of_lines(phase, strengths, self.numbers.size, precision=precision)
        out *= np.sinc(self.step * frequency) ** (self.degree + 1)
        for i, wrong in self._borders(frequency):
            out += lines[:, i, None] * wrong
        return out

    def _borders(self, frequency: F64) -> list[tuple[int, C128]]:
        """Return samples at the border, and by how much what is seen of them differs from whole splines."""
        half = (self.degree + 1) // 2
        found = []
        ends = {*range(min(half, self.total)), *range(max(self.total - half, 0), self.total)}
        for i in sorted(ends & {*self.which}):
            wrong = _seen(i, self.total, self.degree, abs(self.step) * frequency) - np.sinc(self.step * frequency) ** (
                self.degree + 1
            )
            if self.step < 0.0:  # the picture runs the other way
                wrong = wrong.conj()
            own = i - self.which.start
            found.append((own, wrong * np.exp(-2j * np.pi * frequency * self.place[own])))
        return found


def _seen(i: int, count: int, degree: int, frequency: F64) -> C128:
    """Return ∫ of spline i, mirrored at 0 and at ``count`` and seen between them, times exp(−2πi·f·(u − i − ½))."""
    half = 0.5 * (degree + 1)
    low, high = max(0.0, i + 0.5 - half), min(float(count), i + 0.5 + half)
    # Between knots, which lie half a sample off whole numbers, splines are polynomials.
    knots = np.unique(np.concatenate([[low, high], np.arange(math.ceil(low - 0.5), high) + 0.5]))
    knots = knots[(knots >= low) & (knots <= high)]
    nodes = BORDER_NODES + math.ceil(2.0 * math.pi * float(np.abs(frequency).max(initial=0.0)))
    x, w = gauss_legendre(nodes)
    total = np.zeros(frequency.size, complex)
    for a, b in pairwise(knots.tolist()):
        u = a + 0.5 * (b - a) * (1.0 + x)
        value = sum(_spline(u - 0.5 - at, degree) for at in (i, -1 - i, 2 * count - 1 - i))
        total += np.exp(-2j * np.pi * np.outer(frequency, u - i - 0.5)) @ (0.5 * (b - a) * w * value)
    return total


def _spline(t: F64, degree: int) -> F64:
    """Return the B-spline about 0 at t, in samples."""
    cell = np.floor(t + 0.5 * (degree + 1)).astype(np.int64)
    inside = (cell >= 0) & (cell <= degree)
    place = t + 0.5 * (degree + 1) - cell
    values = basis(degree, place)
    return np.where(inside, np.take_along_axis(values, np.clip(degree - cell, 0, degree)[:, None], 1)[:, 0], 0.0)
