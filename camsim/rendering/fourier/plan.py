"""The Fourier engine's sizes, chosen before anything is computed: tiles, periods, taper, memory and time.

A periodic transform sees every photosite and every edge again a period further on. Nothing of that is wrong as long as
the lens's kernel is 0 there. So the kernel is multiplied by a taper that is 1 out to ``inner``, the largest distance
between a photosite and an edge, and 0 from ``outer`` on; with a period of at least ``outer`` plus the extent nothing
wraps round. Tapering widens the kernel's band from its cut-off to cutoff + margin/(outer − inner).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import fft

from camsim.arrays import F64
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fourier.blocks import Tile, count_blocks
from camsim.rendering.fourier.taper import taper_margin

MOST_TILES, SMALLEST_TILE = 64, 64  # along an axis; photosites
BLOCK_POINTS, SPREAD_POINTS, FEWEST_IN_BLOCK = 150_000, 400_000, 20_000  # frequencies at a time: what stays in a cache
SPREAD_HELD, SPREAD_MEMORY = 20, 0.25  # numbers: two sums on a grid of twice a block's sides; part of all memory
PART = 2_000_000  # numbers that are transformed back at a time
NODES_PER_RADIAN, FEWEST_ON_EDGE = 0.5, 10  # of the Gauss rule on an edge, by the phase along it

# Seconds of one core, measured.
PER_TILE = 2e-3
PER_EDGE_POINT, PER_EDGE_ROW = 1.1e-9, 5e-8
PER_ROUND_POINT, PER_FIELD_POINT = 1e-9, 3e-8
PER_POINT_WEIGHT = 8e-9
PER_SPREAD_NODE = 1.5e-7
PER_SPREAD_POINT = 1.4e-7
PER_GRID_POINT = 1.2e-8
PER_KERNEL_SAMPLE = 4.5e-9
PER_PATTERN_BLUR = 1.4e-6  # of a round pattern's radius, at one wavelength, the choice of it included
PER_PUPIL_NODE = 5e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """What the sizes depend on of a lens at all its wavelengths; lengths in pitches.

    cutoff  : highest frequency that it passes, cycles/pitch
    blur    : its shortest length (a pattern changes over a quarter of it)
    reach   : as far as its light matters; inf: as far as there is anything
    round   : the taper is round and the kernel a curve; else both are functions of x and y
    tapered : False for a pattern that has died away at ``reach`` by itself
    light   : what share of the light may lie beyond a distance
    rings   : (a, n): what the light beyond a distance R may leave of an edge outside the band, a·R⁻ⁿ; none if unknown
    """

    cutoff: float
    blur: float
    reach: float
    round: bool
    tapered: bool
    light: Callable[[float], float]
    rings: tuple[tuple[float, float], ...] = ()

    def beyond(self, distance: float, edges: int) -> float:
        """Return what a taper that begins at ``distance`` works on: at most this of an image of so many edges."""
        beyond = min(1.0, self.light(distance))
        if self.rings:
            beyond = min(beyond, edges * sum(a * distance**-n for a, n in self.rings))
        return beyond


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """Settings of one rendering.

    margin   : of the taper's band, in 1/width;  sharpness: β of its Kaiser–Bessel window
    spread   : transform the edges by non-uniform FFT instead of edge by edge
    channels : at a time;  block_points: frequencies at a time
    seconds, memory_bytes : expected, of one core
    """

    tiles: tuple[Tile, ...]
    margin: float
    sharpness: float
    spread: bool
    channels: int
    block_points: int
    seconds: float
    memory_bytes: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Task:
    """What there is to do; lengths in pitches.

    shape     : rows and columns of photosites
    low, high : (2,) corners of the scene's edges, from the first photosite
    footprint : (2,) how far the footprint reaches along x and y
    edges, length : how many, and how long all of them are where they can be seen
    spectra, channels, wavelengths : numbers of them
    memory_limit_bytes : what the sizes keep below if they can
    """

    kernel: Kernel
    shape: tuple[int, int]
    low: F64
    high: F64
    footprint: F64
    edges: int
    length: float
    spectra: int
    channels: int
    wavelengths: int
    tolerance: float
    memory_limit_bytes: float

    @property
    def weights(self) -> int:
        """Numbers that every frequency is multiplied by."""
        return self.spectra * self.channels * (1 if self.kernel.round else self.wavelengths)

    @property
    def passes(self) -> int:
        """How often the scene is transformed."""
        return self.wavelengths if self.kernel.tapered and not self.kernel.round else 1

    @property
    def fields(self) -> int:
        """Transfers that are held for a block at a time."""
        return 0 if self.kernel.round else 1 if self.kernel.tapered else self.wavelengths


def plan_sizes(task: Task) -> Sizes:
    """Choose the cheapest sizes that keep within the memory; the least hungry ones when none do."""
    best: Sizes | None = None
    count = 1
    while True:
        plan = _tiled(task, count)
        if best is None or _rank(plan, task.memory_limit_bytes) < _rank(best, task.memory_limit_bytes):
            best = plan
        count *= 2
        hopeless = best.memory_bytes <= task.memory_limit_bytes and plan.seconds > 2.0 * best.seconds
        if count > MOST_TILES or max(task.shape) < count * SMALLEST_TILE or hopeless:
            return best


def _rank(plan: Sizes, memory_limit_bytes: float) -> tuple[bool, float]:
    """Order plans: those that fit by their time, before those that do not by their memory."""
    fits = plan.memory_bytes <= memory_limit_bytes
    return not fits, plan.seconds if fits else plan.memory_bytes


def _tiled(task: Task, count: int) -> Sizes:
    """Return the sizes with ``count`` tiles along the longer side."""
    shape, kernel = task.shape, task.kernel
    side = math.ceil(max(shape) / count)
    tiles: list[Tile] = []
    margin = sharpness = 0.0
    for row in range(0, shape[0], side):
        for col in range(0, shape[1], side):
            window = (row, col, min(side, shape[0] - row), min(side, shape[1] - col))
            tile, margin, sharpness = _tile(task, window)
            tiles.append(tile)
    largest = max(tiles, key=lambda tile: tile.points)
    nodes = NODES_PER_RADIAN * 2.0 * math.pi * largest.cut * task.length + FEWEST_ON_EDGE * task.edges
    held = task.spectra + task.fields + 4  # numbers of a frequency that are kept while its block is worked on
    plain, spreading = (
        max(FEWEST_IN_BLOCK, 6 * most // (6 + task.spectra + task.fields)) for most in (BLOCK_POINTS, SPREAD_POINTS)
    )
    # Every block is spread to from every node: with more nodes than frequencies in a block it had better be larger.
    roomy = SPREAD_MEMORY * task.memory_limit_bytes / (16.0 * (held + SPREAD_HELD))
    spreading = max(spreading, int(min(nodes, roomy)))
    # Where an alias has few columns, a row of them takes what its first takes.
    _, rows_of_blocks = count_blocks(largest, plain)
    by_edge = task.edges * (PER_EDGE_POINT + PER_EDGE_ROW * rows_of_blocks / largest.points)
    by_spreading = task.spectra * PER_SPREAD_POINT
    calls, _ = count_blocks(largest, spreading)
    by_spreading += 2.0 * nodes * calls * PER_SPREAD_NODE / largest.points
    spread = by_spreading < by_edge
    block_points = spreading if spread else plain
    per_point = min(by_edge, by_spreading) + (PER_ROUND_POINT if kernel.round else PER_FIELD_POINT)
    seconds, fixed, transforms = PER_TILE * len(tiles), 0.0, 0.0
    for tile in tiles:
        area = tile.periods[0] * tile.periods[1]
        seconds += tile.points * (task.passes * per_point + task.weights * PER_POINT_WEIGHT)
        seconds += task.channels * area * PER_GRID_POINT
        kernel_seconds, kernel_bytes = _of_kernel(task, tile)
        seconds += kernel_seconds
        fixed = max(fixed, kernel_bytes + area * 8.0 * tile.rows / tile.periods[1])
        transforms = max(transforms, area * 8.0)
    fixed += block_points * 16.0 * (held + SPREAD_HELD * spread) + 64.0 * nodes * spread
    fixed += 16.0 * shape[0] * shape[1] + 48.0 * min(PART, largest.periods[0] * largest.periods[1])
    channels = task.channels
    if fixed + channels * transforms > task.memory_limit_bytes:
        seconds += (channels - 1) * task.passes * per_point * sum(tile.points for tile in tiles)
        channels = 1
    return Sizes(
        tiles=tuple(tiles),
        margin=margin,
        sharpness=sharpness,
        spread=spread,
        channels=channels,
        block_points=block_points,
        seconds=seconds,
        memory_bytes=fixed + channels * transforms,
    )


def _of_kernel(task: Task, tile: Tile) -> tuple[float, float]:
    """Return seconds and bytes that a tile's transfer of the lens takes."""
    kernel, area = task.kernel, tile.periods[0] * tile.periods[1]
    samples = 4.0 * tile.cut**2 * area
    if kernel.round:
        curves = task.spectra * task.channels
        seconds = PER_KERNEL_SAMPLE * curves * (2.0 * tile.cut * tile.outer[0]) ** 2
        seconds += PER_PATTERN_BLUR * task.wavelengths * tile.outer[0] / kernel.blur
        return seconds, 8.0 * 12 * curves * (32.0 * tile.outer[0] * tile.cut)
    if kernel.tapered:
        pupil = tile.outer[0] * tile.outer[1] / kernel.blur**2
        return task.wavelengths * PER_PUPIL_NODE * (pupil + samples), 160.0 * samples
    return 0.0, 0.0


def _tile(task: Task, window: tuple[int, int, int, int]) -> tuple[Tile, float, float]:
    """Return the tile of a window (row, col, rows, cols), and margin and sharpness of its taper."""
    kernel, (row, col, rows, cols) = task.kernel, window
    size = np.array([cols - 1.0, rows - 1.0])
    first = np.array([col, row], float)
    beyond = kernel.reach + task.footprint
    box_low = np.clip(task.low - first, -beyond, size + beyond)
    box_high = np.clip(task.high - first, -beyond, size + beyond)
    extent = np.maximum(np.maximum(box_high, size - box_low), 0.0) + task.footprint
    inner_round = min(kernel.reach, float(np.hypot(*extent)))
    inner = np.full(2, inner_round) if kernel.round else np.minimum(extent, kernel.reach)
    if not kernel.tapered:
        margin = sharpness = width = 0.0
        inner = np.full(2, kernel.reach)
    else:
        level = ErrorBudget(task.tolerance).allowed("taper") / kernel.beyond(float(inner.min()), task.edges)
        margin, sharpness = taper_margin(min(max(level, 1e-14), 1.0))
        shortest = math.sqrt(float(np.prod(extent + inner)))
        # The width w makes (cutoff + margin/w)·(extent + inner + w) smallest.
        width = max(math.sqrt(margin * shortest / kernel.cutoff), margin * kernel.blur / 8.0)
    outer = inner + width
    wanted = [fft.next_fast_len(math.ceil(value), real=True) for value in extent + outer]
    if kernel.tapered and not kernel.round:
        # What is left of the period widens the taper for nothing.
        outer = np.maximum(outer, np.array(wanted) - extent)
        width = float((outer - inner).min())
    cut = kernel.cutoff + (margin / width if width else 0.0)
    tile = Tile(
        row=row,
        col=col,
        rows=rows,
        cols=cols,
        inner=(float(inner[0]), float(inner[1])),
        outer=(float(outer[0]), float(outer[1])),
        periods=(max(wanted[0], 2), max(wanted[1], 2)),
        cut=cut,
        low=(float(box_low[0]), float(box_low[1])),
        high=(float(box_high[0]), float(box_high[1])),
    )
    return tile, margin, sharpness
