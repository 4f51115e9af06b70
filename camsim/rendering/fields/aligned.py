"""Pictures whose samples lie along the photosites' rows: plain transforms in place of non-uniform ones.

The transform of a lattice of samples repeats for ever, so one FFT of the samples is the picture at every frequency of
the band. Times the transfer of splines, lens, OLPF and photosite it is the image at these frequencies, whose
period is a whole number of *samples*. From there to the photosites it goes axis by axis, each a sum of waves at places
of its own: only that of channels, not of planes, and only at rows and columns where a channel is looked at.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.nonuniform import lines_at
from camsim.optics import OpticalStage, OpticalSystem
from camsim.optics.protocols import Separable
from camsim.quadrature import chebyshev
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fields.aligned_kernels import Axes, Cells, Columns, lit_columns
from camsim.rendering.fields.light import Lattice
from camsim.rendering.fourier.kernels import Curves
from camsim.rendering.fourier.lens_curves import LensCurves
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.modes import mixed

COLUMNS = 64  # of frequencies at a time
ROWS = 64  # of photosites at a time
CURVES_OFF = 1e-3  # of the tolerance: what polynomials of the transfer may be wrong by, and planes that are left out
NO_LIGHT = 1e-300  # of a Gaussian a hundred spots away
CURVE_POINTS = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class Aligned:
    """A lattice of samples behind a system with a round lens, seen from a window.

    tile       : of the taper, and the periods that keep photosites and samples apart
    density    : (planes, channels, j) of the lattice's planes;  curves: what gives the lens at its wavelengths
    precision  : of the sums of waves, relative
    """

    lattice: Lattice
    tile: Tile
    kernel: Kernel
    density: F64
    curves: LensCurves
    system: OpticalSystem
    pitch_um: float
    tolerance: float
    precision: float

    def image(self, channel: U8) -> F64:
        """Return what the lattice adds to photosites (..., rows, cols), each in its own channel."""
        image = np.empty(channel.shape)
        rows, cols = channel.shape[-2:]
        present = np.unique(channel)
        shared: C128 | None = None
        cells, mixtures = self._cells(present)
        for k, own, mixture in zip(present, cells, mixtures, strict=True):
            mine = channel == k
            over = mine.reshape(-1, rows, cols).any(axis=0)
            seen = np.flatnonzero(over.any(axis=1)), np.flatnonzero(over.any(axis=0))
            if mixture is None:
                shared = self._transforms(self.lattice.light) if shared is None else shared
                transforms = shared
            else:
                transforms = self._transforms(np.einsum("mp,pyx->myx", mixture, self.lattice.light))
            plane = np.zeros((rows, cols))
            plane[np.ix_(*seen)] = self._plane(transforms, own, *seen)
            image[mine] = np.broadcast_to(plane, channel.shape)[mine]
        return image

    @property
    def _counts(self) -> tuple[int, int]:
        """Samples of a period, along x and y."""
        lengths = (fast_length(math.ceil(period / self.lattice.step), real=True) for period in self.tile.periods)
        return max(next(lengths), 2), max(next(lengths), 2)

    def _transforms(self, light: F64) -> C128:
        """Return (modes, count_x//2 + 1, count_y) of lattices (modes, rows, cols)."""
        count_x, count_y = self._counts
        out = np.empty((len(light), count_x // 2 + 1, count_y), complex)
        # A lattice may be longer than the period: what lies a period apart is seen as one.
        for own, whole in zip(out, light, strict=True):
            lattice = _folded(_folded(whole, count_y, 0), count_x, 1)
            own[:, : len(lattice)] = scipy.fft.rfft(lattice, n=count_x, axis=1, workers=-1).T
            own[:, len(lattice) :] = 0.0
            own[...] = scipy.fft.fft(own, axis=1, overwrite_x=True, workers=-1)
        return out

    def _cells(self, present: U8) -> tuple[list[Cells], list[F64 | None]]:
        """Return each channel's transfers, and how planes are mixed for them; None: as they are."""
        allowed, curves = CURVES_OFF * self.tolerance, self.curves.of(self.tile, self.density[:, present])
        # The pattern at r turns by 2πr over a cycle/pitch: Chebyshev's 8 points leave 2·(πrw/2)⁸/8! on cells of w.
        light = min(1.0, max(self.kernel.light(0.5 * self.tile.outer[0]), NO_LIGHT))
        phase = (0.5 * math.factorial(CURVE_POINTS) * allowed / light) ** (1.0 / CURVE_POINTS)
        width = 2.0 * min(phase, 2.0) / (math.pi * self.tile.outer[0])
        count = math.ceil(self.tile.cut / width)
        x = 0.5 * (1.0 + chebyshev(CURVE_POINTS))
        nodes = _at(curves, (np.arange(count)[:, None] + x) * (self.tile.cut / count))  # (cells, 8, planes, channels)
        through = np.linalg.inv(np.vander(x, increasing=True))
        each = [mixed(nodes[..., k].reshape(-1, len(self.density)).T, allowed) for k in range(present.size)]
        several = sum(len(mixture) for _, mixture in each) < len(self.density)
        cells, mixtures = [], []
        for k, (modes, mixture) in enumerate(each):
            own = modes.reshape(len(modes), count, -1) if several else np.moveaxis(nodes[..., k], 2, 0)
            cells.append(Cells(np.ascontiguousarray(np.einsum("dx,mcx->cmd", through, own)), count / self.tile.cut))
            mixtures.append(mixture if several else None)
        return cells, mixtures

    def _plane(self, transforms: C128, cells: Cells, rows: I64, cols: I64) -> F64:
        """Return photosites (rows, cols) of one channel."""
        count_x, count_y = self._counts
        px, py = count_x * self.lattice.step, count_y * self.lattice.step
        columns = math.floor(self.tile.cut * px) + 1
        lines = np.empty((columns, rows.size), complex)
        phases = (2.0 * np.pi / py) * rows.astype(float)

        def down(first: int) -> None:
            some = Columns(first, count_x, px, py, self.tile.cut)
            axes = self._axes(np.arange(first, min(first + COLUMNS, columns)), px, py)
            found = lit_columns(transforms, cells, some, axes)
            lines[first : first + COLUMNS] = lines_at(phases, found, precision=self.precision)

        _each(down, columns, COLUMNS)
        # Frequencies from 0 on: of the whole band's sum the real part, twice.
        lines[0] *= 0.5
        middle = columns // 2
        turn = np.exp(2j * np.pi * ((middle * cols / px) % 1.0)) * (2.0 / (px * py))
        image = np.empty((rows.size, cols.size))

        def across(first: int) -> None:
            some = np.ascontiguousarray(lines[:, first : first + ROWS].T)
            found = lines_at((2.0 * np.pi / px) * cols.astype(float), some, precision=self.precision)
            image[first : first + ROWS] = (found * turn).real

        _each(across, rows.size, ROWS)
        return image

    def _axes(self, i: I64, px: float, py: float) -> Axes:
        """Return what is no function of the lens, on columns i."""
        most = math.floor(py * math.sqrt(max(self.tile.cut**2 - (i[0] / px) ** 2, 0.0)))
        across, down = self._sides
        middle = down.size // 2
        both = np.empty((0, 0), complex)
        fx = i[:, None] / (px * self.pitch_um)
        fy = np.arange(-most, most + 1)[None] / (py * self.pitch_um)
        for stage in self._stages(separable=False):
            values = np.broadcast_to(stage.otf(fx, fy, 0.0), (i.size, fy.size))
            both = both * values if both.size else values.astype(complex)
        return Axes(across[i[0] : i[-1] + 1], down[middle - most : middle + most + 1], both)

    @cached_property
    def _sides(self) -> tuple[C128, C128]:
        """What is a function of kx times one of ky: on all columns from 0 on, and on j = −most … most."""
        px, py = (count * self.lattice.step for count in self._counts)
        columns, most = math.floor(self.tile.cut * px) + 1, math.floor(self.tile.cut * py)
        zero, sides = np.zeros((1, 1)), []
        for k, at in zip((np.arange(columns) / px, np.arange(-most, most + 1) / py), self.lattice.first, strict=True):
            spline = np.sinc(self.lattice.step * k) ** (self.lattice.degree + 1)
            sides.append(spline * np.exp(-2j * np.pi * ((k * at) % 1.0)))
            f = k / self.pitch_um
            for stage in self._stages(separable=True):
                along = stage.otf(zero, f[:, None], 0.0) if len(sides) > 1 else stage.otf(f[:, None], zero, 0.0)
                sides[-1] = sides[-1] * along[:, 0]
        return sides[0], sides[1]

    def _stages(self, *, separable: bool) -> list[OpticalStage]:
        """Return OLPF and photosite: those whose transfer is a function of fx times one of fy, or the others."""
        stages = [stage for stage in (self.system.olpf, self.system.photosite) if stage is not None]
        return [stage for stage in stages if (isinstance(stage, Separable) and stage.separable) == separable]


def _folded(values: F64, count: int, axis: int) -> F64:
    """Add up what lies ``count`` apart along an axis, if that is longer."""
    size = values.shape[axis]
    if size <= count:
        return values
    parts = [np.take(values, range(first, min(first + count, size)), axis=axis) for first in range(0, size, count)]
    total = np.moveaxis(parts[0], axis, 0)
    for part in parts[1:]:
        total[: part.shape[axis]] += np.moveaxis(part, axis, 0)
    return parts[0]


def _at(curves: Curves, frequency: F64) -> F64:
    """Return (..., planes, channels): piecewise polynomials at frequencies (...)."""
    place = frequency * curves.per_frequency
    cell = np.minimum(place.astype(int), len(curves.cells) - 1)
    t = (place - cell)[..., None, None]
    total = np.zeros((*frequency.shape, *curves.cells.shape[1:3]))
    for power in range(curves.cells.shape[3] - 1, -1, -1):
        total = total * t + curves.cells[cell, :, :, power]
    return total


def _each(do: Callable[[int], None], count: int, size: int) -> None:
    """Do parts of one size: numbers do not depend on how threads share them."""

    def work(low: int, high: int) -> None:
        for part in range(low, high):
            do(part * size)

    shared(-(-count // size), work)
