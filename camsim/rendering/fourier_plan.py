"""The Fourier engine's sizes, chosen before anything is computed: tiles, periods, taper, memory and time.

A periodic transform sees every photosite and every edge again a period further on. Nothing of that is wrong as long as
the lens's kernel is 0 there. So the kernel is multiplied by a taper that is 1 out to ``inner``, the largest distance
between a photosite and an edge, and 0 from ``outer`` on; with a period of at least ``outer`` plus the extent nothing
wraps round. Tapering widens the kernel's band from its cut-off to cutoff + margin/(outer − inner).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import fft, special

from camsim.arrays import F64
from camsim.rendering.budget import ErrorBudget

MOST_TILES, SMALLEST_TILE = 64, 64  # along an axis; photosites
TAPER_DEGREE = 63
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
class Tile:
    """A window of the frame and how it is transformed; lengths in pitches.

    row, col, rows, cols : the window
    inner, outer : radii of a round taper; of a square one half its sides along x (``inner_y`` and so on along y)
    periods      : along x and y, whole
    cut          : highest frequency kept, cycles/pitch
    low, high    : corners of what the scene is clamped to, from the tile's first photosite
    """

    row: int
    col: int
    rows: int
    cols: int
    inner: tuple[float, float]
    outer: tuple[float, float]
    periods: tuple[int, int]
    cut: float
    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def points(self) -> float:
        """Frequencies that are computed: half of those within the band, the others are their mirror images."""
        return 0.5 * math.pi * self.cut**2 * self.periods[0] * self.periods[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class FourierPlan:
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """How much there is to do, for the cost: numbers of edges, spectra, channels and wavelengths."""

    edges: int
    length: float
    spectra: int
    channels: int
    wavelengths: int


def plan_fourier(
    kernel: Kernel,
    *,
    shape: tuple[int, int],
    low: F64,
    high: F64,
    footprint: tuple[float, float],
    work: Work,
    tolerance: float,
    memory_limit_bytes: float,
) -> FourierPlan:
    """Choose the cheapest plan that keeps within the memory; the least hungry one when none does.

    low, high : (2,) corners of the scene's edges, pitches from the first photosite
    footprint : how far the footprint reaches along x and y
    """
    best: FourierPlan | None = None
    count = 1
    while True:
        plan = _tiled(kernel, shape, low, high, footprint, work, tolerance, memory_limit_bytes, count)
        if best is None or _rank(plan, memory_limit_bytes) < _rank(best, memory_limit_bytes):
            best = plan
        count *= 2
        hopeless = best.memory_bytes <= memory_limit_bytes and plan.seconds > 2.0 * best.seconds
        if count > MOST_TILES or max(shape) < count * SMALLEST_TILE or hopeless:
            return best


def _rank(plan: FourierPlan, memory_limit_bytes: float) -> tuple[bool, float]:
    """Order plans: those that fit by their time, before those that do not by their memory."""
    fits = plan.memory_bytes <= memory_limit_bytes
    return not fits, plan.seconds if fits else plan.memory_bytes


def _tiled(
    kernel: Kernel,
    shape: tuple[int, int],
    low: F64,
    high: F64,
    footprint: tuple[float, float],
    work: Work,
    tolerance: float,
    memory_limit_bytes: float,
    count: int,
) -> FourierPlan:
    """Return the plan with ``count`` tiles along the longer side."""
    side = math.ceil(max(shape) / count)
    tiles: list[Tile] = []
    margin = sharpness = 0.0
    for row in range(0, shape[0], side):
        for col in range(0, shape[1], side):
            rows, cols = min(side, shape[0] - row), min(side, shape[1] - col)
            tile, margin, sharpness = _tile(kernel, row, col, rows, cols, low, high, footprint, work.edges, tolerance)
            tiles.append(tile)
    largest = max(tiles, key=lambda tile: tile.points)
    nodes = NODES_PER_RADIAN * 2.0 * math.pi * largest.cut * work.length + FEWEST_ON_EDGE * work.edges
    fields = 0 if kernel.round else 1 if kernel.tapered else work.wavelengths
    held = work.spectra + fields + 4  # numbers of a frequency that are kept while its block is worked on
    plain, spreading = (
        max(FEWEST_IN_BLOCK, 6 * most // (6 + work.spectra + fields)) for most in (BLOCK_POINTS, SPREAD_POINTS)
    )
    # Every block is spread to from every node: with more nodes than frequencies in a block it had better be larger.
    roomy = SPREAD_MEMORY * memory_limit_bytes / (16.0 * (held + SPREAD_HELD))
    spreading = max(spreading, int(min(nodes, roomy)))
    # Where an alias has few columns, a row of them takes what its first takes.
    _, rows_of_blocks = count_blocks(largest, plain)
    by_edge = work.edges * (PER_EDGE_POINT + PER_EDGE_ROW * rows_of_blocks / largest.points)
    by_spreading = work.spectra * PER_SPREAD_POINT
    calls, _ = count_blocks(largest, spreading)
    by_spreading += 2.0 * nodes * calls * PER_SPREAD_NODE / largest.points
    spread = by_spreading < by_edge
    block_points = spreading if spread else plain
    weights = work.spectra * work.channels * (1 if kernel.round else work.wavelengths)
    passes = work.wavelengths if kernel.tapered and not kernel.round else 1
    per_point = min(by_edge, by_spreading) + (PER_ROUND_POINT if kernel.round else PER_FIELD_POINT)
    seconds, fixed, transforms = PER_TILE * len(tiles), 0.0, 0.0
    for tile in tiles:
        area = tile.periods[0] * tile.periods[1]
        seconds += tile.points * (passes * per_point + weights * PER_POINT_WEIGHT)
        seconds += work.channels * area * PER_GRID_POINT
        samples = 4.0 * tile.cut**2 * area
        kernel_bytes = 0.0
        if kernel.round:
            seconds += PER_KERNEL_SAMPLE * work.spectra * work.channels * (2.0 * tile.cut * tile.outer[0]) ** 2
            seconds += PER_PATTERN_BLUR * work.wavelengths * tile.outer[0] / kernel.blur
            kernel_bytes = 8.0 * 12 * work.spectra * work.channels * (32.0 * tile.outer[0] * tile.cut)
        elif kernel.tapered:
            seconds += work.wavelengths * PER_PUPIL_NODE * (tile.outer[0] * tile.outer[1] / kernel.blur**2 + samples)
            kernel_bytes = 160.0 * samples
        fixed = max(fixed, kernel_bytes + area * 8.0 * tile.rows / tile.periods[1])
        transforms = max(transforms, area * 8.0)
    fixed += block_points * 16.0 * (held + SPREAD_HELD * spread) + 64.0 * nodes * spread
    fixed += 16.0 * shape[0] * shape[1] + 48.0 * min(PART, largest.periods[0] * largest.periods[1])
    channels = work.channels
    if fixed + channels * transforms > memory_limit_bytes:
        seconds += (channels - 1) * passes * per_point * sum(tile.points for tile in tiles)
        channels = 1
    return FourierPlan(
        tiles=tuple(tiles),
        margin=margin,
        sharpness=sharpness,
        spread=spread,
        channels=channels,
        block_points=block_points,
        seconds=seconds,
        memory_bytes=fixed + channels * transforms,
    )


def _tile(
    kernel: Kernel,
    row: int,
    col: int,
    rows: int,
    cols: int,
    low: F64,
    high: F64,
    footprint: tuple[float, float],
    edges: int,
    tolerance: float,
) -> tuple[Tile, float, float]:
    """Return one tile, and margin and sharpness of its taper."""
    size = np.array([cols - 1.0, rows - 1.0])
    first = np.array([col, row], float)
    beyond = kernel.reach + np.array(footprint)
    box_low = np.clip(low - first, -beyond, size + beyond)
    box_high = np.clip(high - first, -beyond, size + beyond)
    extent = np.maximum(np.maximum(box_high, size - box_low), 0.0) + np.array(footprint)
    inner_round = min(kernel.reach, float(np.hypot(*extent)))
    inner = np.full(2, inner_round) if kernel.round else np.minimum(extent, kernel.reach)
    if not kernel.tapered:
        margin = sharpness = width = 0.0
        inner = np.full(2, kernel.reach)
    else:
        level = ErrorBudget(tolerance).allowed("taper") / kernel.beyond(float(inner.min()), edges)
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


def taper_margin(level: float) -> tuple[float, float]:
    """Return how far the taper's band reaches (in 1/width) and its β, for side lobes of ``level``.

    The taper's slope is a Kaiser–Bessel window: its transform is sinh(√(β² − x²))/√(…) with x = π·k·width up to
    x = β, and beyond only ripples of about 1/sinh β of its height.
    """
    sharpness = math.log(2.0 / level) + 1.0
    return (sharpness + 1.0) / math.pi, sharpness


def taper(sharpness: float) -> np.polynomial.Chebyshev:
    """Return the taper from 1 at −1 to 0 at 1 as a polynomial: 1 minus the running integral of its window."""
    window = np.polynomial.Chebyshev.interpolate(
        lambda t: special.i0(sharpness * np.sqrt((1.0 - t) * (1.0 + t))) / special.i0(sharpness), TAPER_DEGREE
    )
    total = window.integ(lbnd=-1)
    return 1.0 - total / total(1.0)


def tapered(distance: F64, inner: float, outer: float, shape: np.polynomial.Chebyshev) -> F64:
    """Return the taper at distances (0 or more)."""
    if outer == inner:
        return np.ones_like(distance)
    t = np.clip((2.0 * distance - inner - outer) / (outer - inner), -1.0, 1.0)
    values: F64 = shape(t)
    return values


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Neighbouring frequencies (i/Px, j/Py), all in one alias of the half plane 0 … Px/2.

    first_i, count_i : of i;  first_j, count_j: of j
    column, row      : where the first of them falls on the photosites' own grid of frequencies (rows go round)
    """

    first_i: int
    count_i: int
    first_j: int
    count_j: int
    column: int
    row: int


def _aliases(tile: Tile) -> Iterator[tuple[int, int, int, int]]:
    """Yield the band's aliases of the half plane 0 … Px/2: number, first and last i, and the largest |j| in them."""
    px, py = tile.periods
    half = px // 2 + 1
    furthest_i = math.floor(tile.cut * px)
    for p in range(-(furthest_i // px) - 1, furthest_i // px + 1):
        first_i, last_i = max(p * px, -furthest_i), min(p * px + half - 1, furthest_i)
        if first_i > last_i:
            continue
        nearest = 0 if first_i <= 0 <= last_i else min(abs(first_i), abs(last_i))
        yield p, first_i, last_i, math.floor(py * math.sqrt(max(tile.cut**2 - (nearest / px) ** 2, 0.0)))


def _rows_of_block(most: int, columns: int) -> int:
    return max(1, most // columns)


def count_blocks(tile: Tile, most: int) -> tuple[int, int]:
    """Return how many blocks ``blocks`` yields, and their rows together: without them, which may be 10⁸.

    >>> tile = Tile(row=0, col=0, rows=1, cols=1, inner=(2.0, 2.0), outer=(4.0, 4.0), periods=(12, 10), cut=1.7,
    ...             low=(0.0, 0.0), high=(1.0, 1.0))
    >>> cut = list(blocks(tile, 20))
    >>> count_blocks(tile, 20) == (len(cut), sum(block.count_j for block in cut))
    True
    """
    count = rows = 0
    for _, first_i, last_i, high in _aliases(tile):
        count += -(-(2 * high + 1) // _rows_of_block(most, last_i - first_i + 1))
        rows += 2 * high + 1
    return count, rows


def blocks(tile: Tile, most: int) -> Iterator[Block]:
    """Cut the band into blocks of at most about ``most`` frequencies."""
    px, py = tile.periods
    for p, first_i, last_i, high in _aliases(tile):
        band = _rows_of_block(most, last_i - first_i + 1)
        for first_j in range(-high, high + 1, band):
            yield Block(
                first_i=first_i,
                count_i=last_i - first_i + 1,
                first_j=first_j,
                count_j=min(band, high + 1 - first_j),
                column=first_i - p * px,
                row=first_j % py,
            )
