"""The low frequencies of a source, from samples on a coarse grid that are computed once for all levels but the first.

A source that is low-pass filtered smoothly above these frequencies is a smooth picture, little larger than the source.
Its samples on a grid give every level's transform along rows and columns, at a cost that does not depend on the number
of edges or samples of the source.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from camsim.core.arrays import C128, F64, Complex
from camsim.core.cached import cached_property
from camsim.numerics.nonuniform import complex_type, modes_of_lines
from camsim.rendering.fast_length import fast_length
from camsim.rendering.waves.image import Source
from camsim.rendering.waves.levels import Lattice
from camsim.rendering.waves.taper import taper, taper_margin, tapered

WIDER = 2.0  # end of the smooth cut-off, over the highest frequency needed
MOST = 4_000_000  # frequencies up to which the samples pay


class _Samples(NamedTuple):
    """A smooth picture (kinds, rows, cols), with the position of its first sample and the spacing, pitches."""

    light: F64
    first: F64
    step: F64


@dataclass(frozen=True, kw_only=True, eq=False)
class LowFrequencies:
    """A source whose transforms up to ``cut`` cycles/pitch come from few samples.

    precision : relative error
    """

    source: Source
    cut: float
    precision: float

    @property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner."""
        return self.source.box

    @property
    def whole(self) -> int:
        """``whole`` of the source."""
        return self.source.whole

    @property
    def in_parts(self) -> bool:
        """``in_parts`` of the source."""
        return self.source.in_parts

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> Complex | None:
        """Return the transform of the source; None: no light."""
        low, high = self.box
        seen = (low - origin >= lattice.low).all() and (high - origin <= lattice.high).all()
        if lattice.cut > self.cut * (1.0 + 1e-9) or not seen or self._size > MOST:
            return self.source.transform(lattice, origin)
        samples = self._samples
        if samples is None:
            return None
        columns, rows = lattice.counts
        out = np.empty((len(samples.light), 2 * rows - 1, columns), complex_type(self.precision))
        place = [
            samples.first[axis] - origin[axis] + samples.step[axis] * np.arange(samples.light.shape[2 - axis])
            for axis in (0, 1)
        ]
        for one, light in zip(out, samples.light, strict=True):
            along = _sums(light, place[0], lattice.periods[0], range(columns), self.precision)
            one[:] = _sums(along.T, place[1], lattice.periods[1], range(1 - rows, rows), self.precision).T
        out *= samples.step[0] * samples.step[1]
        return out

    @cached_property
    def _frame(self) -> tuple[tuple[int, int], F64, float]:
        """Periods that cover the smooth picture, its low corner, and the taper's β."""
        margin, sharpness = taper_margin(self.precision)
        low, high = self.box
        tail = margin / ((WIDER - 1.0) * self.cut)
        sides = high - low + 2.0 * tail
        unit = self.whole
        periods = [unit * fast_length(max(1, math.ceil(side / unit))) for side in sides.tolist()]
        return (periods[0], periods[1]), low - tail, sharpness

    @property
    def _size(self) -> float:
        (px, py), *_ = self._frame
        return 2.0 * (WIDER * self.cut) ** 2 * px * py

    @cached_property
    def _samples(self) -> _Samples | None:
        periods, first, sharpness = self._frame
        highest = WIDER * self.cut
        # Equivalent sources may lie a little outside the light's box.
        lattice = Lattice(periods, highest, (0.0, 0.0), (float(periods[0]), float(periods[1])))
        found = self.source.transform(lattice, (float(first[0]), float(first[1])))
        if found is None:
            return None
        columns, rows = lattice.counts
        fx, fy = np.arange(columns) / periods[0], np.arange(1 - rows, rows) / periods[1]
        found *= tapered(np.hypot(fx, fy[:, None]), self.cut, highest, taper(sharpness))
        counts = fast_length(2 * rows), fast_length(2 * columns)
        both = np.zeros((len(found), counts[0], columns), complex)
        both[:, :rows] = found[:, rows - 1 :]
        both[:, counts[0] - rows + 1 :] = found[:, : rows - 1]
        step = np.array(periods, float) / counts[::-1]
        light = scipy.fft.irfft2(both, counts, axes=(1, 2)) / (step[0] * step[1])
        return _Samples(light, first, step)


def _sums(lines: F64 | C128, place: F64, period: int, numbers: range, precision: float) -> C128:
    """Return Σ lines[…, n]·exp(−2πi·number·place[n]/period): (lines, numbers)."""
    phase = (2.0 * np.pi / period) * place
    middle = numbers[len(numbers) // 2]
    strengths = np.ascontiguousarray(lines * np.exp(-1j * middle * phase))
    return modes_of_lines(phase, strengths, len(numbers), precision=precision)
