"""Photosites behind a round lens, computed again: E(r) integrated along the outlines, averaged over the footprint by a
Gauss rule."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.optics import RoundLens
from camsim.quadrature import gauss_error, gauss_legendre
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.check.pattern import Table, loudness, table_of
from camsim.rendering.check.points import PANEL_BLURS, PANEL_NODES, SHORT, Asked, Parts, Tables, light_at_points
from camsim.rendering.check.scenery import Pieces
from camsim.rendering.check.wavelengths import condensed
from camsim.rendering.check.zones import FAR_PART, Rule, Zones, zones_of

NEAREST = 12.0  # blurs: where the search for silence begins
FEW = 4.0  # ends that some photosite hears from just outside, wherever it lies
FARTHER = 1.4  # times, at each step of it
LOOKED_AT = 24  # places in the frame where ends are heard
FALLS = 1.5  # at least this power of the distance is what swings lost with
NODE_SECONDS, PIECE_SECONDS, POINT_SECONDS = 4e-9, 5e-8, 1e-4  # of one core, measured
PASSED_SECONDS = 3e-9  # of a piece that lies in another zone
ROUND = 5.0  # times as long for a node on a round piece: a sine and a cosine


@dataclass(frozen=True, kw_only=True, eq=False)
class Integrals:
    """The check's settings for a round lens; lengths in pitches.

    sides, spots : of the photosite, (n, 2) of the OLPF, pitches
    pieces, pair, times : of the scene, what lies beside each, and by how much more or less of it
    wavelength_nm, weights : (n,) and (pairs, channels, n) left minus right, of full scale
    budget       : of what the check may be wrong by
    corners      : (4,) low x, low y, high x, high y of the outermost photosites
    """

    lens: RoundLens
    sides: tuple[float, float]
    spots: F64
    pitch_um: float
    pieces: Pieces
    pair: I64
    times: F64
    wavelength_nm: F64
    weights: F64
    budget: ErrorBudget
    corners: F64

    @functools.cached_property
    def rule(self) -> Rule:
        """Nodes (m, 2) and weights (m,) over photosite and spots, that follow the shortest wave."""
        return self._rule(max(self._orders))

    @functools.cached_property
    def zones(self) -> Zones:
        """This rule for what is near, and others of fewer nodes."""
        gap = self._parts.gaps(self._listeners)
        contrast = np.abs(self.weights).sum(axis=2).max(axis=1)[self.pair] * np.abs(self.times)
        light = np.where(gap > self.radius, contrast * self.pieces.outlines.length / np.maximum(gap, self.radius), 0.0)
        return zones_of(
            self._rule,
            order=max(self._orders),
            half=0.5 * max(self.sides),
            light=float(light.sum(axis=1).max(initial=0.0)) / math.tau,
            allowed=FAR_PART * self.budget.allowed("footprint rule"),
        )

    @functools.cached_property
    def _orders(self) -> list[int]:
        """How many nodes follow the shortest wave along either side."""
        shortest = float(self._blur.min())
        orders, allowed = [], math.log((1.0 - FAR_PART) * self.budget.allowed("footprint rule"))
        for side in self.sides:
            order = 1 if side == 0.0 else 3
            while side and gauss_error(order, math.pi * side / shortest) > allowed:
                order += 1
            orders.append(order)
        return orders

    def _rule(self, most: int) -> Rule:
        """Return nodes (m, 2) and weights (m,) over photosite and spots, at most so many along a side."""
        axes = [gauss_legendre(min(order, most)) for order in self._orders]
        (x, wx), (y, wy) = ((0.5 * side * x, 0.5 * w) for side, (x, w) in zip(self.sides, axes, strict=True))
        square = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        nodes = (self.spots[:, None] + square).reshape(-1, 2)
        return nodes, np.tile(np.outer(wx, wy).ravel() / len(self.spots), len(self.spots))

    @functools.cached_property
    def radius(self) -> float:
        """Distance from which on no end, no corner and no line is heard: E is taken from its table as far as that."""
        blur = float(self._blur.max())
        places = self._listeners
        ends, strength = self._ends
        distance = np.hypot(*(places[:, None] - ends[None]).transpose(2, 0, 1))
        h, beside = self._feet(places)
        heard = np.concatenate([distance, np.where(beside, np.abs(h), np.inf)], axis=1)
        square = np.concatenate([strength**2, np.full(h.shape[1], 4.0)])
        everything = self._farthest
        radius = max(NEAREST * blur, 2.0 * self._extent)
        while radius < everything:
            beyond = np.sum(square * (radius / np.maximum(heard, radius)) ** 5 * (heard > radius), axis=1)
            together = max(FEW, float(beyond.max()))
            swing = self._swing_at(radius)
            if 2.0 * swing * math.sqrt(blur / radius * together) / (4.0 * math.pi) <= self.budget.allowed("beyond"):
                break
            radius *= FARTHER
        return min(radius, max(everything, NEAREST * blur)) + self._extent

    @functools.cached_property
    def seconds_each(self) -> float:
        """What one photosite is expected to take."""
        o, blur = self.pieces.outlines, self._blur
        length, bent = o.length, o.turn_rad != 0.0
        gap = self._parts.gaps(self._listeners)
        near = np.where(gap < self.radius, np.minimum(length, 2.0 * self.radius), 0.0)
        panels = np.ceil(near / (PANEL_BLURS * float(blur.min())))
        # Beyond the table a round piece takes panels that double in length on either side, a short one but a few nodes.
        beyond = PANEL_NODES * (2.0 + 2.0 * np.log2(1.0 + length / self.radius))
        for count, short in SHORT:
            beyond = np.where((gap > self.radius) & (0.5 * length < short * (gap + 0.5 * length)), count, beyond)
        nodes = PANEL_NODES * panels * np.where(bent, ROUND, 1.0) + ROUND * beyond * bent
        seconds = POINT_SECONDS
        for (low, high), (points, _) in zip(
            itertools.pairwise(self.zones.ends(np.array([self.radius]))), self.zones.rules, strict=True
        ):
            here = (low <= gap) & (gap < high)
            each = np.where(here, nodes * NODE_SECONDS + PIECE_SECONDS, 0.0).sum(axis=1).mean()
            seconds += len(points) * (float(each) + len(length) * PASSED_SECONDS)
        return seconds

    def values(self, points: F64, sets: I64) -> F64:
        """Return the light at points (m, 2) besides the background's, each in its channel."""
        radius = np.array([self._radius_at(point) for point in points])
        table = self._table(float(radius.max()), float(radius.max()))
        pairs, channels = self.weights.shape[:2]
        tables = Tables(
            table.cells.reshape(pairs, channels, *table.cells.shape[1:]),
            table.step,
            table.far.reshape(pairs, channels, 4),
        )
        values: F64 = np.zeros(len(points))
        # All of what is farther is seen by its smooth powers, wherever on the photosite.
        ends = self.zones.ends(radius + self._extent)
        for (least, most), (nodes, weights) in zip(itertools.pairwise(ends), self.zones.rules, strict=True):
            if (least < most).any():
                asked = Asked(points, sets, radius, nodes, least, most)
                panel = PANEL_BLURS * float(self._blur.min())
                values += light_at_points(asked, self.pieces.outlines, self._parts, tables, panel) @ weights
        return values

    @functools.cached_property
    def _parts(self) -> Parts:
        return Parts.of(self.pieces.outlines, self.pair, self.times)

    @functools.cached_property
    def _extent(self) -> float:
        """How far the rule reaches from a photosite's middle."""
        return float(np.hypot(*self.rule[0].T).max())

    @functools.cached_property
    def _blur(self) -> F64:
        return self._blur_at(self.wavelength_nm)

    def _blur_at(self, wavelength_nm: F64) -> F64:
        return np.array([self.lens.blur_um(float(w)) for w in wavelength_nm]) / self.pitch_um

    def _table(self, least: float, wanted: float) -> Table:
        """Return the lens tabulated out to ``least`` or farther: one that is there, or a new one out to ``wanted``."""
        there = [table for radius, table in self._tables if radius >= least]
        if not there:
            self._tables.append((wanted, self._tabulated(wanted)))
            there = [self._tables[-1][1]]
        return there[0]

    @functools.cached_property
    def _tables(self) -> list[tuple[float, Table]]:
        return []

    def _tabulated(self, radius: float) -> Table:
        """Tabulate the lens out to a distance, with as many wavelengths as it takes there."""
        phase = math.tau * radius * float(1.0 / self._blur.min() - 1.0 / self._blur.max())
        allowed = self.budget.allowed("own wavelengths")
        nm, weights = condensed(self.wavelength_nm, self.weights, phase=phase, allowed=allowed)
        return table_of(self.lens, self._blur_at(nm), weights.reshape(-1, nm.size), radius, self.budget.tolerance)

    @functools.cached_property
    def _listeners(self) -> F64:
        """Places (n, 2) of the frame: ends of outlines, moved into it, and its middle."""
        ends = self._ends[0]
        some = ends[:: max(1, len(ends) // LOOKED_AT)]
        low, high = self.corners[:2], self.corners[2:]
        return np.concatenate([np.clip(some, low, high), [0.5 * (low + high)]])

    @property
    def _farthest(self) -> float:
        """No piece reaches farther than this from any photosite."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        more = np.where(straight, 0.0, o.dx)
        x, y = np.concatenate([o.x, o.x + straight * o.dx]), np.concatenate([o.y, o.y + straight * o.dy])
        x0, y0, x1, y1 = self.corners
        across = np.maximum(np.abs(x - x0), np.abs(x - x1)) + np.tile(more, 2)
        down = np.maximum(np.abs(y - y0), np.abs(y - y1)) + np.tile(more, 2)
        return float(np.hypot(across, down).max(initial=0.0))

    @functools.cached_property
    def _ends(self) -> tuple[F64, F64]:
        """Ends of pieces (n, 2), and how strong each is: how its direction jumps, at most as at a right angle (1)."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        begin, finish = o.from_rad, o.from_rad + o.turn_rad
        first = np.stack([o.x + np.where(straight, 0.0, o.dx * np.cos(begin)), o.y + o.dx * ~straight * np.sin(begin)])
        last = np.stack(
            [
                o.x + np.where(straight, o.dx, o.dx * np.cos(finish)),
                o.y + np.where(straight, o.dy, o.dx * np.sin(finish)),
            ]
        )
        size = np.where(straight, np.hypot(o.dx, o.dy), 1.0)
        leaves = np.stack(
            [np.where(straight, o.dx / size, -np.sin(begin)), np.where(straight, o.dy / size, np.cos(begin))]
        )
        comes = np.stack(
            [np.where(straight, o.dx / size, -np.sin(finish)), np.where(straight, o.dy / size, np.cos(finish))]
        )
        points = np.round(np.concatenate([first, last], axis=1).T, 9)
        places, index = np.unique(points, axis=0, return_inverse=True)
        jump = np.zeros_like(places)
        np.add.at(jump, index.ravel(), np.concatenate([leaves, -comes], axis=1).T)
        return places, np.minimum(np.hypot(*jump.T) / math.sqrt(2.0), 1.0)

    def _feet(self, places: F64) -> tuple[F64, np.ndarray]:
        """Return (places, pieces): distance from each straight piece's line, and whether its foot lies on the piece."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        length = np.where(straight, np.hypot(o.dx, o.dy), 1.0)
        dx, dy = o.x - places[:, :1], o.y - places[:, 1:]
        h = (dx * o.dy - dy * o.dx) / length
        s = -(dx * o.dx + dy * o.dy) / length
        return h, straight & (s > 0.0) & (s < length)

    def _radius_at(self, place: F64) -> float:
        """Return how far E is taken from its table for one photosite: farther where rings meet in it."""
        o, blur, base = self.pieces.outlines, float(self._blur.max()), self.radius
        if not len(o.x):
            return base
        swing = self._swing
        allowed = self.budget.allowed("meeting")
        gap = np.hypot(o.x - place[0], o.y - place[1])
        about = (o.turn_rad > 0.0) & (gap < 0.3 * o.dx) & (o.dx > base)
        loud = swing * (base / np.maximum(o.dx, base)) ** FALLS * o.turn_rad / math.tau > allowed
        radius = float((o.dx + gap)[about & loud].max(initial=base - blur)) + blur
        h, beside = self._feet(place[None])
        length = np.hypot(o.dx, o.dy)
        far = beside[0] & (np.abs(h[0]) > base)
        if np.count_nonzero(far) > 2:
            distance = np.abs(h[0][far])
            share = np.minimum(length[far], np.sqrt(blur * distance)) / distance / math.tau
            shell = np.floor(distance / (0.5 * blur)).astype(np.int64)
            _, index = np.unique(shell, return_inverse=True)
            together = np.bincount(index.ravel(), weights=share)[index.ravel()]
            loud = swing * (base / distance) ** FALLS * together > allowed
            radius = max(radius, float(distance[loud].max(initial=base)) + blur)
        return radius

    @functools.cached_property
    def _swing(self) -> float:
        return self._swing_at(self.radius)

    def _swing_at(self, radius: float) -> float:
        """Return how far E swings about its smooth powers near a distance."""
        blur = float(self._blur.max())
        more = self._extent + 6.0 * blur
        # Twice as far: the search goes on from here, and most photosites take a table that is there.
        return loudness(self._table(radius + more, 2.0 * radius + more), radius, blur, *self.rule)
