"""The difference's transfers from patterns on a lattice, where harmonics about the move would be many.

What lies r λN off the move goes round as often as 2πr times: a coma of two waves takes some hundred harmonics, each of
which every frequency of a window would look up. Samples of the plane are as many as the band asks for, whatever lies
where.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.gridded import PER_WAVE, is_large
from camsim.kept import cached_property
from camsim.kernels import ahead, shared
from camsim.kernels.folded import add_folded
from camsim.kernels.round import add_round
from camsim.nonuniform import at_points
from camsim.quintics import quintic_cells
from camsim.rendering.aberrated.transfers import ShortTransfers
from camsim.rendering.aberrated.window_kernels import frequencies_within
from camsim.rendering.engine import MEMORY_LIMIT_BYTES
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier import prices
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.psf import OF_LIGHT

HEM_CELLS = 4096  # of a taper's radius: its quintics are right to 1e-13 where its width is an eighth of it
# Seconds: of a pattern's sample on a small lattice, of a transform's point, and of a frequency that is none of its own.
PER_SAMPLE, PER_FREQUENCY, PER_SUM = 8e-8, 2e-8, 1e-7
AT_ONCE, WORTH_THREADS = 4, 2_000_000  # small patterns on threads of their own, if they have so many samples in all


@dataclass(frozen=True, eq=False)
class PlaneTransfers:
    """Transfers of patterns of several weight sets, those that ``of`` has over radius and angle."""

    of: ShortTransfers

    @property
    def weights(self) -> F64:
        """Weights (b, j) that patterns are added up with."""
        return self.of.weights

    @property
    def made_over(self) -> str:
        """What its patterns are made over, for whoever asks how it is rendered."""
        return f"on a lattice of {self._side} × {self._side} samples"

    @cached_property
    def _size(self) -> int:
        """Samples along a period."""
        return fast_length(math.ceil(PER_WAVE * self.of.settings.cut * self.of.settings.period) + 1)

    @property
    def _step(self) -> float:
        return self.of.settings.period / self._size

    @property
    def _half(self) -> int:
        """Samples to either side of the move."""
        return math.floor(self.of.settings.outer / self._step)

    @property
    def _side(self) -> int:
        """Samples along a side of a pattern."""
        return 2 * self._half + 1

    @property
    def _numbers(self) -> F64:
        """Samples' numbers along a side, 0 at the move."""
        numbers: F64 = np.arange(float(self._side)) - self._half
        return numbers

    @cached_property
    def patterns(self) -> F64:
        """Patterns (b, n, n) about the move, tapered: what a cell of the lattice has of the light."""
        place_um = self._step * self.of.pitch_um * self._numbers
        x_um, y_um = (place_um + moved_um for moved_um in self.of.rest.moved_um)
        out = np.zeros((len(self.weights), place_um.size, place_um.size))

        def rows_of(nm: float) -> Iterator[tuple[slice, F64]]:
            return self.of.rest.point_spread_rows(x_um, y_um, nm, OF_LIGHT * self.of.allowed)

        def whole(nm: float) -> list[tuple[slice, F64]]:
            return list(rows_of(nm))

        # Large ones have threads by themselves, and are not held whole; few small ones are not worth any.
        every_nm, side = self.of.wavelength_nm.tolist(), self._side
        alone = is_large((side, side)) or len(every_nm) * side**2 < WORTH_THREADS
        each = map(rows_of, every_nm) if alone else ahead(whole, every_nm, AT_ONCE)
        for some, shares in zip(each, self.weights.T.tolist(), strict=True):
            for rows, pattern in some:
                for own, share in zip(out, shares, strict=True):
                    if share:
                        own[rows] += share * pattern
        out *= self._hem()
        return out

    def _hem(self) -> F64:
        """Return the taper on the lattice, times a cell's area in µm²."""
        settings, step = self.of.settings, self.of.settings.outer / HEM_CELLS
        radius = step * np.abs(np.arange(-2.0, math.ceil(math.sqrt(2.0) * HEM_CELLS) + 4.0))
        area_um2 = (self._step * self.of.pitch_um) ** 2
        shape = tapered(radius, settings.reach, settings.outer, taper(settings.sharpness))
        cells, place = quintic_cells(area_um2 * shape), self._step / step * self._numbers
        hem = np.zeros((place.size, place.size))
        shared(len(hem), lambda begin, stop: add_round(hem[begin:stop], cells, 0.0, place, place[begin:stop]))
        return hem

    def at(self, fx: F64, fy: F64) -> C128:
        """Return the transfers (b, places) at places (n,)."""
        phases = 2.0 * np.pi * self._step * fy, 2.0 * np.pi * self._step * fx
        allowed = self.of.allowed
        each = [at_points(phases, own.astype(complex), precision=allowed, sign=-1) for own in self.patterns]
        return np.stack(each)

    def on_window(self) -> F64:
        """Return the transfers at (i, ±j)/period, real and imaginary parts apart: (b, 2, j, 2, i)."""
        settings, size = self.of.settings, self._size
        count = frequencies_within(settings.cut, settings.period)
        kept = min(count, size // 2 + 1)
        j, i = np.arange(kept)[:, None], np.arange(kept)
        inside = i * i + j * j < (settings.cut * settings.period) ** 2
        out, whole = np.zeros((len(self.weights), 2, count, 2, count)), np.ones(self._side)
        for into, pattern in zip(out, self.patterns, strict=True):
            folded = np.zeros((size, size))
            add_folded(folded, pattern, whole, whole, 1.0, -self._half, -self._half, 1)
            transfer = scipy.fft.rfft2(folded, workers=-1, overwrite_x=True)
            for side, rows in enumerate((transfer[:kept, :kept], transfer[-np.arange(kept), :kept])):
                into[side, :kept, 0, :kept] = np.where(inside, rows.real, 0.0)
                into[side, :kept, 1, :kept] = np.where(inside, rows.imag, 0.0)
        return out

    def seconds(self, lines: int) -> float:
        """Return what they take, of one core, with what is looked up for so many directions of lines.

        Infinite where they do not fit in memory.
        """
        if 8.0 * self.held > MEMORY_LIMIT_BYTES:
            return math.inf
        side, outer_um = self._side, self.of.settings.outer * self.of.pitch_um
        span, sample = (-outer_um, outer_um), prices.PER_PUPIL_SAMPLE if is_large((side, side)) else PER_SAMPLE
        nodes = self.of.rest.pupil_nodes(float(self.of.wavelength_nm[0]))(span, span)
        each = prices.PER_PATTERN + side**2 * sample + nodes * prices.PER_PUPIL_NODE
        sums = self._size**2 * PER_FREQUENCY
        if lines:
            waves = self.of.settings.cut * self.of.settings.outer
            sums += 4.0 * side**2 * PER_FREQUENCY + 3.0 * lines * waves * PER_SUM
        return self.of.wavelength_nm.size * each + len(self.weights) * sums

    @property
    def held(self) -> float:
        """Numbers of 8 bytes that they are, and what one of them is made with, besides what a window has of them."""
        return (len(self.weights) + 3.0) * float(self._side) ** 2 + 2.0 * self._size**2
