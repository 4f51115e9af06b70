"""Squares of sums of plane waves on a lattice, from points that are spread once however fine the lattice is.

A pattern is the square of an amplitude, so its lattice is twice as fine as the amplitude's own band asks for. finufft
knows no band: it transforms a grid four times as large as there are waves in it. Here the points are spread (by
finufft) on a grid of the band alone, and each quarter of the lattice, every second row and column, is a transform of
that grid, its waves turned by half a step: as much arithmetic and a tenth of the memory. Rows are handed on as they
come, and no pattern is held: no point need be spread for one strip of it after the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple, TypeVar

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.gridded.grid import COLUMNS, ROWS, WIDEST, Spread, even, is_large, of_kernel, runs, spread_to
from camsim.kernels import ahead, shared
from camsim.kernels.squares import fill_squares
from camsim.nonuniform import finer, modes

Nodes = TypeVar("Nodes")
IN_CACHE = 65536  # cells of a row: as many rows are transformed at a time as stay in a cache
AT_ONCE = 1_000_000  # points of a lattice that are handed on at a time
QUARTERS_AT_ONCE = 2  # of parts that are spread: what they are spread to takes less than what is held after them
PER_WAVE = 2.04  # samples of a pattern, for each of its shortest waves: just enough
JUST_RAD = math.pi / PER_WAVE  # by which an amplitude's waves turn from one of them to the next
FEWER = 1.3  # cells in two half grids over those in one whole grid: up to there two take less


class _Axis(NamedTuple):
    """One axis: places, of which every ``steps``-th is on one lattice, and the grid's cells."""

    size: int
    steps: int
    cells: int

    @classmethod
    def of(cls, size: int, band_rad: float, larger: float) -> _Axis:
        """Choose for points whose waves turn by up to ``band_rad`` from one place to the next."""
        whole = cls(size, 1, even(larger * size))
        room = math.pi - 2.0 * band_rad
        if room <= 0.0:
            return whole
        # A point's cells must not go round: half a step's turn is not the same there.
        cells = even(max(0.5 * larger * (size + 1), (0.5 * WIDEST + 1.0) * math.tau / room))
        return cls(size, 2, cells) if 2 * cells <= FEWER * whole.cells else whole

    def lattice(self, first: int) -> tuple[slice, F64]:
        """Return which of the places are on a lattice, and their numbers about the middle, in the grid's units."""
        places = np.arange(first, self.size, self.steps) - self.size // 2
        return slice(first, None, self.steps), places / self.steps

    def turned(self, part: float) -> C128:
        """Return what waves of the grid turn by in a part of a step."""
        wave = math.tau * (np.arange(self.cells) - self.cells // 2) / self.cells
        turned: C128 = np.exp(-1j * part * wave)
        return turned


def power_rows(
    parts: Iterable[Nodes],
    points: Callable[[Nodes], tuple[F64, F64, C128]],
    shape: tuple[int, int],
    bands_rad: tuple[float, float],
    precision: float,
    *,
    half: bool = False,
) -> Iterator[tuple[slice, F64]]:
    """Yield rows of |Σ_q strengths[q]·exp(−i(j·down[q] + i·across[q]))|², (j, i) integers about 0, some at a time.

    parts     : each is spread when it comes
    points    : of a part, down and across, radians, and strengths, (m,) each
    bands_rad : the largest of all |down| and of all |across|
    precision : of the sum, relative to the sum of the strengths' sizes
    half      : for every point there is another, opposite to it and as strong, which is not given
    yields    : rows of the lattice (shape), each once but in no order, and what is there (n, columns), one's own
    """
    if not is_large(shape):
        assert not half
        amplitude = np.zeros(shape, complex)
        for y, x, strengths in map(points, parts):
            amplitude += modes((y, x), strengths, shape, precision=precision, sign=-1)
        yield slice(0, shape[0]), np.square(amplitude.real) + np.square(amplitude.imag)
        return
    larger = finer(precision)
    down, across = (_Axis.of(size, band, larger) for size, band in zip(shape, bands_rad, strict=True))
    grid = np.zeros((down.cells, across.cells), complex)

    def spread_out(some: tuple[F64, F64, C128]) -> Spread:
        y, x, strengths = some
        return spread_to(grid.shape, down.steps * y, across.steps * x, strengths, precision)

    # Added up in their order: the same sum whoever spreads them.
    for out in ahead(spread_out, _quarters(map(points, parts)), QUARTERS_AT_ONCE):
        grid[out.rows, out.columns] += out.values
        del out  # before the next is made
    if half:
        _add_opposite(grid)
    middle = shape[0] // 2 if half and shape[0] % 2 and shape[1] % 2 else 0
    at_once = _rows_at_once(shape[1])
    lattices = [across.lattice(column) for column in range(across.steps)]
    over_x = [of_kernel(places, across.cells, precision) ** -2.0 for _, places in lattices]
    for row in range(middle, middle + down.steps):
        rows, places_y = down.lattice(row)
        over_y, lines = of_kernel(places_y, down.cells, precision) ** -2.0, _down(grid, down, places_y)
        for first in range(0, len(lines), at_once):
            some = slice(first, first + at_once)
            own = np.arange(rows.start, shape[0], down.steps)[some]
            strip = np.empty((own.size, shape[1]))
            for (columns, places_x), over in zip(lattices, over_x, strict=True):
                _along(lines[some], across, places_x, over_y[some], over, strip, columns.start)
            mirrored = own[own > middle] if middle else own[:0]
            opposite = strip[own.size - mirrored.size :][::-1, ::-1].copy()
            yield slice(own[0], own[-1] + 1, down.steps), strip
            if mirrored.size:
                yield slice(2 * middle - mirrored[-1], 2 * middle - mirrored[0] + 1, down.steps), opposite
        del lines  # before the next are made


def _add_opposite(grid: C128) -> None:
    """Add to each cell the one opposite to it: the first row and column, where cells go round, are their own."""
    middle = len(grid) // 2
    for row in (0, middle):
        grid[row] += np.roll(grid[row, ::-1], 1)
    for first in range(1, middle, ROWS):
        some = slice(first, min(first + ROWS, middle))
        others = slice(len(grid) - some.stop + 1, len(grid) - some.start + 1)
        grid[some] += np.roll(grid[others][::-1, ::-1], 1, axis=1)
        grid[others] = np.roll(grid[some][::-1, ::-1], 1, axis=1)


def held_bytes(shape: tuple[int, int], precision: float) -> float:
    """Return what is held while rows of a pattern that is sampled just finely enough are handed on.

    The grid, with quarters of parts beside it or its columns transformed; and rows.
    """
    rows, columns = shape
    larger = finer(precision)
    down, across = _Axis.of(rows, JUST_RAD, larger), _Axis.of(columns, JUST_RAD, larger)
    grid, lines = down.cells * across.cells, math.ceil(rows / down.steps) * across.cells
    return 16.0 * (grid + max(0.75 * grid, lines)) + 24.0 * min(_rows_at_once(columns), rows) * columns


def _rows_at_once(columns: int) -> int:
    return max(AT_ONCE // columns, ROWS)


def _down(grid: C128, axis: _Axis, places: F64) -> C128:
    """Return the grid's columns transformed: at places, of one lattice."""
    turn, own_runs = (
        axis.turned(places[0] % 1.0)[:, None],
        runs(int(np.count_nonzero(places < 0.0)), places.size, axis.cells),
    )
    lines = np.empty((places.size, grid.shape[1]), complex)

    def transform(begin: int, stop: int) -> None:
        for block in range(begin, stop):
            some = slice(block * COLUMNS, (block + 1) * COLUMNS)
            transformed = scipy.fft.fft(grid[:, some] * turn, axis=0, overwrite_x=True)
            for own, wanted in own_runs:
                lines[own, some] = transformed[wanted]

    shared(math.ceil(grid.shape[1] / COLUMNS), transform)
    return lines


def _along(lines: C128, axis: _Axis, places: F64, over_y: F64, over_x: F64, power: F64, column: int) -> None:
    """Fill in the squares of the lines, transformed, over what the kernels made of them, from a column on."""
    turn, own_runs = axis.turned(places[0] % 1.0), runs(int(np.count_nonzero(places < 0.0)), places.size, axis.cells)
    rows = min(ROWS, max(1, IN_CACHE // axis.cells))

    def fill(some: slice, amplitude: C128) -> None:
        for own, wanted in own_runs:
            first = column + own.start * axis.steps
            fill_squares(power[some], amplitude, over_y[some], over_x[own], wanted.start, first, axis.steps)

    def transform(begin: int, stop: int) -> None:
        for block in range(begin, stop):
            some = slice(block * rows, (block + 1) * rows)
            fill(some, scipy.fft.fft(lines[some] * turn, axis=1, overwrite_x=True))

    fill(slice(0), lines[:0])  # compiled here, on a stack as large as the caller's
    shared(math.ceil(len(lines) / rows), transform)


def _quarters(parts: Iterable[tuple[F64, F64, C128]]) -> Iterator[tuple[F64, F64, C128]]:
    """Yield quarters of each part, one below the other: spread to a quarter of the cells, several fit beside a grid.

    Nothing is kept that was handed on.
    """
    for part in parts:
        halves = _halves(part)
        del part
        while halves:
            quarters = _halves(halves.pop())
            while quarters:
                yield quarters.pop()


def _halves(points: tuple[F64, F64, C128]) -> list[tuple[F64, F64, C128]]:
    """Return what lies in the upper half of what points fill, and in the lower one."""
    y, x, strengths = points
    upper = y < 0.5 * (y.min() + y.max())
    return [(y[some], x[some], strengths[some]) for some in (upper, ~upper) if some.any()]
