"""The Fourier engine's sizes, chosen before anything is computed: tiles, periods, taper, memory and time.

A periodic transform sees every photosite and every edge again a period further on. Nothing of that is wrong as long as
the lens's kernel is 0 there. So the kernel is multiplied by a taper that is 1 out to ``inner``, the largest distance
between a photosite and an edge, and 0 from ``outer`` on; with a period of at least ``outer`` plus the extent nothing
wraps round. Tapering widens the kernel's band from its cut-off to cutoff + margin/(outer − inner).
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.rendering.fourier import prices
from camsim.rendering.fourier.blocks import count_blocks, count_strips
from camsim.rendering.fourier.task import PART_OF_MEMORY, Task
from camsim.rendering.fourier.tile import CHEAPER, Tile
from camsim.rendering.fourier.window import of_kernel, tile_of

MOST_TILES, SMALLEST_TILE = 64, 64  # along an axis; photosites
BLOCK_POINTS, FEWEST_IN_BLOCK = 150_000, 20_000  # frequencies at a time: what stays in a cache
STRIP_POINTS = 400_000  # spread to at a time, at least, and more with more nodes as long as there is memory
NODE_BYTES = 100.0  # of a node on an edge, with all that is made of it
TILES_AT_ONCE = 2  # of round lenses, and then one strip of each
WORTH_A_THREAD = 100_000  # frequencies of a tile
STRIPS_AT_ONCE = 2  # whatever the number of threads: what fits decides on the strips, and those on the last bits
SPREAD_HELD = 12  # complex numbers for each: sums on grids of up to twice their strips' sides, and what is made of them
PART = 2_000_000  # numbers that are transformed back at a time


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """Settings of one rendering.

    spread   : transform the edges by non-uniform FFT instead of edge by edge, ``strip_points`` frequencies at a time
    channels : at a time;  fields: wavelengths at a time, of a tapered lens that is not round
    block_points : frequencies at a time;  pattern_rows: of a lens that is not round, at a time
    at_once  : tiles, each of them on one thread;  fewest_strips: of each, that threads share
    seconds, memory_bytes : expected, of one core
    """

    tiles: tuple[Tile, ...]
    spread: bool
    channels: int
    fields: int
    block_points: int
    strip_points: int
    pattern_rows: int
    seconds: float
    memory_bytes: float
    at_once: int = 1
    fewest_strips: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class _Alike:
    """Tiles that differ in their places only: what lies beyond them is clamped alike.

    tile : one of them;  rows, cols: first ones of all of them
    """

    tile: Tile
    rows: list[int]
    cols: list[int]

    def __len__(self) -> int:
        return len(self.rows) * len(self.cols)

    @property
    def first(self) -> F64:
        """First photosites of all, (n, 2) as x, y."""
        return np.array(list(itertools.product(self.cols, self.rows)), float)

    @property
    def tiles(self) -> list[Tile]:
        """All of them."""
        return [dataclasses.replace(self.tile, row=row, col=col) for row in self.rows for col in self.cols]


def plan_sizes(task: Task) -> Sizes:
    """Choose the cheapest sizes that keep within the memory; the least hungry ones when none do."""
    best: Sizes | None = None
    cut: list[_Alike] = []
    count = 1
    while True:
        alike = _cut(task, count)
        plan = _tiled(task, alike)
        if best is None or rank(plan, task.memory_limit_bytes) < rank(best, task.memory_limit_bytes):
            best, cut = plan, alike
        count *= 2
        # Where time grows as fast as tiles do, each is as large as all of the frame.
        settled = best.memory_bytes <= task.memory_limit_bytes or plan.memory_bytes > best.memory_bytes
        hopeless = settled and plan.seconds > 2.0 * best.seconds
        if count > MOST_TILES or max(task.shape) < count * SMALLEST_TILE or hopeless:
            tiles = sorted((tile for some in cut for tile in some.tiles), key=lambda tile: (tile.row, tile.col))
            return dataclasses.replace(best, tiles=tuple(tiles))


def rank(plan: Sizes, memory_limit_bytes: float) -> tuple[bool, float]:
    """Order plans: those that fit by their time, before those that do not by their memory."""
    fits = plan.memory_bytes <= memory_limit_bytes
    return not fits, plan.seconds if fits else plan.memory_bytes


def _cut(task: Task, count: int) -> list[_Alike]:
    """Cut the frame into tiles, ``count`` along the longer side: thousands of them, of a few kinds."""
    side = math.ceil(max(task.shape) / count)
    along: list[dict[tuple[int, float, float], list[int]]] = []  # by size and the scene's ends: first ones
    for axis, length in enumerate(reversed(task.shape)):
        beyond, ends = task.kernel.reach + task.footprint[axis], (task.low[axis], task.high[axis])
        alike: dict[tuple[int, float, float], list[int]] = {}
        for first in range(0, length, side):
            size = min(side, length - first)
            low, high = (min(max(float(end) - first, -beyond), size - 1.0 + beyond) for end in ends)
            alike.setdefault((size, low, high), []).append(first)
        along.append(alike)
    found = []
    for (x, cols), (y, rows) in itertools.product(along[0].items(), along[1].items()):
        low, high = np.array([x[1], y[1]]), np.array([x[2], y[2]])
        tile = tile_of(task, (rows[0], cols[0], y[0], x[0]), low, high)
        found.append(_Alike(tile=tile, rows=rows, cols=cols))
    return found


def _tiled(task: Task, cut: list[_Alike]) -> Sizes:
    """Return the sizes of a frame that is cut like this, but for the tiles themselves."""
    kernel = task.kernel
    largest = max((alike.tile for alike in cut), key=lambda tile: tile.points)
    tiles, points = sum(map(len, cut)), sum(len(alike) * alike.tile.points for alike in cut)
    fields = task.fields(largest)
    passes = -(-task.wavelengths // fields) if kernel.tapered and not kernel.round else 1  # over the scene
    held = task.spectra + fields + 4  # numbers of a frequency that are kept while its block is worked on
    held += task.channels if largest.singly else 0
    block_points = max(FEWEST_IN_BLOCK, 6 * BLOCK_POINTS // (6 + task.spectra + fields))
    at_once = TILES_AT_ONCE if kernel.round and tiles > 1 else 1
    counted = [task.nodes(alike.tile, alike.first) for alike in cut]
    edges, nodes = (max(float(counts.max()) for counts in some) for some in zip(*counted, strict=True))
    # Where an alias has few columns, a row of them takes what its first takes.
    _, rows_of_blocks = count_blocks(largest, block_points)
    of_spectra = prices.PER_EDGE_SUM * task.spectra_of_edge + prices.PER_EDGE_SPECTRUM * task.spectra
    by_edge = edges * (prices.PER_EDGE_POINT + of_spectra + prices.PER_EDGE_ROW * rows_of_blocks / largest.points)
    by_edge += prices.PER_SPECTRUM_POINT * task.spectra
    fewest_strips = STRIPS_AT_ONCE if at_once == 1 and largest.points > WORTH_A_THREAD else 1
    strip_points, by_spreading = _strips(task, largest, nodes, fewest_strips)
    spread = by_spreading < by_edge
    per_point = min(by_edge, by_spreading) + (prices.PER_ROUND_POINT if kernel.round else prices.PER_FIELD_POINT)
    seconds, fixed, transforms, making = tiles * (prices.PER_TILE + prices.PER_CLAMPED * task.edges), 0.0, 0.0, 0.0
    of_lens = [of_kernel(task, alike.tile, fields) for alike in cut]
    for alike, own in zip(cut, of_lens, strict=True):
        tile = alike.tile
        of_rows, of_columns = (0, 0) if tile.singly else tile.sums
        grid = min(float(tile.periods[0] * tile.periods[1]), tile.row_by_row / CHEAPER)
        each = passes * (per_point + task.of_footprint(tile)) + task.weights * prices.PER_POINT_WEIGHT
        seconds += len(alike) * (tile.points * each + task.channels * grid * prices.PER_GRID_POINT + own.seconds)
        fixed, making = max(fixed, own.held_bytes + 16.0 * of_columns * tile.rows), max(making, own.making_bytes)
        transforms = max(transforms, 16.0 * of_rows * of_columns)
    scenery = block_points * 16.0 * held
    if spread:
        scenery += _strip_bytes(task) * min(strip_points, 2.0 * largest.points) + NODE_BYTES * at_once * nodes
    fixed += max(making, scenery)  # one after the other
    fixed += 16.0 * task.shape[0] * task.shape[1] + 48.0 * min(PART, largest.periods[0] * largest.periods[1])
    transforms *= at_once
    channels = task.channels
    if fixed + channels * transforms > task.memory_limit_bytes:
        seconds += (channels - 1) * passes * per_point * points
        channels = 1
    return Sizes(
        tiles=(),
        spread=spread,
        channels=channels,
        fields=fields,
        block_points=block_points,
        strip_points=strip_points,
        fewest_strips=fewest_strips,
        pattern_rows=min(own.pattern_rows for own in of_lens),
        seconds=seconds,
        memory_bytes=fixed + channels * transforms,
        at_once=at_once,
    )


def _strips(task: Task, tile: Tile, nodes: float, fewest: int) -> tuple[int, float]:
    """Return the best size of strips, and seconds for each of the band's frequencies.

    Every strip is spread to from every node: the more there are the larger it had better be.
    """
    most = max(STRIP_POINTS, int(PART_OF_MEMORY * task.memory_limit_bytes / _strip_bytes(task)))
    best = STRIP_POINTS, math.inf
    size = STRIP_POINTS
    while True:
        count, points = count_strips(tile, size, fewest)
        seconds = task.spectra * prices.PER_SPREAD_POINT * points
        seconds += nodes * task.spectra_of_edge * count * prices.PER_SPREAD_NODE
        best = min(best, (size, seconds / tile.points), key=lambda one: one[1])
        if size == most:
            break
        size = min(2 * size, most)
    return best


def _strip_bytes(task: Task) -> float:
    return 16.0 * (SPREAD_HELD + task.spectra)
