"""An image as a sum over spatial frequencies: transforms of sources times transfers, by level and by tile."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import scipy

from camsim.core.arrays import C128, F64, I64, Complex, Floats, kinds_of
from camsim.core.cached import cached_property
from camsim.core.kernels import shared
from camsim.numerics.matrix_products import complex_product
from camsim.numerics.nonuniform import complex_type
from camsim.rendering.waves.kernels import add_curves, add_polar, between
from camsim.rendering.waves.levels import Lattice, Level, lattice_of
from camsim.rendering.waves.transfers import Footprint, Lens

TILE = 512  # photosites along a tile's side
FEW_ROWS = 64  # rows of photosites up to which each is summed directly rather than by an FFT over the period
MOST_AT_ONCE = 1 << 24  # frequencies, of all kinds of light, of one part of a transform that is computed in parts
ROWS_OF_PLANE = 400_000  # frequencies whose transfers are evaluated at a time


class Source(Protocol):
    """Light in the plane of the sensor, of one or several kinds."""

    @property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner (2,) of its bounding box, pitches from the optical axis."""
        ...

    @property
    def whole(self) -> int:
        """A length in pitches; for speed, a lattice's period should be a multiple of it."""
        ...

    @property
    def in_parts(self) -> bool:
        """Whether it can transform parts of a lattice."""
        ...

    @property
    def precision(self) -> float:
        """Relative error of its transforms."""
        ...

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> Complex | None:
        """Return the source's transform (kinds, n, m) about an origin, at a lattice's j and i = 0 …; None: no light."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class FrequencyImage:
    """Sources behind one lens.

    sources : each with the weights of its kinds (kinds, channels, j), and the lens at the wavelength nodes j
    leak    : relative error allowed to interpolation between a coarse level's points
    """

    sources: Sequence[tuple[Source, F64, Lens]]
    footprint: Footprint
    levels: Sequence[Level]
    leak: float

    def planes(self, origin: tuple[float, float], shape: tuple[int, int]) -> Iterator[tuple[slice, slice, F64]]:
        """Yield tiles of the image: rows, columns, and the light (channels, rows, cols) to add to the background."""
        channels = self.sources[0][1].shape[1]
        near = [level for level in self.levels if level.near]
        far, every = self._far(self.levels[len(near) :], origin, shape, channels)
        for row, col, height, width in tiles(shape):
            at = origin[0] + col, origin[1] + row
            image = self._part(near[0], at, (width, height), channels)
            for level in near[1:]:
                image += self._part(level, at, (width, height), channels)
            part = slice(row, row + height), slice(col, col + width)
            if far is not None:
                image += self._between(far, every, part)
            yield *part, image

    def at(self, origin: tuple[float, float], rows: I64, cols: I64, side: int) -> F64:
        """Return the light (channels, n) to add to the background at n photosites of a frame.

        Each cell of ``side`` photosites, at most those of a tile, is a frame of its own.
        """
        out = np.empty((self.sources[0][1].shape[1], rows.size))
        which = cells_of(rows, cols, side)
        for cell in range(int(which.max(initial=-1)) + 1):
            here = np.flatnonzero(which == cell)
            row, col = int(rows[here].min()), int(cols[here].min())
            shape = int(rows[here].max()) + 1 - row, int(cols[here].max()) + 1 - col
            ((_, _, image),) = self.planes((origin[0] + col, origin[1] + row), shape)
            out[:, here] = image[:, rows[here] - row, cols[here] - col]
        return out

    def _far(
        self, levels: Sequence[Level], origin: tuple[float, float], shape: tuple[int, int], channels: int
    ) -> tuple[F64 | None, int]:
        """Return the sum of coarse levels, on the points of the finest with a margin around the frame.

        Each level, from the coarsest on, is interpolated to the points of the next finer one and added to it. The
        spacing of the points comes second.
        """
        far, before = None, 1
        for level in reversed(levels):
            every, beyond = level.every, len(self.taps(1)[0])
            counts = [-(-n // every) + 2 * beyond for n in shape]
            at = origin[0] - beyond * every, origin[1] - beyond * every
            one = self._part(level, at, (every * (counts[1] - 1) + 1, every * (counts[0] - 1) + 1), channels)
            if far is not None:
                parts = tuple(slice(-beyond, count - beyond) for count in counts)
                one += self._between(far, before // every, (parts[0], parts[1]))
            far, before = one, every
        return far, before

    def _between(self, coarse: F64, every: int, part: tuple[slice, slice]) -> F64:
        """Return a coarse level interpolated at a finer grid, ``every`` times as dense."""
        taps, beyond = self.taps(every), len(self.taps(1)[0])
        for axis, one in ((1, part[0]), (2, part[1])):
            first, phase = np.divmod(np.arange(one.start, one.stop), every)
            if every == 1:
                coarse = np.take(coarse, first + beyond, axis=axis)
                continue
            first += beyond - beyond // 2 + 1
            shape = list(coarse.shape)
            shape[axis] = first.size
            values = np.zeros(shape)
            shared(shape[1], functools.partial(between, coarse, axis == 1, first, taps[phase], values))
            coarse = values
        return coarse

    def taps(self, every: int) -> F64:
        """Return weights (every, taps) of interpolation: a sinc with a Kaiser window, for half of the Nyquist band."""
        return _taps(every, self.leak)

    def _part(self, level: Level, at: tuple[float, float], size: tuple[int, int], channels: int) -> F64:
        """Return a level (channels, rows, cols) at the points of a part of the frame; size: along x and y."""
        out = np.zeros((channels, *(-(-count // level.every) for count in size[::-1])))
        for one, plane in zip(out, self.each(level, at, size, channels), strict=False):  # none without light
            one[:] = plane
        return out

    def each(self, level: Level, at: tuple[float, float], size: tuple[int, int], channels: int) -> Iterator[Floats]:
        """Yield a level's image of each channel (rows, cols), as of ``_part``; nothing if there is no light."""
        every, rows = level.every, -(-size[1] // level.every)
        low, high = (np.array(one) for one in self.box)
        whole = max(source.whole for source, *_ in self.sources)
        lattice = lattice_of(level, size, low - at, high - at, whole)
        total = np.zeros((channels, *summed_shape(lattice, every, rows)), complex_type(self.precision))
        found = False
        most = MOST_AT_ONCE / max(len(weights) for _, weights, _ in self.sources)
        for some in lattice.parts(most) if self.in_parts else (lattice,):
            footprint = self.footprint.on(some)
            for source, weights, lens in self.sources:
                transform = source.transform(some, at)
                if transform is None:
                    continue
                found = True
                self._add(total, transform, level, some, (weights, lens), footprint)
        if found:
            yield from _photosites(total, every, lattice.periods, (rows, -(-size[0] // every)))

    def _add(
        self,
        total: Complex,
        transform: Complex,
        level: Level,
        lattice: Lattice,
        behind: tuple[F64, Lens],
        footprint: tuple[C128, C128, C128],
    ) -> None:
        weights, lens = behind
        step_x, step_y = (1.0 / period for period in lattice.periods)
        share = level.shares(self.leak)
        if lens.is_round:
            curves, per = self._table("curves", level, weights, lens)
            scale = step_x, step_y, per
            work = functools.partial(add_curves, total, transform, curves, footprint, share, scale, lattice.rows.start)
        elif lens.is_pupil:
            (polar, there), per, turn = self._table("polar", level, weights, lens)
            parts, steps = (polar.view(polar.real.dtype), there), (step_x, step_y, per, lattice.cut)
            real, first = np.isrealobj(polar), lattice.rows.start
            work = functools.partial(add_polar, total, transform, *parts, real, footprint, share, steps, turn, first)
        else:
            self._add_planes(total, transform, level, lattice, behind, footprint, share)
            return
        shared(total.shape[1], work)

    def _add_planes(
        self,
        total: Complex,
        transform: Complex,
        level: Level,
        lattice: Lattice,
        behind: tuple[F64, Lens],
        footprint: tuple[C128, C128, C128],
        share: tuple[F64, float],
    ) -> None:
        """Add the product with a lens that is known only by its ``otf``, evaluated row by row."""
        (weights, lens), columns, rows = behind, lattice.counts[0], lattice.rows
        across, down, both = footprint
        fx = np.arange(columns) / lattice.periods[0]
        half = np.where(np.arange(columns) == 0, 0.5, 1.0) * across
        values, per = share
        shape = total.shape[1]
        step = max(1, ROWS_OF_PLANE // columns)
        for first in range(rows.start, rows.stop, step):
            j = np.arange(first, min(first + step, rows.stop))
            fy = j[:, None] / lattice.periods[1]
            radius = np.hypot(fx, fy)
            times = np.interp(radius * per, np.arange(len(values)), values) * (radius <= lattice.cut)
            one = times * half * down[j - rows.start, None]
            if both.size:
                one = one * both[j - rows.start]
            plane = lens.plane(weights, fx[None, :], fy)
            added = np.einsum("kji,kcji->cji", transform[:, j - rows.start], plane) * one
            for row, line in zip(j.tolist(), np.moveaxis(added, 1, 0), strict=True):
                for begin in range(0, columns, total.shape[2]):
                    part = line[:, begin : begin + total.shape[2]]
                    total[:, row % shape, : part.shape[1]] += part

    def _table(self, kind: str, level: Level, weights: F64, lens: Lens) -> Any:
        key = kind, level, id(weights)
        if key not in self._tables:
            table = getattr(lens, kind)(level, weights)
            if kind == "polar":
                (polar, there), *scale = table
                precise = np.zeros(0, complex_type(self.precision))
                precise = precise if np.iscomplexobj(polar) else precise.real
                table = (polar.astype(precise.dtype, copy=False), there), *scale
            self._tables[key] = table
        return self._tables[key]

    @cached_property
    def _tables(self) -> dict[tuple[str, Level, int], Any]:
        return {}

    @property
    def in_parts(self) -> bool:
        """Whether all sources can transform parts of a lattice."""
        return all(source.in_parts for source, *_ in self.sources)

    @property
    def precision(self) -> float:
        """The finest precision of a source."""
        return min(source.precision for source, *_ in self.sources)

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner of all sources."""
        boxes = [source.box for source, *_ in self.sources]
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


def cells_of(rows: I64, cols: I64, side: int) -> I64:
    """Return the cell (n,), from 0 on, of photosites among cells of ``side`` photosites."""
    return kinds_of(rows // side + 1j * (cols // side))[1]


def summed_shape(lattice: Lattice, every: int, height: int) -> tuple[int, int]:
    """Return rows and columns of the array in which frequencies are summed, for ``height`` rows of photosites."""
    (px, py), (columns, rows) = (period // every for period in lattice.periods), lattice.counts
    return min(2 * rows - 1 if height <= FEW_ROWS else py, py), min(columns, px)


def _photosites(total: Complex, every: int, periods: tuple[int, int], shape: tuple[int, int]) -> Iterator[Floats]:
    """Yield the real images (rows, cols) of transforms (n, …) that are given on a half plane.

    Columns are transformed by an FFT, or by direct sums where there are few rows and frequencies do not alias.
    """
    (px, py), lines, (rows, cols) = (period // every for period in periods), total.shape[1], shape
    cycles = np.outer(np.arange(rows), np.rint(np.fft.fftfreq(lines, 1.0 / lines))) % py
    # Products in single precision would differ by processor.
    waves = np.exp(1j * (2.0 * np.pi / py * cycles)) / py if lines < py else None
    for whole in total:
        columns: Complex = (
            scipy.fft.ifft(whole, axis=0, overwrite_x=True)[:rows] if waves is None else complex_product(waves, whole)
        )
        # The real part of a sum over all frequencies, as one over those up to Nyquist, of which only the first and
        # Nyquist's itself have no counterpart.
        half = columns[:, : px // 2 + 1]
        beyond = columns[:, px // 2 + 1 :]
        half[:, px - px // 2 - beyond.shape[1] : px - px // 2] += beyond[:, ::-1].conj()
        half[:, 0] *= 2.0
        if px % 2 == 0 and half.shape[1] == px // 2 + 1:
            half[:, -1] *= 2.0
        image = scipy.fft.irfft(half, px, axis=1)[:, :cols]
        image *= 1.0 / every**2
        yield image


def tiles(shape: tuple[int, int]) -> Iterator[tuple[int, int, int, int]]:
    """Yield row, column, height and width of each of some tiles of about equal size."""
    heights, widths = (_parts(length) for length in shape)
    for row, height in heights:
        for col, width in widths:
            yield row, col, height, width


def _parts(length: int) -> list[tuple[int, int]]:
    count = max(1, math.ceil(length / (1.3 * TILE)))
    # Symmetric: behind a lens of revolution, tiles on either side of its axis share their transfers.
    ends = [length * k // count if 2 * k <= count else length - length * (count - k) // count for k in range(count + 1)]
    return [(a, b - a) for a, b in pairwise(ends)]


@functools.lru_cache(maxsize=64)
def _taps(every: int, leak: float) -> F64:
    decibels = -20.0 * math.log10(leak)
    half = math.ceil((decibels - 7.95) / (2.0 * 14.36 * 0.5)) + 1
    place = np.arange(every)[:, None] / every - (np.arange(2 * half) - half + 1)
    beta = 0.1102 * max(decibels - 8.7, 0.0)
    window = np.i0(beta * np.sqrt(np.maximum(1.0 - (place / half) ** 2, 0.0))) / np.i0(beta)
    return np.asarray(np.sinc(place) * window)
