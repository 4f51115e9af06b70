"""An image as a sum over spatial frequencies: sources × transfers, level by level, tile by tile."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.rendering.waves.kernels import add_curves, add_polar, between, channels_first
from camsim.rendering.waves.levels import Lattice, Level, lattice_of
from camsim.rendering.waves.transfers import Footprint, Lens

TILE = 512  # photosites along a tile's side
ROWS_OF_PLANE = 400_000  # frequencies whose transfers are asked at a time


class Source(Protocol):
    """Light in the plane of the sensor, of one or several kinds."""

    @property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner (2,) of all of it, pitches from the optical axis."""
        ...

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> C128 | None:
        """Return its transform (kinds, 2n − 1, m) at j = −n … n, i = 0 … m, from an origin; None: nothing there."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class FrequencyImage:
    """Sources behind one lens.

    sources : each with what its kinds give (kinds, channels, j), and the lens at these wavelengths
    leak    : what interpolation between a coarse level's points may leave, of its light
    """

    sources: Sequence[tuple[Source, F64, Lens]]
    footprint: Footprint
    levels: Sequence[Level]
    leak: float

    def planes(self, origin: tuple[float, float], shape: tuple[int, int]) -> Iterator[tuple[slice, slice, F64]]:
        """Yield tiles of the image: rows, columns, and (channels, rows, cols) of light added to the background."""
        channels = self.sources[0][1].shape[1]
        far, every = self._far(origin, shape, channels)
        for row, col, height, width in tiles(shape):
            image = self._part(self.levels[0], (origin[0] + col, origin[1] + row), (width, height), channels)
            part = slice(row, row + height), slice(col, col + width)
            if far is not None:
                image += self._between(far, every, part)
            yield *part, image

    def _far(self, origin: tuple[float, float], shape: tuple[int, int], channels: int) -> tuple[F64 | None, int]:
        """Return all levels but the first, on the points of the second, which go some way beyond the frame.

        The coarsest is interpolated at the points of the one before it, to which it is added, and so on.
        """
        far, before = None, 1
        for level in reversed(self.levels[1:]):
            every, beyond = level.every, len(self.taps(1)[0])
            counts = [-(-n // every) + 2 * beyond for n in shape]
            at = origin[0] - beyond * every, origin[1] - beyond * every
            own = self._part(level, at, (every * (counts[1] - 1) + 1, every * (counts[0] - 1) + 1), channels)
            if far is not None:
                parts = tuple(slice(-beyond, count - beyond) for count in counts)
                own += self._between(far, before // every, (parts[0], parts[1]))
            far, before = own, every
        return far, before

    def _between(self, coarse: F64, every: int, part: tuple[slice, slice]) -> F64:
        """Return a coarse level at places of a finer one, of which every so many are its own points."""
        taps, beyond = self.taps(every), len(self.taps(1)[0])
        for axis, own in ((1, part[0]), (2, part[1])):
            first, phase = np.divmod(np.arange(own.start, own.stop), every)
            if every == 1:
                coarse = (
                    coarse[:, first[0] + beyond : first[-1] + beyond + 1]
                    if axis == 1
                    else coarse[:, :, first[0] + beyond : first[-1] + beyond + 1]
                )
                continue
            first += beyond - beyond // 2 + 1
            shape = list(coarse.shape)
            shape[axis] = first.size
            values = np.zeros(shape)
            rows = values.shape[1]
            shared(rows, functools.partial(between, coarse, axis == 1, first, taps[phase], values))
            coarse = values
        return coarse

    def taps(self, every: int) -> F64:
        """Return weights (every, taps) of neighbours: a sine cardinal under a Kaiser window, for half of the band."""
        return _taps(every, self.leak)

    def _part(self, level: Level, at: tuple[float, float], size: tuple[int, int], channels: int) -> F64:
        """Return (channels, rows, cols) of every so many photosites of a part of the frame; size: along x and y."""
        every = level.every
        out = np.zeros((channels, -(-size[1] // every), -(-size[0] // every)))
        low, high = (np.array(own) for own in self.box)
        lattice = lattice_of(level, size, low - at, high - at)
        px, py = lattice.periods
        total = np.zeros((channels, py // every, px // every), complex)
        found = False
        footprint = self.footprint.on(lattice)
        for source, weights, lens in self.sources:
            transform = source.transform(lattice, at)
            if transform is None:
                continue
            found = True
            self._add(total, transform, level, lattice, (weights, lens), footprint)
        if found:
            _photosites(total, every, out)
        return out

    def _add(
        self,
        total: C128,
        transform: C128,
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
            work = functools.partial(add_curves, total, transform, curves, footprint, share, (step_x, step_y, per))
        elif lens.is_pupil:
            (polar, there), per = self._table("polar", level, weights, lens)
            # Channels last, and real and imaginary parts as numbers of their own: see there.
            sums = np.zeros((*total.shape[1:], 2 * len(total)))
            parts = polar.view(np.float64)
            work = functools.partial(add_polar, sums, transform, parts, there, footprint, share, (step_x, step_y, per))
            shared(total.shape[1], work)
            shared(total.shape[1], functools.partial(channels_first, sums, total))
            return
        else:
            self._add_planes(total, transform, level, lattice, behind, footprint, share)
            return
        shared(total.shape[1], work)

    def _add_planes(
        self,
        total: C128,
        transform: C128,
        level: Level,
        lattice: Lattice,
        behind: tuple[F64, Lens],
        footprint: tuple[C128, C128, C128],
        share: tuple[F64, float],
    ) -> None:
        """Add what a lens passes that is known by its transfer alone, asked row by row."""
        (weights, lens), (columns, rows) = behind, lattice.counts
        across, down, both = footprint
        fx = np.arange(columns) / lattice.periods[0]
        half = np.where(np.arange(columns) == 0, 0.5, 1.0) * across
        values, per = share
        shape = total.shape[1]
        step = max(1, ROWS_OF_PLANE // columns)
        for first in range(1 - rows, rows, step):
            j = np.arange(first, min(first + step, rows))
            fy = j[:, None] / lattice.periods[1]
            radius = np.hypot(fx, fy)
            times = np.interp(radius * per, np.arange(len(values)), values) * (radius <= lattice.cut)
            own = times * half * down[j + rows - 1, None]
            if both.size:
                own = own * both[j + rows - 1]
            plane = lens.plane(weights, fx[None, :], fy)
            added = np.einsum("kji,kcji->cji", transform[:, j + rows - 1], plane) * own
            for row, line in zip(j.tolist(), np.moveaxis(added, 1, 0), strict=True):
                for begin in range(0, columns, total.shape[2]):
                    part = line[:, begin : begin + total.shape[2]]
                    total[:, row % shape, : part.shape[1]] += part

    def _table(self, kind: str, level: Level, weights: F64, lens: Lens) -> tuple[Any, float]:
        key = kind, id(level), id(weights)
        if key not in self._tables:
            self._tables[key] = getattr(lens, kind)(level, weights)
        table: tuple[Any, float] = self._tables[key]
        return table

    @cached_property
    def _tables(self) -> dict[tuple[str, int, int], Any]:
        return {}

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner of all light."""
        boxes = [source.box for source, *_ in self.sources]
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


def _photosites(total: C128, every: int, out: F64) -> None:
    """Add the image of which there is half of the transform (n, …) at every so many photosites (n, rows, cols)."""
    scale = 2.0 / every**2
    for own, whole in zip(out, total, strict=True):
        columns = scipy.fft.ifft(whole, axis=0, overwrite_x=True)[: own.shape[0]]
        own += scipy.fft.ifft(columns, axis=1)[:, : own.shape[1]].real * scale


def tiles(shape: tuple[int, int]) -> Iterator[tuple[int, int, int, int]]:
    """Yield row, column, height and width of tiles, all about as large."""
    heights, widths = (_parts(length) for length in shape)
    for row, height in heights:
        for col, width in widths:
            yield row, col, height, width


def _parts(length: int) -> list[tuple[int, int]]:
    count = max(1, math.ceil(length / (1.3 * TILE)))
    ends = [length * k // count for k in range(count + 1)]
    return [(a, b - a) for a, b in pairwise(ends)]


@functools.lru_cache(maxsize=64)
def _taps(every: int, leak: float) -> F64:
    decibels = -20.0 * math.log10(leak)
    half = math.ceil((decibels - 7.95) / (2.0 * 14.36 * 0.5)) + 1
    place = np.arange(every)[:, None] / every - (np.arange(2 * half) - half + 1)
    beta = 0.1102 * max(decibels - 8.7, 0.0)
    window = np.i0(beta * np.sqrt(np.maximum(1.0 - (place / half) ** 2, 0.0))) / np.i0(beta)
    return np.asarray(np.sinc(place) * window)
