"""The regions of a scene, ready to be transformed block by block: edge by edge, or from nodes along the edges."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.gridded import sums
from camsim.kernels import ahead, kernel, shared
from camsim.quadrature import gauss_pieces, gauss_rules
from camsim.rendering.edges import Edges, corners_of
from camsim.rendering.fourier.blocks import Block, Strip, blocks, strips
from camsim.rendering.fourier.clamped import netted
from camsim.rendering.fourier.edge_transforms import Corners, edge_transforms
from camsim.rendering.fourier.kernels import SceneBlock
from camsim.rendering.fourier.plan import STRIPS_AT_ONCE, Sizes
from camsim.rendering.fourier.task import MOST_NODES, OF_NODES, spreading_precision
from camsim.rendering.fourier.tile import Tile

EDGES_AT_ONCE, TURNED_AT_ONCE, ROWS_AT_ONCE = 1000, 10_000, 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Regions:
    """The regions of every spectrum on one tile, or of what several spectra are multiples of.

    areas       : (spectra,) square pitches
    tile, plan  : whose frequencies they are transformed at, and how
    corners     : edges by the corners that they share; None: not edge by edge, but
    along       : for each spectrum phases (2, m) of nodes on its edges, and strengths (m,)
    precision   : of the non-uniform transform, relative
    """

    areas: F64
    tile: Tile
    plan: Sizes
    corners: Corners | None
    along: tuple[tuple[F64, C128], ...] | None
    precision: float

    @classmethod
    def of(cls, edges: Edges, tile: Tile, plan: Sizes, shares: F64, tolerance: float) -> Regions:
        """Prepare the edges (pitches from the tile's first photosite) as the plan has it.

        shares : (sides, spectra) of what lies on a side of an edge, the background first: how much of each spectrum
        """
        jump = shares[edges.left] - shares[edges.right]
        start, end, jump = netted(edges.start, edges.end, jump, tile.low, tile.high)
        twice = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
        precision = spreading_precision(tolerance)
        return cls(
            areas=np.array([0.5 * np.sum(twice * own) for own in jump.T]),
            tile=tile,
            plan=plan,
            corners=None if plan.spread else Corners(*corners_of(start, end), jump),
            along=_strengths(start, end, jump, tile, precision) if plan.spread else None,
            precision=precision,
        )

    @property
    def seen(self) -> bool:
        """Whether there is anything to transform: of outlines that enclose nothing of the tile no edge is left."""
        if self.corners is not None:
            return len(self.corners.begin) > 0
        return any(strengths.size for _, strengths in self.along or ())

    def blocks(self) -> Iterator[tuple[Block, SceneBlock]]:
        """Yield the band block by block, with 4π²|k|² times the transform of each spectrum's regions."""
        if self.along is None:
            assert self.corners is not None
            for block in blocks(self.tile, self.plan.block_points):
                transforms = edge_transforms(block.place(self.tile), self.corners)
                yield block, SceneBlock(transforms, self.areas)
            return
        for strip, whole in self.strips():
            for block in strip.blocks(self.tile, self.plan.block_points):
                transforms = np.empty((self.areas.size, block.count_j, 2, block.count_i))
                for own, values in zip(transforms, whole, strict=True):
                    part = strip.part(values, block)
                    own[:, 0], own[:, 1] = part.real, part.imag
                yield block, SceneBlock(transforms, self.areas)

    def strips(self) -> Iterator[tuple[Strip, list[C128]]]:
        """Yield the half plane strip by strip, with the transform of each spectrum's regions from nodes on edges."""
        assert self.along is not None
        along = self.along

        def transformed(strip: Strip) -> tuple[Strip, list[C128]]:
            return strip, [_spread(strip, self.tile, *own, self.precision) for own in along]

        every = strips(self.tile, self.plan.strip_points, self.plan.fewest_strips)
        if self.plan.at_once > 1 or len(every) == 1:
            yield from map(transformed, every)
        else:
            yield from ahead(transformed, every, STRIPS_AT_ONCE)


def _strengths(start: F64, end: F64, jump: F64, tile: Tile, precision: float) -> tuple[tuple[F64, C128], ...]:
    regions = []
    for own in jump.T:
        mine = slice(None) if own.all() else np.flatnonzero(own)
        regions.append(gauss_nodes(start[mine], end[mine], own[mine], tile, OF_NODES * precision))
    return tuple(regions)


def gauss_nodes(start: F64, end: F64, times: F64, tile: Tile, allowed: float) -> tuple[F64, C128]:
    """Return phases (2, m) of nodes on edges, and strengths (m,): weights times ey + i·ex, parts of the edge.

    times : (n,) what each edge's strengths are multiplied by

    As many as the phase along the edge asks for at the highest frequency; long edges are cut into pieces first.
    """
    if not len(start):  # of a spectrum that no edge in sight has
        return np.empty((2, 0)), np.empty(0, complex)
    pieces, orders = gauss_pieces(np.pi * tile.cut * np.hypot(*(end - start).T), allowed, MOST_NODES)
    first = np.concatenate([[0], np.cumsum(pieces * orders)])
    counts = tuple(np.flatnonzero(np.bincount(orders)).tolist())
    rules = gauss_rules(counts)
    which = np.searchsorted(rules[2], orders)
    phases, strengths = np.empty((2, first[-1])), np.empty(first[-1], complex)

    def work(begin: int, stop: int) -> None:
        of_edges = start[begin:stop], end[begin:stop], times[begin:stop]
        _lay(
            of_edges,
            pieces[begin:stop],
            which[begin:stop],
            rules,
            first[begin:stop],
            tile.periods,
            tile.centre,
            phases,
            strengths,
        )

    shared(len(start), work, least=EDGES_AT_ONCE)
    return phases, strengths


@kernel()
def _lay(
    edges: tuple[F64, F64, F64],
    pieces: I64,
    which: I64,
    rules: tuple[F64, F64, I64],
    first: I64,
    periods: tuple[int, int],
    centre: tuple[int, int],
    phases: F64,
    strengths: C128,
) -> None:
    """Write the nodes of each edge's pieces, by its rule: phases, and weights times its way."""
    (start, end, times), (x, w, count), (px, py), (cx, cy) = edges, rules, periods, centre
    for e in range(len(start)):
        n, rule, ex, ey = first[e], which[e], end[e, 0] - start[e, 0], end[e, 1] - start[e, 1]
        for piece in range(pieces[e]):
            for q in range(count[rule]):
                t = (piece + 0.5 * (1.0 + x[rule, q])) / pieces[e]
                phases[0, n] = _phase((start[e, 0] - cx + t * ex) / px)
                phases[1, n] = _phase((start[e, 1] - cy + t * ey) / py)
                weight = 0.5 * w[rule, q] / pieces[e] * times[e]
                strengths[n] = complex(weight * ey, weight * ex)
                n += 1


@kernel()
def _phase(turns: float) -> float:
    """Return the radians of what is left of turns without whole ones."""
    return 2.0 * math.pi * (turns - math.floor(turns + 0.5))


def _spread(strip: Strip, tile: Tile, phases: F64, strengths: C128, precision: float) -> C128:
    """Return 4π²|k|²·F = 2πi Σ (kx·ey − ky·ex)·exp(−2πi k·y) over the nodes: (count_j, count_i).

    phases    : (2, m) of the nodes
    strengths : (m,) weights times ey + i·ex, parts of the edge; times −1 where the region lies to the right

    Outlines are closed, so Σ (k·e)·exp(−2πi k·y) = 0. And (kx + i·ky)(ey + i·ex) = kx·ey − ky·ex + i·(k·e): one sum.
    """
    whole = sums_of_waves(strip, tile, phases, strengths, precision)
    shared(len(whole), functools.partial(_slope, whole, strip.first_j, tile.periods), least=ROWS_AT_ONCE)
    return whole


@kernel()
def _slope(whole: C128, first_j: int, periods: tuple[int, int], begin: int, stop: int) -> None:
    """Multiply some rows by 2πi(kx + i·ky)."""
    px, py = periods
    for row in range(begin, stop):
        ky = 2.0 * math.pi * (first_j + row) / py
        for col in range(whole.shape[1]):
            whole[row, col] *= complex(-ky, 2.0 * math.pi * col / px)


def phases_of(places: F64, tile: Tile) -> F64:
    """Return 2π times places (m, 2) in periods, from the middle of the tile's scenery, less whole turns: (2, m)."""
    turns = np.stack([(places[:, axis] - tile.centre[axis]) / tile.periods[axis] for axis in (0, 1)])
    return 2.0 * np.pi * (turns - np.rint(turns))


def sums_of_waves(strip: Strip, tile: Tile, phases: F64, strengths: C128, precision: float) -> C128:
    """Return Σ strengths·exp(−2πi k·y) over nodes, by their phases (2, m), on a strip: (count_j, count_i)."""
    shape = strip.count_j, strip.count_i
    if not strengths.size:
        return np.zeros(shape, complex)
    turned = np.empty_like(strengths)
    # The integers of a sum run about 0: the middle is moved there.
    middle = strip.count_i // 2, strip.first_j + strip.count_j // 2
    shared(strengths.size, functools.partial(_turn, phases, strengths, middle, turned), least=TURNED_AT_ONCE)
    numbers = strip.first_j + np.arange(strip.count_j), np.arange(strip.count_i)
    from_corner = tuple(
        np.exp(-2j * np.pi * ((number * tile.centre[axis]) % tile.periods[axis]) / tile.periods[axis])
        for number, axis in zip(numbers, (1, 0), strict=True)
    )
    return sums(phases[1], phases[0], turned, shape, from_corner, precision)


@kernel()
def _turn(phases: F64, strengths: C128, middle: tuple[int, int], turned: C128, begin: int, stop: int) -> None:
    """Turn some strengths back by what their phases are in the middle."""
    for n in range(begin, stop):
        angle = phases[0, n] * middle[0] + phases[1, n] * middle[1]
        turned[n] = strengths[n] * complex(math.cos(angle), -math.sin(angle))
