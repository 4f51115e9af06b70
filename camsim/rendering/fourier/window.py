"""A window of the frame as it is transformed: its period, its taper, and what the lens's transfer takes there.

A pattern that is sampled is taken from the nearest to the farthest that photosites lie from edges, along either axis:
where all of these lie to one side it is a rectangle beside the pattern's middle.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier import prices
from camsim.rendering.fourier.patterns import NODES_BYTES, made_bytes, pattern_of, rows_at_once, samples_of
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.taper import taper_margin
from camsim.rendering.fourier.task import TRANSFER_BYTES, Task
from camsim.rendering.fourier.tile import Tile

ALL_BUT = 0.95  # of the memory, that a wavefront's patterns may take while they are made
SAMPLE_BYTES, FOLDED_BYTES = 20.0, 8.0  # of all patterns' samples, and while one after the other is added up
WHOLE_BYTES = 24.0  # of a transfer that is made for a whole tile at once, three times, for each such sample
NARROWER = 0.8  # of an even pattern's area, what one beside its middle has at most: no node stands for two of it

Window = tuple[int, int, int, int]  # row, col, rows, cols


def tile_of(task: Task, window: Window, box_low: F64, box_high: F64) -> Tile:
    """Return the tile of a window.

    box_low, box_high : (2,) what it sees of the scene, from its first photosite
    """
    kernel, (_, _, rows, cols) = task.kernel, window
    nearest = -box_high - task.footprint
    farthest = np.array([cols - 1.0, rows - 1.0]) - box_low + task.footprint
    even = _tile(task, window, (box_low, box_high), np.maximum(farthest, -nearest), np.zeros(2))
    if not kernel.sampled or kernel.hem is not None:
        return even
    middle = 0.5 * (np.minimum(farthest, kernel.reach) + np.maximum(nearest, -kernel.reach))
    beside = _tile(task, window, (box_low, box_high), np.maximum(farthest - middle, middle - nearest), middle)
    if math.prod(beside.outer) > NARROWER * math.prod(even.outer):
        return even
    return min(even, beside, key=functools.partial(_seconds, task))


def _seconds(task: Task, tile: Tile) -> float:
    return of_kernel(task, tile, task.fields(tile)).seconds + tile.points * prices.PER_FIELD_POINT


def _tile(task: Task, window: Window, box: tuple[F64, F64], extent: F64, middle: F64) -> Tile:
    """Return the tile for a pattern that is taken about its ``middle`` as far as ``extent``, or as it matters."""
    kernel, (row, col, rows, cols), (low, high) = task.kernel, window, box
    inner_round = min(kernel.reach, float(np.hypot(*extent)))
    inner = np.full(2, inner_round) if kernel.round else np.minimum(extent, kernel.reach - np.abs(middle))
    if not kernel.tapered:
        margin = sharpness = width = 0.0
        inner = np.full(2, kernel.reach)
    elif kernel.hem is not None:
        inner, width = np.full(2, kernel.hem.inner), kernel.hem.outer - kernel.hem.inner
        margin, sharpness = kernel.hem.band * width, kernel.hem.sharpness
    else:
        allowed = ErrorBudget(task.tolerance).allowed("taper") / kernel.tapers
        # Beside the middle a taper may lie on it.
        level = allowed / kernel.beyond(0.0 if middle.any() else float(inner.min()), task.edges)
        margin, sharpness = taper_margin(min(max(level, 1e-14), 1.0))
        shortest = math.sqrt(float(np.prod(extent + inner)))
        # The width w makes (cutoff + margin/w)·(extent + inner + w) smallest.
        width = max(math.sqrt(margin * shortest / kernel.cutoff), margin * kernel.blur / 8.0)
    outer = inner + width
    wanted = [fast_length(math.ceil(value), real=True) for value in extent + outer]
    if kernel.tapered and not kernel.round and kernel.hem is None:
        # What is left of the period widens the taper for nothing.
        outer = np.maximum(outer, np.array(wanted) - extent)
        width = float((outer - inner).min())
    cut = kernel.cutoff + (margin / width if width else 0.0)
    return Tile(
        row=row,
        col=col,
        rows=rows,
        cols=cols,
        inner=(float(inner[0]), float(inner[1])),
        outer=(float(outer[0]), float(outer[1])),
        periods=(max(wanted[0], 2), max(wanted[1], 2)),
        cut=cut,
        cuts=kernel.cuts(cut),
        low=(float(low[0]), float(low[1])),
        high=(float(high[0]), float(high[1])),
        middle=(float(middle[0]), float(middle[1])),
        sharpness=sharpness,
    )


class OfKernel(NamedTuple):
    """What a tile's transfer of the lens takes; more bytes while it is made, so many rows of a pattern at a time."""

    seconds: float
    held_bytes: float
    making_bytes: float = 0.0
    pattern_rows: int = 1


def line_seconds(kernel: Kernel, wavelengths: int, radius: float) -> float:
    """Return what a round pattern takes that is summed over a pupil; 0: of none."""
    nodes = kernel.line_nodes(radius)
    return prices.PER_LINE * wavelengths + prices.PER_LINE_NODE * nodes if nodes else 0.0


def _radial_seconds(kernel: Kernel, wavelengths: int, radius: float) -> float:
    """Return what a round pattern takes along its radius."""
    return prices.PER_PATTERN_BLUR * wavelengths * radius / kernel.blur + line_seconds(kernel, wavelengths, radius)


def of_kernel(task: Task, tile: Tile, fields: int) -> OfKernel:
    """Return what a tile's transfer of the lens takes."""
    kernel, samples = task.kernel, samples_of(task.kernel, tile)
    if kernel.round:
        curves = task.spectra * task.channels
        seconds = prices.PER_KERNEL_SAMPLE * curves * (2.0 * tile.cut * tile.outer[0]) ** 2
        seconds += _radial_seconds(kernel, task.wavelengths, tile.outer[0])
        return OfKernel(seconds, 8.0 * 12 * curves * (32.0 * tile.outer[0] * tile.cut))
    if kernel.tapered:
        (rows, columns), own = pattern_of(kernel, tile), pattern_rows(task, tile, fields)
        seconds = prices.PER_PATTERN * task.wavelengths
        seconds += prices.PER_PUPIL_NODE * kernel.pupil_nodes(*tile.spans) * math.ceil(rows / own)
        seconds += kernel.pattern_seconds * task.wavelengths * rows * columns
        if kernel.over_rectangle:
            farthest = math.hypot(*(max(map(abs, span)) for span in tile.spans))
            seconds += _radial_seconds(kernel, task.wavelengths, farthest)
        held = (SAMPLE_BYTES + TRANSFER_BYTES * (fields - 1)) * samples
        made = made_bytes(kernel, own, columns) + FOLDED_BYTES * fields * samples
        return OfKernel(seconds, held, max(0.0, made - held), own)
    sets = min(task.spectra * task.channels, task.wavelengths)
    return OfKernel(0.0, WHOLE_BYTES * sets * samples if kernel.whole else 0.0)


def pattern_rows(task: Task, tile: Tile, fields: int) -> int:
    """Return how many rows of a pattern are made at a time."""
    kernel, folded = task.kernel, FOLDED_BYTES * fields * samples_of(task.kernel, tile)
    spare = ALL_BUT * task.memory_limit_bytes - NODES_BYTES - folded
    return rows_at_once(kernel, pattern_of(kernel, tile), spare)
