"""From frequencies to photosites."""

from __future__ import annotations

import functools
import math

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel, shared
from camsim.products import complex_product, product
from camsim.quadrature import barycentric
from camsim.rendering.fourier.plan import PART
from camsim.rendering.fourier.tile import COARSE_POINTS, Tile

FILLED = 10_000  # photosites that are worth a thread's while
WHOLE = (slice(None), slice(None))  # rows and columns
WORTH_THREADS = 1_000_000  # numbers to be transformed, likewise: fewer take longer on two


def inverse(values: C128, tile: Tile, every: tuple[slice, slice] = WHOLE) -> F64:
    """Return the tile's photosites (…, rows, cols) from their frequencies (…, ``tile.sums``); ``values`` is lost.

    First down the columns, some at a time, of which only the tile's rows are kept; then along those.
    every : rows and columns that are asked for
    """
    px, py = tile.periods
    before = values.shape[:-2]
    if tile.one_by_one:
        each = [_one_by_one(own, tile) for own in values.reshape(-1, *values.shape[-2:])]
        return np.array(each).reshape(*before, *each[0].shape)[..., every[0], every[1]]
    # A short kernel's period may be less than the tile: what repeats is then the empty background.
    rows, cols = (np.arange(tile.rows) % py)[every[0]], (np.arange(tile.cols) % px)[every[1]]
    lines = np.empty((*before, rows.size, values.shape[-1]), complex)
    many, frequencies = math.prod(before), values.shape[-2]
    step = max(1, PART // (many * py))
    below = (frequencies + 1) // 2  # rows of j ≥ 0; where all of the others are not there, they are 0
    for first in range(0, values.shape[-1], step):
        part = values[..., first : first + step]
        if frequencies < py:
            some = part
            part = np.zeros((*before, py, some.shape[-1]), complex)
            part[..., :below, :], part[..., py - frequencies + below :, :] = some[..., :below, :], some[..., below:, :]
        down = scipy.fft.ifft(part, axis=-2, overwrite_x=True, workers=_threads(part.size))
        lines[..., first : first + step] = down[..., _run(rows), :]
    image = np.empty((*before, rows.size, cols.size))
    step = max(1, PART // (many * px))
    for first in range(0, rows.size, step):
        some = lines[..., first : first + step, :]
        along = scipy.fft.irfft(some, n=px, axis=-1, workers=_threads(some.size))
        image[..., first : first + step, :] = along[..., _run(cols)]
    return image


def _run(places: I64) -> slice | I64:
    """Return places, evenly spaced unless they repeat, as a slice where they are one: none is picked one by one."""
    step = int(places[1] - places[0]) if places.size > 1 else 1
    if step < 1 or places[-1] - places[0] != step * (places.size - 1):
        return places
    return slice(int(places[0]), int(places[-1]) + 1, step)


def _threads(size: int) -> int:
    return -1 if size >= WORTH_THREADS else 1


def _one_by_one(values: C128, tile: Tile) -> F64:
    """Return the same from few frequencies: i from 0 on, j going round."""
    rows, columns = values.shape
    down = down_waves(tile, np.arange(rows) - rows // 2)
    return filled_in(seen(down, np.roll(values, rows // 2, axis=0), across_waves(tile, np.arange(columns))), tile)


def down_waves(tile: Tile, j: I64) -> C128:
    """Return waves (rows, j) at those rows where what is smooth is added up, all where nothing is."""
    (rows, _), py = tile.coarse, tile.periods[1]
    phase: F64 = 2.0 * np.pi / py * (np.multiply.outer(_places(tile, rows), j) % py)
    waves: C128 = np.exp(1j * phase) / py
    return waves


def across_waves(tile: Tile, column: I64) -> C128:
    """Return waves (columns, cols) likewise; columns 0 and half of the period hold their own mirror images."""
    (_, cols), px = tile.coarse, tile.periods[0]
    times = np.where((column == 0) | (2 * column == px), 1.0, 2.0) / px
    phase: F64 = 2.0 * np.pi / px * (np.multiply.outer(column, _places(tile, cols)) % px)
    waves: C128 = np.exp(1j * phase) * times[:, None]
    return waves


def _places(tile: Tile, count: int) -> I64:
    step = tile.coarse_step
    return step * (np.arange(count) - (0 if step == 1 else COARSE_POINTS // 2 - 1))  # some lie outside the tile


def seen(down: C128, values: C128, across: C128) -> F64:
    """Return what waves (rows, j), (i, cols) of so much each, (j, i), add up to."""
    lines = complex_product(down, values)
    return product(lines.real, across.real) - product(lines.imag, across.imag)


def filled_in(coarse: F64, tile: Tile) -> F64:
    """Return all photosites from those where what is smooth is added up."""
    if tile.coarse_step == 1:
        return coarse
    return filled(coarse, _lagrange(tile.coarse_step), tile.rows, tile.cols)


def _lagrange(step: int) -> F64:
    """Return Lagrange's weights (step, points) between every ``step``-th photosite."""
    nodes = np.arange(float(COARSE_POINTS))
    even = (-1.0) ** nodes * scipy.special.binom(COARSE_POINTS - 1, nodes)
    return barycentric(nodes - (COARSE_POINTS // 2 - 1), even, np.arange(step) / step, same=1e-14)


def filled(
    coarse: F64, between: F64, rows: int, cols: int, every: tuple[slice, slice] = (slice(None), slice(None))
) -> F64:
    """Return photosites (rows, cols) from every n-th, some beyond them on all sides.

    between : weights (n, points) of these; the first one's place is 1 − points/2
    every   : rows and columns that are asked for
    """
    down, across = (range(*part.indices(count)) for part, count in zip(every, (rows, cols), strict=True))
    image = np.empty((len(down), len(across)))
    places = (down.start, down.step), (across.start, across.step)
    work = functools.partial(_fill, np.ascontiguousarray(coarse), between, places, image)
    shared(len(down), work, least=1 + FILLED // max(1, len(across)))
    return image


@kernel(allocates=True, fastmath={"contract"})
def _fill(
    coarse: F64, between: F64, places: tuple[tuple[int, int], tuple[int, int]], image: F64, begin: int, end: int
) -> None:
    """Fill some rows of an image between the photosites of a coarse one.

    between : weights (step, points);  places: first photosite of the image and how many to the next, down and across
    """
    (first_row, down), (first_col, across) = places
    step, points = between.shape
    # What lies between any two photosites in the same way is computed in one go.
    line, own = np.empty(coarse.shape[1]), np.empty(coarse.shape[1] - points + 1)
    phases = 1
    while phases * across % step:
        phases += 1
    for n in range(begin, end):
        r = first_row + n * down
        line[:] = 0.0
        for k in range(points):
            w, source = between[r % step, k], coarse[r // step + k]
            for c in range(line.size):
                line[c] += w * source[c]
        for first in range(min(phases, image.shape[1])):
            phase = (first_col + first * across) % step
            own[:] = 0.0
            for k in range(points):
                w, source = between[phase, k], line[k : k + own.size]
                for c in range(own.size):
                    own[c] += w * source[c]
            for m in range(first, image.shape[1], phases):
                image[n, m] = own[(first_col + m * across) // step]
