"""What the check sees of a gradient: points of light by Gauss's rule on cells of a pitch, from its own formula.

Far from a photosite many cells are one block: there the rule follows the gradient's own waves and a light that falls
smoothly, and nearer the lens's too. So a gradient of any size takes few points.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.kept import cached_property
from camsim.quadrature import gauss_legendre, gauss_order
from camsim.rendering.check.blocks import Blocks, walk
from camsim.rendering.check.patch_nodes import count_gathered, gathered, in_patch
from camsim.rendering.check.scene_samples import COUNTED, Seen, Zone
from camsim.scene.gradients import Gradient
from camsim.scene.raster import Interpolation, Raster
from camsim.spectra.curve import Spectrum

PART = 0.5  # of its distance from all about which the light or the gradient bends: the largest side of a block
MOST_NODES = 60  # along a side
MOST_SIDES = 64  # of outlines in a block: many lie in as many bands, each with nodes of its own
TOGETHER = 1 << 16  # points, about
LEFT_OUT = 2 * MOST_NODES  # the order of what is not looked at
DISTANCES = 64  # asked how far outlines are heard


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cell(Raster):
    """The cell of a pitch in a gradient's middle; nothing is in it."""

    planes: F64
    spectra: tuple[Spectrum, ...]
    width_um: float
    centre_um: tuple[float, float]
    rotate_deg: float
    interpolation: Interpolation = "squares"

    @classmethod
    def of(cls, gradient: Gradient, pitch_um: float) -> Cell:
        """Return it."""
        return cls(
            planes=np.zeros((len(gradient.spectra), 1, 1)),
            spectra=gradient.spectra,
            width_um=pitch_um,
            centre_um=gradient.centre_um,
            rotate_deg=gradient.rotate_deg,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenGradient(Seen):
    """One gradient, pitches; ``picture``: its cell.  highest: frequency of the lens, cycles/pitch; allowed: error."""

    gradient: Gradient
    highest: float
    allowed: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of cells that cover it."""
        wide, tall = (2 * math.ceil(half / self.pitch_um) for half in self.gradient.half_um)
        return tall, wide

    @property
    def step(self) -> float:
        """Side of a cell: a pitch."""
        return 1.0

    @property
    def values(self) -> F64:
        """Of no patch."""
        return np.zeros((self.planes, 1, 1))

    @property
    def whole(self) -> np.ndarray:
        """No patch is a sample's."""
        return np.zeros((1, 1), bool)

    def _nodes(self, side: int, highest: float, allowed: float) -> int:
        """Return the order of a rule on a block of some side, for waves of the lens and the gradient."""
        phase = math.pi * side * (highest + self.gradient.cycles_per_um * self.pitch_um)
        return gauss_order(phase, allowed, least=2, most=MOST_NODES)

    def _orders(self, zones: Sequence[Zone]) -> I64:
        """Return (zones + 1, levels): orders of rules on blocks of sides 1, 2, 4 …; 0 where they save nothing.

        The light is analytic as far off as it is far away, and half as far at most eight times as large; in an ellipse
        about the side whose half axes add up to ρ halves of it, half the distance the shorter one, n nodes leave
        (64/15)·8·ρ^{−2n} of it. Nodes for a product's factors add up.
        """
        levels = (max(self.shape) - 1).bit_length() + 1
        rules = [(self.highest, more) for more, _ in zones] + [(0.0, 1.0)]
        orders = np.zeros((len(rules), levels), np.int64)
        log_rho = math.asinh(1.0 / PART)
        for own, (highest, more) in zip(orders, rules, strict=True):
            allowed = min(max(self.allowed, 1e-12) * more, 1e-2)
            bent = math.ceil(0.5 * math.log(35.0 / allowed) / log_rho)
            fewest = math.inf
            for level in range(levels):
                order = self._nodes(1 << level, highest, allowed)
                if order == MOST_NODES and level:
                    break
                order += bent if level else 0
                if order**2 / 4.0**level < fewest:
                    own[level], fewest = order, order**2 / 4.0**level
        return orders

    def lit_near(self, point: F64, zones: Sequence[Zone], *, beyond: bool = True) -> Iterator[tuple[F64, F64]]:
        """Yield places and light of blocks and parts of blocks, of a cell's area 1, finer where they lie near."""
        orders, ends = self._orders(zones), [low for _, (low, _) in zones[1:]] + [zones[-1][1][1]]
        if not beyond:
            orders[-1] = LEFT_OUT
        waiting: list[tuple[F64, F64]] = []
        for blocks in walk(self._sides, self.shape, lambda blocks: self._ordered(blocks, point, orders, ends) > 0):
            of_each = self._ordered(blocks, point, orders, ends)
            for order in np.unique(of_each[of_each != LEFT_OUT]).tolist():
                for lit in self._lit(blocks.some(of_each == order), order):
                    waiting.append(lit)
                    if sum(len(places) for places, _ in waiting) >= TOGETHER:
                        yield _joined(waiting)
                        waiting = []
        if waiting:
            yield _joined(waiting)

    def in_step_until(self, points: F64, longest: float, most: float, farthest: float) -> float:
        """Return how far off its outlines may be heard, all in step: within them rings of shorter waves cancel.

        An outline leaves λN/2π of the rings beside it, and what its own waves add is at most half of that, and half of
        the half …  Of a line at r no more is heard than of 2r in its nearest place.
        """
        if longest * self.gradient.cycles_per_um * self.pitch_um > 0.5:
            return farthest
        start, end = self._sides
        length = np.hypot(*(end - start).T)
        until = 0.0
        for point in (points - self.corner) @ self.axes.T:
            middle = np.hypot(*(0.5 * (start + end) - point).T)
            low, high = np.maximum(middle - 0.5 * length, 0.0), middle + 0.5 * length
            for distance in np.geomspace(longest, farthest, DISTANCES):
                near = np.maximum(low, distance)
                heard = np.minimum(length, 2.0 * near) / near**3
                if most * longest / math.pi * float(heard[high > distance].sum()) <= 1.0:
                    break
            until = max(until, float(distance))
        return until

    def _ordered(self, blocks: Blocks, point: F64, orders: I64, ends: Sequence[float]) -> I64:
        """Return (n,) the order of the rule on each block, 0 where it is to be parted."""
        level = blocks.side.bit_length() - 1
        middle: F64 = blocks.at.astype(np.float64) + 0.5 * blocks.side
        reach = blocks.side * math.sqrt(0.5)
        gap = np.hypot(*(self._placed(middle) - point).T) - reach
        order: I64 = orders[np.searchsorted(ends, gap), level]
        if level:
            bends = gap
            if math.isfinite(self.gradient.smallest_um):
                rows, cols = self.shape
                bends = np.minimum(gap, np.hypot(*(middle - 0.5 * np.array([cols, rows])).T) - reach)
            fits = (blocks.side <= PART * bends) & (blocks.sides <= MOST_SIDES)
            order = np.where(fits | (order == LEFT_OUT), order, 0)
        return order

    def _lit(self, blocks: Blocks, order: int) -> Iterator[tuple[F64, F64]]:
        """Yield places and light of blocks by a rule, some at a time."""
        x, w = gauss_legendre(order)
        t = 0.5 * blocks.side * (1.0 + np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2))
        weights = 0.25 * blocks.side**2 * np.outer(w, w).ravel()
        whole, together = blocks.at[~blocks.cut], max(1, TOGETHER // order**2)
        for first in range(0, len(whole), together):
            some = whole[first : first + together]
            at = (some[:, None] + t).reshape(-1, 2)
            yield self._placed(at), self._at(at) * np.tile(weights, len(some))
        # Of a cell one rule does for all distances: photosites ask for the same ones.
        of_parts = self.order if blocks.side == 1 else order + 1
        for k in np.flatnonzero(blocks.cut).tolist():
            yield self._part(blocks, k, of_parts)

    def _part(self, blocks: Blocks, k: int, order: int) -> tuple[F64, F64]:
        """Return those of what outlines leave of a block."""
        key = (blocks.side, *blocks.at[k].tolist(), order)
        if key not in self._kept:
            nodes, weights = in_patch(*blocks.outlines(self._sides, k), order)
            at = blocks.at[k] + blocks.side * nodes
            nodes, light = gathered(nodes, self._at(at) * (blocks.side**2 * weights), order)
            self._kept[key] = self._placed(blocks.at[k] + blocks.side * nodes), light
        return self._kept[key]

    @cached_property
    def _kept(self) -> dict[tuple[int, ...], tuple[F64, F64]]:
        """Parts of blocks: photosites that lie near one another ask for the same ones."""
        return {}

    def points_near(self, zones: Sequence[Zone]) -> F64:
        """Return (zones + 1,) about how many points lie in each zone about a photosite, and beyond."""
        orders = self._orders(zones)
        cells = float(math.prod(self.shape))
        counts = np.zeros(len(orders))
        rings = [(zone, bounds) for zone, (_, bounds) in enumerate(zones)]
        low = zones[-1][1][1]
        while low < math.hypot(*self.shape):
            rings.append((len(zones), (low, 2.0 * low)))
            low *= 2.0
        for zone, (low, high) in rings:
            fits = [k for k, order in enumerate(orders[zone]) if order and (k == 0 or 1 << k <= PART * low)]
            whole = min(float(orders[zone, k]) ** 2 / 4.0**k for k in fits) * min(math.pi * (high**2 - low**2), cells)
            side = 1 << max(fits)
            counts[zone] += whole + self._each_part * min(self._around / side, 4.0 * (high - low) / side + 1.0)
        return counts

    @cached_property
    def _around(self) -> float:
        """How many cells outlines cut, about."""
        start, end = self._sides
        return float(np.abs(end - start).sum()) + len(start)

    @cached_property
    def _each_part(self) -> float:
        """How many points a cell has that is cut, of some."""
        start, end = self._sides
        middles = 0.5 * (start + end)[:: max(1, len(start) // COUNTED)]
        blocks = Blocks.of(self._sides, 1, np.floor(middles).astype(np.int64))
        counts = [in_patch(*blocks.outlines(self._sides, k), self.order)[1].size for k in range(len(middles))]
        return sum(count_gathered(count, self.order) for count in counts) / max(1, len(middles))

    def farthest(self, points: F64) -> float:
        """Return the largest distance of a photosite from a corner of its cells."""
        rows, cols = self.shape
        ends = self._placed(np.array([[0, 0], [cols, 0], [cols, rows], [0, rows]], float))
        return float(np.hypot(*(points[:, None] - ends[None]).transpose(2, 0, 1)).max())

    def _placed(self, cells: F64) -> F64:
        """Return where places (n, 2) in cells from the first one's corner lie."""
        placed: F64 = self.corner + cells @ self.axes
        return placed

    def _at(self, cells: F64) -> F64:
        """Return (planes, n) the field at places (n, 2) in cells from the first one's corner."""
        rows, cols = self.shape
        x, y = (cells - 0.5 * np.array([cols, rows])).T * self.pitch_um
        planes = self.gradient.planes_at(x, y) - self.less[:, None]
        return np.concatenate([planes, np.ones((1, len(x)))]) if self.ones else planes


def _joined(lit: Sequence[tuple[F64, F64]]) -> tuple[F64, F64]:
    """Return places and light as one."""
    return np.concatenate([places for places, _ in lit]), np.concatenate([light for _, light in lit], axis=1)
